// Words as a POSIX shell reads them, for scripts and files of settings that SEAM writes.
#pragma once

#include <string>

namespace seam {

// The text in quotes where a shell would read it otherwise, or not as one word.
std::string shell_word(const std::string& text);

}  // namespace seam
