#include "taut/base/utf8.h"

#include <clocale>
#include <cwctype>

namespace taut {

namespace {

unsigned byteAt(std::string_view text, std::size_t i) {
    return static_cast<unsigned char>(text[i]);
}

/// `length` as utf8Length() says.
char32_t decode(std::string_view text, std::size_t length) {
    char32_t code = length == 1 ? byteAt(text, 0) : byteAt(text, 0) & (0x7fU >> length);
    for (std::size_t i = 1; i < length; ++i) code = code << 6U | (byteAt(text, i) & 0x3fU);
    return code;
}

void append(std::string &out, char32_t code) {
    if (code < 0x80) {
        out += static_cast<char>(code);
        return;
    }
    const int more = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    const char32_t lead = more == 1 ? 0xc0 : more == 2 ? 0xe0 : 0xf0;
    out += static_cast<char>(lead | code >> static_cast<unsigned>(6 * more));
    for (int i = more - 1; i >= 0; --i) out += static_cast<char>(0x80U | (code >> static_cast<unsigned>(6 * i) & 0x3fU));
}

/// Characters of all scripts, whatever the user's own locale; null where the system has none such.
locale_t unicodeLocale() {
    static const locale_t locale = newlocale(LC_CTYPE_MASK, "C.UTF-8", nullptr);
    return locale;
}

char32_t folded(char32_t code) {
    if (code < 0x80) return code >= 'A' && code <= 'Z' ? code + 32 : code;
    if (unicodeLocale() == nullptr) return code;
    // Up first: some capitals share a small letter (the two small sigmas).
    return static_cast<char32_t>(towlower_l(towupper_l(static_cast<wint_t>(code), unicodeLocale()), unicodeLocale()));
}

} // namespace

std::size_t utf8Length(std::string_view text) {
    if (text.empty()) return 0;
    const unsigned first = byteAt(text, 0);
    if (first < 0x80) return 1;
    const std::size_t length = first >= 0xc2 && first < 0xe0   ? 2
                               : first >= 0xe0 && first < 0xf0 ? 3
                               : first >= 0xf0 && first < 0xf5 ? 4
                                                               : 0;
    if (length == 0 || text.size() < length) return 0;
    for (std::size_t i = 1; i < length; ++i)
        if ((byteAt(text, i) & 0xc0U) != 0x80) return 0;
    const char32_t code = decode(text, length);
    const char32_t least = length == 2 ? 0x80 : length == 3 ? 0x800 : 0x10000;
    return code < least || code > 0x10ffff || (code >= 0xd800 && code < 0xe000) ? 0 : length;
}

std::string validUtf8(std::string_view text) {
    std::string out;
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t length = utf8Length(text.substr(i));
        if (length == 0)
            out += "\xef\xbf\xbd";
        else
            out += text.substr(i, length);
        i += length == 0 ? 1 : length;
    }
    return out;
}

std::string utf8Front(const std::string &text, std::size_t bytes) {
    if (text.size() <= bytes) return text;
    while (bytes > 0 && (byteAt(text, bytes) & 0xc0U) == 0x80) --bytes;
    return text.substr(0, bytes);
}

std::string foldedCase(const std::string &text) {
    std::string out;
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t length = utf8Length(std::string_view(text).substr(i));
        if (length == 0)
            out += text[i++];
        else
            append(out, folded(decode(std::string_view(text).substr(i), length)));
        i += length;
    }
    return out;
}

} // namespace taut
