// Names of files as other people's files state them: one function turns such a name into a path
// inside a folder, or says why it is none. Every reader and writer of a set's files uses it.
#pragma once

#include <filesystem>
#include <string>

namespace seam {

// Why `name` names nothing inside `folder`: empty, absolute, with a `..`, with a character that no
// terminal shows (NUL, control characters), or led out by a symbolic link. Empty where it is well.
std::string why_not_inside(const std::filesystem::path& folder, const std::string& name);

// `folder / name`; throws InputError with the reason where that is not inside the folder.
std::filesystem::path path_inside(const std::filesystem::path& folder, const std::string& name);

}  // namespace seam
