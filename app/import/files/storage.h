// Files of cv::FileStorage, YAML or XML, as configuration that names file, line and key.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim_core/base/config.h"

namespace seam::app {

ConfigNode read_storage(const std::filesystem::path& path);
ConfigNode storage_of_text(const std::string& text, const std::string& name);

// All numbers of a node, however deep: of a matrix its data, of lists theirs one after another.
// Throws for what is no number or not finite, unless `holes`: then those are NaN.
std::vector<double> numbers_in(const ConfigNode& node, bool holes = false);

bool is_matrix(const ConfigNode& node);
// Rows of a matrix; throws where its data are not as many as it says.
int matrix_rows(const ConfigNode& node);

}  // namespace seam::app
