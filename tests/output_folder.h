#pragma once
/// Where a test writes: a folder that no other test case uses, since many of them run at a time.

#include "catch.h"

#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace taut::test {

/// The folder of the running test case, by its name; made on first use. What a test left there can be looked at.
inline std::filesystem::path outputOfTest() {
    std::string name = Catch::getResultCapture().getCurrentTestName();
    for (char &c : name)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
    const std::filesystem::path path = std::filesystem::path(TAUT_TEST_OUTPUT) / name;
    std::filesystem::create_directories(path);
    return path;
}

/// A folder in it; made on first use.
inline std::string outputFolder(const std::string &name) {
    const std::filesystem::path path = outputOfTest() / name;
    std::filesystem::create_directories(path);
    return path.string();
}

/// Such a folder, emptied of what an earlier run left.
inline std::string freshFolder(const std::string &name) {
    std::filesystem::remove_all(outputOfTest() / name);
    return outputFolder(name);
}

inline std::string readBytes(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

} // namespace taut::test
