// The trust in a verdict as a part of a result's JSON.
#pragma once

#include <nlohmann/json.hpp>

#include "measurement/report/trust/trust.h"

namespace seam::measurement {

// `trust` where the benchmark says anything of such a verdict.
inline void add_trust(nlohmann::ordered_json& json, const std::optional<Trust>& trust) {
  if (!trust) return;
  json["trust"] = {{"verdict", trust->verdict},
                   {"sets", trust->right.trials},
                   {"right", trust->right.hits},
                   {"share_low", trust->right.low()},
                   {"share_high", trust->right.high()}};
}

}  // namespace seam::measurement
