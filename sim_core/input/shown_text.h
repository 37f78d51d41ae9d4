// Text from files as a terminal may show it. A name in a log or a set can hold sequences that move
// the cursor, change colours or turn the direction of writing; they are shown, not sent.
#pragma once

#include <string>
#include <string_view>

namespace seam {

// The text with control characters, bytes that are not UTF-8 and marks that turn the direction of
// writing as \x1b and the like; all else as it is.
std::string shown(std::string_view text);
// The same for text of several lines: line ends and tabulators stay.
std::string shown_lines(std::string_view text);

}  // namespace seam
