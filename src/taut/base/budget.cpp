#include "taut/base/budget.h"

#include "taut/base/error.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

namespace taut {

namespace {

constexpr double kMega = 1 << 20;

std::string megabytes(double bytes) {
    return formatNumber(std::ceil(bytes / kMega)) + " MB";
}

} // namespace

Budget::Budget() {
    if (const char *given = std::getenv("TAUT_MAX_MEMORY"); given != nullptr && *given != '\0')
        byHand_ = memorySize(given, "TAUT_MAX_MEMORY");
}

void Budget::addInput(std::size_t bytes) {
    input_.fetch_add(static_cast<double>(bytes));
}

double Budget::most() const {
    return byHand_.value_or(std::max(kDefaultMemory, kMemoryPerInputByte * input_.load()));
}

void Budget::take(double bytes, std::string_view place, std::string_view what) {
    require(bytes, place, what);
    taken_.fetch_add(bytes);
}

void Budget::require(double bytes, std::string_view place, std::string_view what) const {
    const double sum = taken_.load() + bytes;
    if (sum <= most()) return;
    throw LimitError(std::string(place) + ": found " + std::string(what) + ", with which the scene takes " + megabytes(sum) +
                     ", expected at most " + megabytes(most()) + " (--max-memory or TAUT_MAX_MEMORY allows more)");
}

void Budget::work(double seconds, std::string_view place, std::string_view what) {
    const double sum = seconds_.load() + seconds;
    const double allowed = kDefaultSeconds * std::max(1.0, most() / kDefaultMemory);
    if (!(sum <= allowed))
        throw LimitError(std::string(place) + ": found " + std::string(what) + ", with which a frame takes " +
                         formatNumber(std::ceil(sum)) + " s to prepare, expected at most " + formatNumber(std::ceil(allowed)) +
                         " s (--max-memory or TAUT_MAX_MEMORY allows more, in proportion)");
    seconds_.fetch_add(seconds);
}

double memorySize(const std::string &text, std::string_view option) {
    double number = 0;
    const char *end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, number);
    const std::string_view unit(stop, static_cast<std::size_t>(end - stop));
    const auto scale = [](std::string_view name) {
        if (name.empty()) return 1.0;
        const char first = name.front() >= 'A' && name.front() <= 'Z' ? static_cast<char>(name.front() + 32) : name.front();
        if (name.size() > 1) return 0.0;
        return first == 'k' ? 0x1p10 : first == 'm' ? 0x1p20 : first == 'g' ? 0x1p30 : first == 't' ? 0x1p40 : 0.0;
    };
    if (error != std::errc() || !(number > 0) || !std::isfinite(number) || scale(unit) == 0)
        failInput({std::string(option)}, quoted(text), "an amount of memory such as 8g or 512m");
    return number * scale(unit);
}

} // namespace taut
