#include "taut/scene/toml_depth.h"

#include <vector>

namespace taut {

namespace {

/// An array or inline table that is open, or (the outermost) the document.
struct Open {
    bool isTable = true;      ///< expects keys
    bool inKey = true;        ///< before the '=' of an entry
    std::size_t keyParts = 0; ///< of the entry that is being read
};

/// Reads TOML 1.0 as far as its nesting goes: strings, comments, keys and brackets.
class DepthScanner {
  public:
    DepthScanner(std::string_view text, std::size_t most) : text_(text), most_(most) {}

    std::optional<DeepPlace> run() {
        while (pos_ < text_.size()) {
            step();
            if (depth() > most_) return DeepPlace{line_, static_cast<int>(pos_ - lineStart_) + 1};
        }
        return std::nullopt;
    }

  private:
    void step() {
        const char c = text_[pos_];
        Open &open = open_.back();
        if (c == '#') {
            while (pos_ < text_.size() && text_[pos_] != '\n') ++pos_;
            return;
        }
        if (c == '"' || c == '\'') {
            beginPart();
            skipString(c);
            return;
        }
        ++pos_;
        switch (c) {
        case '\n':
            ++line_;
            lineStart_ = pos_;
            if (open_.size() == 1) beginEntry(open);
            break;
        case '[':
            if (open_.size() == 1 && open.inKey && open.keyParts == 0) { // a header, of a table or of an element of an array
                inHeader_ = true;
                header_ = 0;
            } else if (!inHeader_) {
                push({false, false, 0});
            }
            break;
        case ']':
            inHeader_ = false;
            pop(false);
            break;
        case '{': push({true, true, 0}); break;
        case '}': pop(true); break;
        case ',':
            if (open.isTable && open_.size() > 1) beginEntry(open);
            break;
        case '=': open.inKey = false; break;
        case '.': afterDot_ = true; break;
        case ' ':
        case '\t':
        case '\r': break;
        default: beginPart();
        }
    }

    /// A part of a key begins: the first, or one behind a dot.
    void beginPart() {
        Open &open = open_.back();
        if (!open.inKey) return;
        std::size_t &parts = inHeader_ ? header_ : open.keyParts;
        if (parts == 0 || afterDot_) {
            ++parts;
            if (!inHeader_) ++keyParts_;
        }
        afterDot_ = false;
    }

    void beginEntry(Open &open) {
        keyParts_ -= open.keyParts;
        open.keyParts = 0;
        open.inKey = true;
        afterDot_ = false;
        inHeader_ = false;
    }

    void push(const Open &open) { open_.push_back(open); }

    /// A bracket that closes nothing of its kind is no TOML; the parser will say so.
    void pop(bool isTable) {
        if (open_.size() == 1 || open_.back().isTable != isTable) return;
        keyParts_ -= open_.back().keyParts;
        open_.pop_back();
    }

    /// Leaves pos_ behind the string: """...""" and '''...''' may hold lines, the others end with theirs.
    void skipString(char quote) {
        const std::string_view fence = text_.substr(pos_, 3);
        const bool many = fence.size() == 3 && fence[1] == quote && fence[2] == quote;
        pos_ += many ? 3 : 1;
        while (pos_ < text_.size()) {
            const char c = text_[pos_];
            if (c == '\n' && !many) return;
            if (c == '\\' && quote == '"' && text_.substr(pos_ + 1, 1) != "\n") {
                pos_ += 2;
                continue;
            }
            if (c == quote && (!many || text_.substr(pos_, 3) == fence)) {
                pos_ += many ? 3 : 1;
                while (many && pos_ < text_.size() && text_[pos_] == quote) ++pos_; // two more may be the string's own
                return;
            }
            ++pos_;
            if (c != '\n') continue;
            ++line_;
            lineStart_ = pos_;
        }
    }

    [[nodiscard]] std::size_t depth() const { return header_ + keyParts_ + open_.size() - 1; }

    std::string_view text_;
    std::size_t most_;
    std::vector<Open> open_{Open{}};
    std::size_t header_ = 0;   ///< parts of the header above
    std::size_t keyParts_ = 0; ///< of all open entries
    bool inHeader_ = false;
    bool afterDot_ = false;
    std::size_t pos_ = 0;
    std::size_t lineStart_ = 0;
    int line_ = 1;
};

} // namespace

std::optional<DeepPlace> placeDeeperThan(std::string_view text, std::size_t most) {
    return DepthScanner(text, most).run();
}

} // namespace taut
