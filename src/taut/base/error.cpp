#include "taut/base/error.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numeric>

namespace taut {

namespace {

std::string singleLine(std::string text) {
    for (char &c : text)
        if (c == '\n' || c == '\r' || c == '\t') c = ' ';
    return text;
}

/// Optimal string alignment distance: insert, delete, substitute, swap neighbours.
std::size_t editDistance(std::string_view a, std::string_view b) {
    std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
    for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
    std::iota(d[0].begin(), d[0].end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i)
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t substitution = d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
            d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, substitution});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
        }
    return d[a.size()][b.size()];
}

} // namespace

std::string Location::text() const {
    std::string out = singleLine(file);
    if (line > 0) out += ":" + std::to_string(line);
    if (line > 0 && column > 0) out += ":" + std::to_string(column);
    if (byteOffset >= 0) out += ": byte " + std::to_string(byteOffset);
    return out;
}

InputError::InputError(const std::string &line) : std::runtime_error(singleLine(line)) {}
RunError::RunError(const std::string &line) : std::runtime_error(singleLine(line)) {}

void failInput(const Location &where, std::string_view found, std::string_view expected) {
    throw InputError(where.text() + ": found " + std::string(found) + ", expected " + std::string(expected));
}

void failUnknownName(const Location &where, std::string_view found, std::span<const std::string_view> valid) {
    std::string expected = valid.size() > 1 ? "one of " : "";
    for (std::size_t i = 0; i < valid.size(); ++i) expected += (i != 0 ? ", " : "") + std::string(valid[i]);
    expected += "; did you mean " + quoted(nearestName(found, valid)) + "?";
    failInput(where, quoted(found), expected);
}

std::string_view nearestName(std::string_view name, std::span<const std::string_view> valid) {
    std::string_view best;
    std::size_t bestDistance = std::string_view::npos;
    const std::string_view start = name.substr(0, 64);
    for (const std::string_view candidate : valid) {
        const std::size_t distance = editDistance(start, candidate);
        if (distance < bestDistance) {
            best = candidate;
            bestDistance = distance;
        }
    }
    return best;
}

std::string quoted(std::string_view text) {
    constexpr std::size_t kLongest = 256; // a long path is told by its whole; of what is longer, both ends are
    constexpr std::size_t kEnd = 64;
    const auto printable = [](std::string_view part) {
        std::string out;
        for (const char c : part) {
            if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7f) {
                char escaped[5];
                std::snprintf(escaped, sizeof escaped, "\\x%02x", static_cast<unsigned>(static_cast<unsigned char>(c)));
                out += escaped;
            } else {
                out += c;
            }
        }
        return out;
    };
    if (text.size() <= kLongest) return "'" + printable(text) + "'";
    return "'" + printable(text.substr(0, kEnd)) + "..." + printable(text.substr(text.size() - kEnd)) + "'";
}

void Warnings::add(std::string line) {
    line = singleLine(std::move(line));
    const std::size_t hash = std::hash<std::string>{}(line);
    const auto [first, last] = places_.equal_range(hash);
    if (std::any_of(first, last, [&](const auto &known) { return known.second < lines.size() && lines[known.second] == line; })) return;
    places_.emplace(hash, lines.size());
    lines.push_back(std::move(line));
}

std::string formatNumber(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    if (value == 0 || std::abs(value) >= 1e-3) return text;
    // %g writes 0.0001 and 1e-05 where people write 1e-4 and 1e-5.
    for (int digits = 0; digits < 6; ++digits) {
        char scientific[32];
        std::snprintf(scientific, sizeof scientific, "%.*e", digits, value);
        if (std::abs(std::strtod(scientific, nullptr) - value) > 1e-6 * std::abs(value)) continue;
        std::string out = scientific;
        const std::size_t zero = out.find("e-0");
        if (zero != std::string::npos) out.erase(zero + 2, 1);
        return out;
    }
    return text;
}

} // namespace taut
