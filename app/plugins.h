// `--plugin FILE`: effects from shared objects (effects/plugin.h), anywhere on the command line.
#pragma once

#include <string>
#include <vector>

namespace seam::app {

// Loads every `--plugin FILE` of the command line and registers its effects; returns the other
// arguments in their order. Throws UsageError or InputError.
std::vector<std::string> load_plugins(const std::vector<std::string>& arguments);

}  // namespace seam::app
