#pragma once
/// What tells the contents of files apart: the XXH3 hash of 128 bits. Against mistakes, not against forgers.

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace taut {

/// Takes bytes piece by piece.
class ContentHash {
  public:
    ContentHash();
    ~ContentHash();
    ContentHash(const ContentHash &) = delete;
    ContentHash &operator=(const ContentHash &) = delete;

    void add(const void *data, std::size_t size);
    /// 32 hexadecimal digits, of all that was added so far.
    [[nodiscard]] std::string text() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

std::string contentHash(std::string_view bytes);

/// Of a file, which is read piece by piece. Throws InputError where it can't be read.
std::string contentHashOfFile(const std::string &path);

} // namespace taut
