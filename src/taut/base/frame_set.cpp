#include "taut/base/frame_set.h"

#include <algorithm>
#include <charconv>
#include <unordered_set>

namespace taut {

namespace {

constexpr int kMostFrames = 1'000'000;

/// Reads an integer at the front of `text` and removes it.
std::optional<int> takeInt(std::string_view &text) {
    int value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc()) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return value;
}

bool takeChar(std::string_view &text, char c) {
    if (text.empty() || text.front() != c) return false;
    text.remove_prefix(1);
    return true;
}

struct Pattern {
    std::size_t begin = std::string_view::npos;
    std::size_t length = 0;
    int width = 0;
};

/// In the file's own name.
Pattern findPattern(std::string_view path) {
    constexpr int kWidest = 16;                   // of a printf: what is wider was not meant as one
    const std::size_t name = path.rfind('/') + 1; // npos + 1 is 0
    const std::size_t last = path.rfind('#');
    if (last != std::string_view::npos && last >= name) {
        std::size_t first = last;
        while (first > name && path[first - 1] == '#') --first;
        return {first, last - first + 1, static_cast<int>(last - first + 1)};
    }
    for (std::size_t i = path.size(); i-- > name;) {
        if (path.substr(i, 2) != "%0") continue;
        std::string_view rest = path.substr(i + 2);
        const int width = takeInt(rest).value_or(0);
        if (width >= 1 && width <= kWidest && takeChar(rest, 'd')) return {i, path.size() - i - rest.size(), width};
    }
    return {};
}

} // namespace

std::vector<int> parseFrameSet(std::string_view text, const Location &where) {
    constexpr std::string_view kExpected = "a frame set such as 1-48, 1-5,9 or 1-100x5";
    struct Range {
        long long first, last, direction;
    };
    std::vector<Range> ranges;
    long long total = 0;
    std::string_view rest = text;
    do {
        const auto first = takeInt(rest);
        if (!first) failInput(where, quoted(text), kExpected);
        int last = *first;
        int step = 1;
        if (takeChar(rest, '-')) {
            const auto end = takeInt(rest);
            if (!end) failInput(where, quoted(text), kExpected);
            last = *end;
            if (takeChar(rest, 'x')) {
                const auto by = takeInt(rest);
                if (!by || *by < 1) failInput(where, quoted(text), kExpected);
                step = *by;
            }
        }
        const long long direction = last >= *first ? step : -static_cast<long long>(step);
        // Counted before any frame is made: no text is long enough to overflow the sum before the limit ends it.
        total += (static_cast<long long>(last) - *first) / direction + 1;
        if (total > kMostFrames) failInput(where, quoted(text), "at most a million frames in all ranges together");
        ranges.push_back({*first, last, direction});
    } while (takeChar(rest, ','));
    if (!rest.empty()) failInput(where, quoted(text), kExpected);
    std::vector<int> frames;
    std::unordered_set<int> seen;
    for (const auto &[first, last, direction] : ranges)
        for (long long f = first; direction > 0 ? f <= last : f >= last; f += direction)
            if (seen.insert(static_cast<int>(f)).second) frames.push_back(static_cast<int>(f));
    return frames;
}

bool hasFramePattern(std::string_view path) {
    return findPattern(path).begin != std::string_view::npos;
}

std::string pathOfFrame(std::string_view pattern, int frame) {
    const Pattern found = findPattern(pattern);
    if (found.begin == std::string_view::npos) return std::string(pattern);
    std::string number = std::to_string(frame);
    const std::size_t digits = frame < 0 ? 1 : 0; // behind the sign
    const auto width = static_cast<std::size_t>(found.width);
    if (number.size() < width) number.insert(digits, width - number.size(), '0');
    return std::string(pattern.substr(0, found.begin)) + number + std::string(pattern.substr(found.begin + found.length));
}

std::optional<int> frameOfPath(std::string_view pattern, std::string_view path) {
    const Pattern found = findPattern(pattern);
    if (found.begin == std::string_view::npos || path.size() + found.length <= pattern.size()) return std::nullopt;
    std::string_view number = path.substr(found.begin, path.size() + found.length - pattern.size());
    const std::optional<int> frame = takeInt(number);
    return frame && pathOfFrame(pattern, *frame) == path ? frame : std::nullopt;
}

} // namespace taut
