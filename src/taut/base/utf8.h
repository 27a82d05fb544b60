#pragma once
/// Text as UTF-8. Names of files and what they hold may be any bytes; formats that are text by their standard (JSON) may not.

#include <string>
#include <string_view>

namespace taut {

/// Bytes of the character at the front of `text` (RFC 3629: no overlong forms, no surrogates); 0 where there is none.
std::size_t utf8Length(std::string_view text);

/// `text` with U+FFFD, the replacement character, in place of each byte that is not UTF-8.
std::string validUtf8(std::string_view text);

/// The front of `text`, at most `bytes` of it, without cutting a character.
std::string utf8Front(const std::string &text, std::size_t bytes);

/// `text` with the case of its letters folded, one character to one, as file systems that ignore case compare names.
std::string foldedCase(const std::string &text);

} // namespace taut
