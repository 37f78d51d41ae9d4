#pragma once

#include <filesystem>
#include <string>

namespace seam::app {

// A file of the project (scenarios/..., models/...): below the working folder, where this program
// is installed, or beside its build folder.
std::filesystem::path data_file(const std::string& name);

// A file that somebody names: as it is, or, where it is not there and begins with scenarios/ or
// models/, the one of this name that came with this program, which is said. So the examples of the
// help run wherever the program was installed.
std::filesystem::path given_or_ours(const std::filesystem::path& name);

// Whether a path leads to the models and scenarios that came with this program, which anybody may
// name.
bool is_our_data(const std::filesystem::path& path);

}  // namespace seam::app
