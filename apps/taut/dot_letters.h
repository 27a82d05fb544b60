#pragma once
/// Letters of 5 x 8 dots for labels in pictures: the same dots on every machine, and no font to be found.

#include <string>

namespace taut::app {

inline constexpr int kLetterWidth = 6;  ///< dots, with the gap to the next
inline constexpr int kLetterHeight = 8; ///< dots; the lowest row is that of descenders

/// The text with one byte a letter: what is not ASCII becomes a question mark.
std::string drawable(const std::string &text);

/// Whether a dot of a letter is set; x from the left, y from the top. False outside it.
bool isDot(char letter, int x, int y);

} // namespace taut::app
