#include "taut/base/content_hash.h"

#include "taut/base/error.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <array>
#include <cstdio>
#include <vector>

namespace taut {

struct ContentHash::State {
    State() { XXH3_128bits_reset(&xxh); }
    XXH3_state_t xxh;
};

ContentHash::ContentHash() : state_(std::make_unique<State>()) {}
ContentHash::~ContentHash() = default;

void ContentHash::add(const void *data, std::size_t size) {
    XXH3_128bits_update(&state_->xxh, data, size);
}

std::string ContentHash::text() const {
    const XXH128_hash_t hash = XXH3_128bits_digest(&state_->xxh);
    std::array<char, 33> digits{};
    std::snprintf(digits.data(), digits.size(), "%016llx%016llx", static_cast<unsigned long long>(hash.high64),
                  static_cast<unsigned long long>(hash.low64));
    return digits.data();
}

std::string contentHash(std::string_view bytes) {
    ContentHash hash;
    hash.add(bytes.data(), bytes.size());
    return hash.text();
}

std::string contentHashOfFile(const std::string &path) {
    const auto close = [](std::FILE *file) { std::fclose(file); };
    const std::unique_ptr<std::FILE, decltype(close)> file(std::fopen(path.c_str(), "rb"), close);
    ContentHash hash;
    std::vector<char> block(1 << 18);
    std::size_t size = 0;
    while (file && (size = std::fread(block.data(), 1, block.size(), file.get())) > 0) hash.add(block.data(), size);
    if (!file || std::ferror(file.get()) != 0) failInput({path, 0, 0, -1}, "a file that can't be read", "a readable one");
    return hash.text();
}

} // namespace taut
