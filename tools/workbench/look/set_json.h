// What a set holds, for the page: columns with units and ranges, groups, and what is doubted.
#pragma once

#include <nlohmann/json.hpp>

#include "tools/commands/analysis.h"

namespace seam::tools {

nlohmann::json set_json(const measurement::Problem& problem, const AnalysisFlags& flags,
                        const measurement::Doubts& doubts);

}  // namespace seam::tools
