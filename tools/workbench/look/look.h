// What the page shows of one model, computed in a process of its own: rows and residuals, then
// candidates as they are fitted, in files of a folder that the server reads.
#pragma once

#include <filesystem>

#include "tools/commands/analysis.h"

namespace seam::tools {

// Writes into `out`: compare.json,
// set.json, model.json, rows.bin, then search.json anew with each candidate, and
// fit-EFFECT.bin for each. Says each on standard output, a line of JSON.
void look_into(const AnalysisFlags& flags, const std::filesystem::path& out);

}  // namespace seam::tools
