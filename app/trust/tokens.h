// Secrets of a scenario do not leave the process with it: wherever a scenario is written or shown,
// a fingerprint stands in each token's place, which distinguishes two tokens and opens nothing.
#pragma once

#include <string>

#include "sim_core/scenario/scenario.h"

namespace seam::app {

// "fingerprint-1a2b3c4d": 32 bits of SHA-256, too few to find a random token by. A word that is
// easy to guess can still be confirmed by it. An empty token and a fingerprint stay what they are.
std::string token_fingerprint(const std::string& token);

// The same scenario with fingerprints instead of its tokens.
Scenario with_fingerprints(Scenario scenario);
// The same scenario without tokens where it has fingerprints: the server makes new ones. Nobody
// who reads a log learns a token that a later run accepts.
Scenario without_fingerprints(Scenario scenario);

// The text of a log's scenario as it may be shown: logs of older programs hold tokens.
std::string shown_scenario(const std::string& text, const std::string& name);

}  // namespace seam::app
