#pragma once

#include <filesystem>
#include <string>

namespace seam::app {

// A file of the project (scenarios/..., models/...): below the working folder, or beside the build
// folder of this program.
std::filesystem::path data_file(const std::string& name);

}  // namespace seam::app
