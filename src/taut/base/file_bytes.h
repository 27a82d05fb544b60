#pragma once
/// Whole files as bytes, files written piece by piece, and what the mesh readers need to know about a path.

#include <cstdio>
#include <string>
#include <string_view>

namespace taut {

/// The bytes of a regular file. Throws InputError where it is missing, is not a regular file or cannot be read.
std::string readFileBytes(const std::string &path);

/// The extension of `path` without its dot, in lower case.
std::string lowerExtension(std::string_view path);

/// A file written piece by piece beside `path` and renamed by finish(), so that `path` is never half written. Without finish()
/// nothing is left behind. Throws RunError where a write fails.
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
    void finish();

  private:
    [[noreturn]] void fail(const std::string &what);

    std::string path_;
    std::string partial_;
    std::FILE *file_ = nullptr;
};

/// Writes `bytes` as one OutputFile.
void writeFileWhole(const std::string &path, std::string_view bytes);

} // namespace taut
