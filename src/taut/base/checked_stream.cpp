#include "taut/base/checked_stream.h"

#include "taut/base/error.h"

#include <algorithm>
#include <cstdio>
#include <vector>

namespace taut {

namespace {

constexpr std::size_t kBlock = 1 << 18;
constexpr std::size_t kDigits = 32;

} // namespace

class CheckedWriter::Buffer final : public std::streambuf {
  public:
    explicit Buffer(const std::string &path) : file_(path) {}

    void finish() {
        const std::string digits = hash_.text();
        file_.write(digits);
        file_.finishDurably();
    }

  protected:
    std::streamsize xsputn(const char *data, std::streamsize size) override {
        hash_.add(data, static_cast<std::size_t>(size));
        file_.write(data, static_cast<std::size_t>(size));
        return size;
    }
    int_type overflow(int_type c) override {
        const char byte = traits_type::to_char_type(c);
        xsputn(&byte, 1);
        return c;
    }

  private:
    OutputFile file_;
    ContentHash hash_;
};

CheckedWriter::CheckedWriter(const std::string &path)
    : buffer_(std::make_unique<Buffer>(path)), stream_(std::make_unique<std::ostream>(buffer_.get())) {
    stream_->exceptions(std::ios::badbit); // a RunError of the file comes out as itself
}
CheckedWriter::~CheckedWriter() = default;

std::ostream &CheckedWriter::stream() {
    return *stream_;
}

void CheckedWriter::finish() {
    buffer_->finish();
}

class CheckedReader::Buffer final : public std::streambuf {
  public:
    explicit Buffer(const std::string &path) : path_(path), file_(std::fopen(path.c_str(), "rb")), block_(kBlock) {
        if (file_ == nullptr || std::fseek(file_, 0, SEEK_END) != 0) fail("a file that can't be read", "a readable one");
        const long size = std::ftell(file_);
        std::rewind(file_);
        if (size < static_cast<long>(kDigits)) fail("its end early", "what a saved frame holds");
        left_ = size_ = static_cast<std::size_t>(size) - kDigits;
    }
    ~Buffer() override {
        if (file_ != nullptr) std::fclose(file_);
    }

    void finish() {
        if (left_ > 0 || gptr() != egptr()) fail("bytes after its end", "none");
        std::string digits(kDigits, ' ');
        if (std::fread(digits.data(), 1, kDigits, file_) != kDigits || digits != hash_.text())
            fail("bytes that are not those which were written (hash)", "the file as it was written");
    }

  protected:
    int_type underflow() override {
        const std::size_t size = std::fread(block_.data(), 1, std::min(block_.size(), left_), file_);
        if (size == 0) return traits_type::eof();
        left_ -= size;
        hash_.add(block_.data(), size);
        setg(block_.data(), block_.data(), block_.data() + size);
        return traits_type::to_int_type(block_.front());
    }

    /// Tells where it is and where it ends; it reads on only from where it is.
    pos_type seekoff(off_type offset, std::ios::seekdir from, std::ios::openmode) override {
        const auto here = static_cast<off_type>(size_ - left_) - (egptr() - gptr());
        if (offset != 0 || from == std::ios::beg) return off_type{-1};
        return from == std::ios::end ? static_cast<off_type>(size_) : here;
    }
    pos_type seekpos(pos_type position, std::ios::openmode which) override {
        return position == seekoff(0, std::ios::cur, which) ? position : pos_type(off_type{-1});
    }

  private:
    [[noreturn]] void fail(std::string_view found, std::string_view expected) const { failInput({path_, 0, 0, -1}, found, expected); }

    std::string path_;
    std::FILE *file_ = nullptr;
    std::vector<char> block_;
    std::size_t size_ = 0; ///< bytes before the hash
    std::size_t left_ = 0; ///< of them not yet read
    ContentHash hash_;
};

CheckedReader::CheckedReader(const std::string &path)
    : buffer_(std::make_unique<Buffer>(path)), stream_(std::make_unique<std::istream>(buffer_.get())) {}
CheckedReader::~CheckedReader() = default;

std::istream &CheckedReader::stream() {
    return *stream_;
}

void CheckedReader::finish() {
    buffer_->finish();
}

} // namespace taut
