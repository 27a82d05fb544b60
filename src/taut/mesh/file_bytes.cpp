#include "taut/mesh/file_bytes.h"

#include "taut/base/error.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace taut {

namespace fs = std::filesystem;

std::string readFileBytes(const std::string &path) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (!fs::exists(status)) throw InputError(path + ": found no such file, expected a readable file");
    if (!fs::is_regular_file(status)) throw InputError(path + ": found something that is not a file, expected a readable file");
    const std::uintmax_t size = fs::file_size(path, error);
    std::ifstream in(path, std::ios::binary);
    if (error || !in) throw InputError(path + ": found a file that cannot be opened, expected a readable file");
    std::string bytes(static_cast<std::size_t>(size), '\0');
    in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (in.bad()) throw InputError(path + ": found a file that cannot be read, expected a readable file");
    bytes.resize(static_cast<std::size_t>(in.gcount()));
    return bytes;
}

std::string lowerExtension(std::string_view path) {
    std::string extension = fs::path(path).extension().string();
    if (!extension.empty()) extension.erase(0, 1);
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    return extension;
}

void writeFileWhole(const std::string &path, std::string_view bytes) {
    const std::string partial = path + ".partial";
    {
        std::ofstream out(partial, std::ios::binary | std::ios::trunc);
        out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        out.close();
        if (!out) throw RunError(partial + ": could not be written");
    }
    std::error_code error;
    fs::rename(partial, path, error);
    if (error) throw RunError(path + ": could not be written: " + error.message());
}

} // namespace taut
