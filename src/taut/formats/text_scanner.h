#pragma once
/// Words and numbers of a text, each with its line and column. A line is read word by word; nothing is copied.

#include "taut/base/error.h"

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
        : text_(text), file_(std::move(file)), comment_(comment), continuation_(continuation) {}

    [[nodiscard]] bool atEnd() const { return pos_ >= text_.size(); }
    /// Bytes before the next unread character.
    [[nodiscard]] std::size_t position() const { return pos_; }
    [[nodiscard]] std::size_t remaining() const { return text_.size() - pos_; }

    /// Skips what is left of this line and its end; false where no line follows.
    bool nextLine() {
        while (!atEnd() && text_[pos_] != '\n') ++pos_;
        if (atEnd()) return false;
        startLine();
        return !atEnd();
    }

    /// Skips lines without a word; false where none is left.
    bool skipEmptyLines() {
        do {
            skipBlanks();
            if (!atEnd() && text_[pos_] != '\n' && !atComment()) return true;
        } while (nextLine());
        return false;
    }

    /// The next word of this line; empty at its end. where() is its place.
    std::string_view word() {
        skipBlanks();
        wordPos_ = pos_;
        if (atComment()) return {};
        while (!atEnd() && !isBlank(text_[pos_]) && text_[pos_] != '\n' && !atContinuation()) ++pos_;
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
        while (!atEnd() && text_[pos_] != '\n') ++pos_;
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
    static bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

    [[nodiscard]] std::size_t continuationLength() const {
        if (!continuation_ || text_[pos_] != '\\') return 0;
        if (text_.substr(pos_ + 1, 1) == "\n") return 2;
        return text_.substr(pos_ + 1, 2) == "\r\n" ? 3 : 0;
    }
    [[nodiscard]] bool atContinuation() const { return continuationLength() != 0; }

    [[nodiscard]] bool atComment() const { return comment_ != 0 && !atEnd() && text_[pos_] == comment_; }

    void startLine() {
        ++pos_;
        ++line_;
        lineStart_ = pos_;
        wordPos_ = pos_;
    }

    void skipBlanks() {
        while (!atEnd()) {
            const std::size_t joined = continuationLength();
            if (joined != 0) {
                pos_ += joined - 1;
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
    std::size_t pos_ = 0;
    std::size_t wordPos_ = 0;
    std::size_t lineStart_ = 0;
    int line_ = 1;
};

} // namespace taut
