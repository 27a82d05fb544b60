#include "taut/base/file_bytes.h"

#include "taut/base/error.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <set>

namespace taut {

namespace fs = std::filesystem;

namespace {

/// Names of files that are being written.
struct Unfinished {
    std::mutex mutex;
    std::set<std::string> names;
};
Unfinished &unfinished() {
    static auto *all = new Unfinished; // lives as long as any thread
    return *all;
}

/// A new file in the folder of `path`, under a name that no process has taken; null where it can't be made. It is short whatever the
/// file will be called. `keepsName`: it is listed as unfinished; else the name is removed at once.
std::FILE *openOwn(const std::string &path, std::string &name, bool keepsName) {
    static std::atomic<unsigned> number{0};
    const fs::path folder = fs::path(path).parent_path();
    const std::lock_guard lock(unfinished().mutex);
    int descriptor = -1;
    do {
        name = (folder / (".taut-" + std::to_string(getpid()) + "-" + std::to_string(number++) + ".partial")).string();
        descriptor = open(name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    } while (descriptor < 0 && errno == EEXIST);
    std::FILE *file = descriptor < 0 ? nullptr : fdopen(descriptor, "w+b");
    const int error = errno;
    if (file != nullptr && keepsName) {
        unfinished().names.insert(name);
        return file;
    }
    if (descriptor >= 0) std::remove(name.c_str());
    if (descriptor >= 0 && file == nullptr) close(descriptor);
    name.clear();
    errno = error;
    return file;
}

} // namespace

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

OutputFile::OutputFile(const std::string &path) : path_(path) {
    std::error_code ignored;
    const fs::file_status status = fs::status(path, ignored);
    if (fs::exists(status) && !fs::is_regular_file(status))
        file_ = std::fopen(path.c_str(), "wb");
    else
        file_ = openOwn(path, partial_, true);
    if (file_ == nullptr) fail(std::strerror(errno));
}

OutputFile::~OutputFile() {
    discard();
}

void OutputFile::discard() {
    if (file_ != nullptr) std::fclose(file_);
    file_ = nullptr;
    if (partial_.empty()) return;
    const std::lock_guard lock(unfinished().mutex);
    unfinished().names.erase(partial_);
    std::remove(partial_.c_str());
    partial_.clear();
}

void OutputFile::fail(const std::string &what) {
    discard();
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

void OutputFile::flush() {
    if (std::fflush(file_) != 0) fail(std::strerror(errno));
}

void OutputFile::finish() {
    const bool closed = std::fclose(file_) == 0;
    file_ = nullptr;
    if (!closed) fail(std::strerror(errno));
    if (partial_.empty()) return;
    std::error_code error;
    {
        const std::lock_guard lock(unfinished().mutex);
        fs::rename(partial_, path_, error);
        if (!error) unfinished().names.erase(partial_);
    }
    if (error) fail(error.message());
    partial_.clear();
}

std::FILE *openSpool(const std::string &path) {
    std::string name;
    std::FILE *file = openOwn(path, name, false);
    if (file == nullptr) throw RunError(path + ": could not be written: " + std::strerror(errno));
    return file;
}

void abandonOutputFiles() {
    unfinished().mutex.lock(); // for good
    for (const std::string &name : unfinished().names) std::remove(name.c_str());
}

void writeFileWhole(const std::string &path, std::string_view bytes) {
    OutputFile out(path);
    out.write(bytes);
    out.finish();
}

} // namespace taut
