#pragma once
/// What input may ask for: memory and work are counted before they are spent, over everything that is asked for together (docs/limits.md).

#include <atomic>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace taut {

/// Memory that a scene may ask for, bytes, unless a limit is set by hand. With what a process takes before it reads anything this stays
/// below 1 GB.
inline constexpr double kDefaultMemory = 768.0 * (1 << 20);
/// Large files make large scenes: a limit is at least so many times the bytes that were read. From 6 MB on that is more than the default.
inline constexpr double kMemoryPerInputByte = 128;
/// Seconds that may be foreseen for one frame of everything, on a common machine's core; in proportion where memory is allowed more.
inline constexpr double kDefaultSeconds = 4;

/// One account, that of a scene. May be used from several threads.
class Budget {
  public:
    /// The default limit, or what the environment variable TAUT_MAX_MEMORY says (memorySize). Throws InputError where that says nothing.
    Budget();
    /// `bytes`: a limit that was set by hand.
    explicit Budget(double bytes) : byHand_(bytes) {}
    Budget(const Budget &) = delete;
    Budget &operator=(const Budget &) = delete;

    /// A file of so many bytes was read.
    void addInput(std::size_t bytes);
    /// Bytes that may be asked for by all together.
    [[nodiscard]] double most() const;
    /// Bytes of them that nothing has asked for.
    [[nodiscard]] double left() const { return most() - taken_.load(); }

    /// Counts bytes that stay. Throws LimitError("PLACE: found WHAT, ...") where they don't fit. Counts are doubles, whose products do not
    /// wrap.
    void take(double bytes, std::string_view place, std::string_view what);
    /// Whether bytes that are given back soon fit beside those that stay; throws as take().
    void require(double bytes, std::string_view place, std::string_view what) const;
    /// Counts seconds of a frame; throws likewise.
    void work(double seconds, std::string_view place, std::string_view what);

  private:
    std::optional<double> byHand_;
    std::atomic<double> input_ = 0;
    std::atomic<double> taken_ = 0;
    std::atomic<double> seconds_ = 0;
};

/// "8g", "512m", "64k" or bytes. Throws InputError that names `option`.
double memorySize(const std::string &text, std::string_view option);

} // namespace taut
