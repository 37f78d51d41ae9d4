// A session as one file, to be kept or sent: a zip of its models, formulas, script and reports.
#pragma once

#include <filesystem>
#include <string>

namespace seam::tools {

// What the session's folder has, and its script, in a folder `session`. Of reports those that were
// computed.
std::string session_archive(const std::filesystem::path& folder, const std::string& script);

}  // namespace seam::tools
