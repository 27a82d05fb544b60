#include "taut/base/file_bytes.h"

#include "taut/base/error.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/resource.h>
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
        // Held as long as its process lives (removeAbandonedFiles). Where somebody took it for abandoned in between: another name.
        if (descriptor >= 0 && keepsName && flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
            close(descriptor);
            descriptor = -1;
            errno = EEXIST;
        }
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

void makeFolderOf(const std::string &path) {
    const fs::path folder = fs::path(path).parent_path();
    std::error_code error;
    if (!folder.empty()) fs::create_directories(folder, error);
    if (error) throw RunError(path + ": can't make its folder: " + error.message());
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
    flush();
    const int held = dup(fileno(file_)); // until it has its name, so that nobody thinks it abandoned
    const bool closed = std::fclose(file_) == 0;
    file_ = nullptr;
    const std::error_code error = closed ? rename() : std::error_code(errno, std::generic_category());
    if (held >= 0) close(held);
    if (error) fail(error.message());
}

void OutputFile::finishDurably() {
    flush();
    if (!partial_.empty() && fsync(fileno(file_)) != 0) fail(std::strerror(errno));
    finish();
    const std::string folder = fs::path(path_).parent_path().string();
    const int descriptor = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) return;
    static_cast<void>(fsync(descriptor)); // a file system that can't says so, and has done what it can
    close(descriptor);
}

std::error_code OutputFile::rename() {
    if (partial_.empty()) return {};
    std::error_code error;
    const std::lock_guard lock(unfinished().mutex);
    fs::rename(partial_, path_, error);
    if (error) return error;
    unfinished().names.erase(partial_);
    partial_.clear();
    return {};
}

int removeAbandonedFiles(const std::string &folder) {
    int removed = 0;
    std::error_code error;
    for (fs::directory_iterator it(folder.empty() ? fs::path(".") : fs::path(folder), error), end; !error && it != end;
         it.increment(error)) {
        const std::string name = it->path().filename().string();
        if (!name.starts_with(".taut-") || !name.ends_with(".partial")) continue;
        const int descriptor = open(it->path().c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW);
        if (descriptor < 0) continue;
        if (flock(descriptor, LOCK_EX | LOCK_NB) == 0 && std::remove(it->path().c_str()) == 0) ++removed;
        close(descriptor);
    }
    return removed;
}

std::FILE *openSpool(const std::string &path) {
    std::string name;
    std::FILE *file = openOwn(path, name, false);
    if (file == nullptr) throw RunError(path + ": could not be written: " + std::strerror(errno));
    return file;
}

void allowOpenFiles(std::size_t count) {
    constexpr rlim_t kOthers = 64;
    rlimit limit{};
    if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
    const rlim_t wanted = std::min(static_cast<rlim_t>(count) + kOthers, limit.rlim_max);
    if (limit.rlim_cur >= wanted) return;
    limit.rlim_cur = wanted;
    setrlimit(RLIMIT_NOFILE, &limit);
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
