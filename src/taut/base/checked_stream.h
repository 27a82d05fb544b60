#pragma once
/// Streams to and from files that end in the hash of what stands before it, so that a file which was cut short or damaged is known.

#include "taut/base/content_hash.h"
#include "taut/base/file_bytes.h"

#include <cstdint>
#include <istream>
#include <memory>
#include <ostream>
#include <streambuf>
#include <string>

namespace taut {

/// Written beside `path`, brought to the disk and renamed by finish(); what was there stays until then. Throws RunError where a write
/// fails, out of the stream's own operations too.
class CheckedWriter {
  public:
    explicit CheckedWriter(const std::string &path);
    ~CheckedWriter();
    CheckedWriter(const CheckedWriter &) = delete;
    CheckedWriter &operator=(const CheckedWriter &) = delete;

    [[nodiscard]] std::ostream &stream();
    void finish();

  private:
    class Buffer;
    std::unique_ptr<Buffer> buffer_;
    std::unique_ptr<std::ostream> stream_;
};

/// The stream ends where the hash begins. Throws InputError where the file can't be read.
class CheckedReader {
  public:
    explicit CheckedReader(const std::string &path);
    ~CheckedReader();
    CheckedReader(const CheckedReader &) = delete;
    CheckedReader &operator=(const CheckedReader &) = delete;

    [[nodiscard]] std::istream &stream();
    /// After all was read. Throws InputError where there is more, or where the hash is that of other bytes.
    void finish();

  private:
    class Buffer;
    std::unique_ptr<Buffer> buffer_;
    std::unique_ptr<std::istream> stream_;
};

} // namespace taut
