#include "taut/base/file_bytes.h"

#include "taut/base/error.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
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

OutputFile::OutputFile(const std::string &path) : path_(path), partial_(path + ".partial") {
    file_ = std::fopen(partial_.c_str(), "wb");
    if (file_ == nullptr) fail(std::strerror(errno));
}

OutputFile::~OutputFile() {
    if (file_ == nullptr) return;
    std::fclose(file_);
    std::remove(partial_.c_str());
}

void OutputFile::fail(const std::string &what) {
    if (file_ != nullptr) {
        std::fclose(file_);
        std::remove(partial_.c_str());
        file_ = nullptr;
    }
    throw RunError(path_ + ": could not be written: " + what);
}

void OutputFile::write(std::string_view bytes) {
    if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) fail(std::strerror(errno));
}

void OutputFile::patch(long offset, std::string_view bytes) {
    if (std::fseek(file_, offset, SEEK_SET) != 0) fail(std::strerror(errno));
    write(bytes);
    if (std::fseek(file_, 0, SEEK_END) != 0) fail(std::strerror(errno));
}

void OutputFile::finish() {
    const bool closed = std::fclose(file_) == 0;
    file_ = nullptr;
    const std::string reason = std::strerror(errno);
    std::error_code error;
    if (closed) fs::rename(partial_, path_, error);
    if (closed && !error) return;
    std::remove(partial_.c_str());
    fail(closed ? error.message() : reason);
}

void writeFileWhole(const std::string &path, std::string_view bytes) {
    OutputFile out(path);
    out.write(bytes);
    out.finish();
}

} // namespace taut
