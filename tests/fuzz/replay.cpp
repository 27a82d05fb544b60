/// Harnesses without libFuzzer, for any compiler: over files, to see what one does or what a corpus covers; and the seeds as files.

#include "harness.h"

#include "taut/base/file_bytes.h"

#include <cstdio>
#include <exception>
#include <filesystem>

namespace fs = std::filesystem;

namespace {

void writeSeeds(const fs::path &folder) {
    for (const taut::fuzz::Harness &harness : taut::fuzz::harnesses()) {
        fs::create_directories(folder / harness.name);
        int number = 0;
        for (const std::string &seed : harness.seeds())
            taut::writeFileWhole((folder / harness.name / ("seed" + std::to_string(number++))).string(), seed);
        std::printf("%s\n", std::string(harness.name).c_str());
    }
}

int replay(const taut::fuzz::Harness &harness, const std::vector<std::string> &paths) {
    std::size_t count = 0;
    const auto run = [&](const std::string &path) {
        ++count;
        try {
            harness.run(taut::readFileBytes(path));
        } catch (const std::exception &error) {
            std::printf("%s: %s\n", path.c_str(), error.what());
            return 1;
        }
        return 0;
    };
    int failed = 0;
    for (const std::string &path : paths) {
        if (!fs::is_directory(path)) {
            failed += run(path);
            continue;
        }
        for (const auto &entry : fs::directory_iterator(path))
            if (entry.is_regular_file()) failed += run(entry.path().string());
    }
    std::printf("%s: %zu inputs, %d findings\n", std::string(harness.name).c_str(), count, failed);
    return failed > 0 ? 1 : 0;
}

} // namespace

int main(int argc, char **argv) {
    const std::vector<std::string> words(argv + 1, argv + argc);
    try {
        if (words.size() == 2 && words[0] == "--seeds") {
            writeSeeds(words[1]);
            return 0;
        }
        if (words.size() >= 2) return replay(taut::fuzz::harnessNamed(words[0]), {words.begin() + 1, words.end()});
    } catch (const std::exception &error) {
        std::fprintf(stderr, "taut_fuzz_replay: %s\n", error.what());
        return 2;
    }
    std::fprintf(stderr, "taut_fuzz_replay HARNESS FILE-OR-FOLDER..., or taut_fuzz_replay --seeds FOLDER\n");
    return 2;
}
