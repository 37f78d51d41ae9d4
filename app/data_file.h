#pragma once

#include <filesystem>
#include <string>

namespace seam::app {

// A file of the project (scenarios/..., models/...): below the working folder, where this program
// is installed, or beside its build folder.
std::filesystem::path data_file(const std::string& name);

// Whether a path leads to the models and scenarios that came with this program, which anybody may
// name.
bool is_our_data(const std::filesystem::path& path);

}  // namespace seam::app
