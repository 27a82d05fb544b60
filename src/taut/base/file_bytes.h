#pragma once
/// Whole files as bytes, files written piece by piece, and what the mesh readers need to know about a path.

#include <cstdio>
#include <string>
#include <string_view>
#include <system_error>

namespace taut {

/// The bytes of a regular file. Throws InputError where it is missing, is not a regular file or cannot be read.
std::string readFileBytes(const std::string &path);

/// 3 where a text begins with the byte order mark of UTF-8, which some editors write; else 0.
inline std::size_t sizeOfByteOrderMark(std::string_view text) {
    return text.substr(0, 3) == "\xef\xbb\xbf" ? 3 : 0;
}

/// The extension of `path` without its dot, in lower case.
std::string lowerExtension(std::string_view path);

/// Makes the folder of `path` where there is none. Throws RunError.
void makeFolderOf(const std::string &path);

/// A file written piece by piece beside `path` and renamed by finish(), so that `path` is never half written. Until then it has a name
/// that no other process has: of several that write the same path the last to finish stays. Without finish() nothing is left
/// behind. What is there and is no regular file (/dev/stdout, a pipe) is written directly. Throws RunError where a write fails.
class OutputFile {
  public:
    explicit OutputFile(const std::string &path);
    OutputFile(const OutputFile &) = delete;
    OutputFile &operator=(const OutputFile &) = delete;
    ~OutputFile();

    void write(std::string_view bytes);
    void write(const void *data, std::size_t size) { write({static_cast<const char *>(data), size}); }
    /// Overwrites `bytes` at `offset`, which is already written; what follows goes on at the end.
    void patch(long offset, std::string_view bytes);
    /// Brings what was written to the disk, so that finish() has little left that can fail: before several files are finished together.
    void flush();
    void finish();
    /// finish(), with the bytes and then the name on the disk itself, so that a machine which fails keeps the old file or the new one.
    void finishDurably();

  private:
    [[noreturn]] void fail(const std::string &what);

    void discard();
    /// Gives the file its name.
    std::error_code rename();

    std::string path_;
    std::string partial_; ///< empty where `path_` is written directly
    std::FILE *file_ = nullptr;
};

/// Removes what processes that were killed have left half written in a folder: files that OutputFile made and nobody holds any more.
/// Returns how many.
int removeAbandonedFiles(const std::string &folder);

/// A stream for what is read back before its process ends, on the disk of `path`. It has no name, so nothing can be left behind.
/// Throws RunError.
std::FILE *openSpool(const std::string &path);

/// Allows this process so many open files at a time beside the few that it has, as far as the system lets it: where that is not enough,
/// opening one says so.
void allowOpenFiles(std::size_t count);

/// For a process that is about to end where it stands: removes every unfinished OutputFile and keeps threads that still run from
/// starting or finishing any.
void abandonOutputFiles();

/// Writes `bytes` as one OutputFile.
void writeFileWhole(const std::string &path, std::string_view bytes);

} // namespace taut
