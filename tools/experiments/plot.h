// Plots by gnuplot, from data beside them; left out with a message where gnuplot is missing.
#pragma once

#include <filesystem>
#include <string>

namespace seam::tools {

// Runs a gnuplot script that writes `folder/FILE`. Returns false, with a message, where it does
// not.
bool run_gnuplot(const std::filesystem::path& folder, const std::string& file,
                 const std::string& script);

// Runs a gnuplot script (which reads CSV files in `folder` and knows `output`, the picture's name)
// and writes `folder/NAME.png`. Returns false where gnuplot is not installed.
bool plot(const std::filesystem::path& folder, const std::string& name, const std::string& script);

}  // namespace seam::tools
