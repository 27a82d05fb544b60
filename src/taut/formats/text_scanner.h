#pragma once
/// Words and numbers of a text, each with its line and column. A line is read word by word; nothing is copied. Lines end in LF, CR LF
/// or CR; a byte order mark before the first is skipped.

#include "taut/base/error.h"
#include "taut/base/file_bytes.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>

namespace taut {

class TextScanner {
  public:
    /// `comment`: a word that starts with this character ends its line (0: none). `continuation`: a backslash before the
    /// end of a line joins the next one.
    TextScanner(std::string_view text, std::string file, char comment = 0, bool continuation = false)
        : text_(text), file_(std::move(file)), comment_(comment), continuation_(continuation), pos_(sizeOfByteOrderMark(text)),
          wordPos_(pos_), lineStart_(pos_) {}

    [[nodiscard]] bool atEnd() const { return pos_ >= text_.size(); }
    /// Bytes before the next unread character.
    [[nodiscard]] std::size_t position() const { return pos_; }
    [[nodiscard]] std::size_t remaining() const { return text_.size() - pos_; }

    /// Skips what is left of this line and its end; false where no line follows. `crAlone`: a LF behind a CR is not part of the end.
    bool nextLine(bool crAlone = false) {
        while (!atEnd() && !isLineEnd(text_[pos_])) ++pos_;
        if (atEnd()) return false;
        startLine(crAlone);
        return !atEnd();
    }
    /// True before the end of a line that is a CR without a LF.
    [[nodiscard]] bool atLoneCr() const { return text_.substr(pos_, 1) == "\r" && text_.substr(pos_, 2) != "\r\n"; }

    /// Skips lines without a word; false where none is left.
    bool skipEmptyLines() {
        do {
            skipBlanks();
            if (!atEnd() && !isLineEnd(text_[pos_]) && !atComment()) return true;
        } while (nextLine());
        return false;
    }

    /// The next word of this line; empty at its end. where() is its place.
    std::string_view word() {
        skipBlanks();
        wordPos_ = pos_;
        if (atComment()) return {};
        while (!atEnd() && !isBlank(text_[pos_]) && !isLineEnd(text_[pos_]) && !atContinuation()) ++pos_;
        return text_.substr(wordPos_, pos_ - wordPos_);
    }

    /// The next word of the text, on this line or a later one; empty at the end of the text.
    std::string_view wordAcrossLines() {
        std::string_view found = word();
        while (found.empty() && nextLine()) found = word();
        return found;
    }

    /// The rest of this line without the blanks around it.
    std::string_view restOfLine() {
        skipBlanks();
        wordPos_ = pos_;
        while (!atEnd() && !isLineEnd(text_[pos_])) ++pos_;
        std::size_t end = pos_;
        while (end > wordPos_ && isBlank(text_[end - 1])) --end;
        return text_.substr(wordPos_, end - wordPos_);
    }

    /// Place of the last word read, `offset` bytes into it.
    [[nodiscard]] Location where(std::size_t offset = 0) const {
        return {file_, line_, static_cast<int>(wordPos_ - lineStart_ + offset) + 1, -1};
    }

    /// The next word of this line as a finite float.
    float number(std::string_view expected) { return toFloat(word(), expected); }
    /// The next word of this line as an integer.
    std::int64_t integer(std::string_view expected) { return toInteger(word(), expected); }

    /// Fails at the last word unless nothing else stands on this line.
    void endLine() {
        const std::string_view more = word();
        if (!more.empty()) failInput(where(), taut::quoted(more), "the end of the line");
    }

    float toFloat(std::string_view token, std::string_view expected) const {
        double value = 0;
        if (!parse(token, value)) fail(token, expected);
        if (!(std::fabs(value) <= std::numeric_limits<float>::max()))
            failInput(where(), taut::quoted(token), "a finite number within float's range");
        return static_cast<float>(value);
    }

    /// As toFloat; what is not finite, in any spelling that programs write ("nan", "-nan(ind)", "-1.#IND", "inf"), is not a number.
    float toFloatOrNan(std::string_view token, std::string_view expected) const {
        double value = 0;
        if (!parse(token, value)) {
            if (!isSpelledNotFinite(token)) fail(token, expected);
            return std::numeric_limits<float>::quiet_NaN();
        }
        return std::fabs(value) <= std::numeric_limits<float>::max() ? static_cast<float>(value) : std::numeric_limits<float>::quiet_NaN();
    }

    std::int64_t toInteger(std::string_view token, std::string_view expected) const {
        std::int64_t value = 0;
        if (!parse(token, value)) fail(token, expected);
        return value;
    }

    /// Throws at the last word: found `token`, or the end of the line or file where it is empty.
    [[noreturn]] void fail(std::string_view token, std::string_view expected) const {
        failInput(where(), !token.empty() ? taut::quoted(token) : atEnd() ? "the end of the file" : "the end of the line", expected);
    }

  private:
    static bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
    static bool isLineEnd(char c) { return c == '\n' || c == '\r'; }

    /// The C runtimes of Microsoft write 1.#QNAN, -1.#IND and 1.#INF, newer ones nan(ind).
    static bool isSpelledNotFinite(std::string_view token) {
        if (!token.empty() && (token[0] == '-' || token[0] == '+')) token.remove_prefix(1);
        const auto begins = [&](std::string_view word) {
            return token.size() >= word.size() && std::equal(word.begin(), word.end(), token.begin(), [](char expected, char found) {
                       return expected == (found >= 'A' && found <= 'Z' ? static_cast<char>(found + 32) : found);
                   });
        };
        return begins("nan") || begins("inf") || token.find(".#") == 1;
    }

    [[nodiscard]] std::size_t continuationLength() const {
        if (!continuation_ || text_[pos_] != '\\') return 0;
        if (text_.substr(pos_ + 1, 2) == "\r\n") return 3;
        const std::string_view next = text_.substr(pos_ + 1, 1);
        return next == "\n" || next == "\r" ? 2 : 0;
    }
    [[nodiscard]] bool atContinuation() const { return continuationLength() != 0; }

    [[nodiscard]] bool atComment() const { return comment_ != 0 && !atEnd() && text_[pos_] == comment_; }

    void startLine(bool crAlone = false) {
        pos_ += !crAlone && text_.substr(pos_, 2) == "\r\n" ? 2 : 1;
        ++line_;
        lineStart_ = pos_;
        wordPos_ = pos_;
    }

    void skipBlanks() {
        while (!atEnd()) {
            const std::size_t joined = continuationLength();
            if (joined != 0) {
                ++pos_;
                startLine();
            } else if (isBlank(text_[pos_])) {
                ++pos_;
            } else {
                break;
            }
        }
    }

    template <class T> static bool parse(std::string_view token, T &value) {
        if (token.size() > 1 && token[0] == '+' && token[1] != '-') token.remove_prefix(1);
        const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
        if (end != token.data() + token.size() || token.empty()) return false;
        if constexpr (std::is_floating_point_v<T>) {
            // Out of double's range: a number below it is zero; above it (no digit says which side) it is not finite.
            if (error == std::errc::result_out_of_range) {
                value = token.find("e-") != std::string_view::npos || token.find("E-") != std::string_view::npos
                            ? 0
                            : std::numeric_limits<T>::infinity();
                return true;
            }
        }
        return error == std::errc();
    }

    std::string_view text_;
    std::string file_;
    char comment_ = 0;
    bool continuation_ = false;
    std::size_t pos_;
    std::size_t wordPos_;
    std::size_t lineStart_;
    int line_ = 1;
};

} // namespace taut
