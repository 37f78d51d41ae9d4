// What tests of made sets of outcomes ask.
#pragma once

#include <algorithm>
#include <string>

#include "measurement/search/search.h"

namespace seam::measurement {

// Whether the effect is found, as the first or in a tie that is declared with it.
inline bool is_named(const SearchResult& result, const std::string& effect) {
  const auto& candidates = result.first.candidates;
  if (candidates.empty() || !candidates.front().significant) return false;
  const auto& tied = candidates.front().indistinguishable_from;
  return candidates.front().effect->name == effect ||
         std::find(tied.begin(), tied.end(), effect) != tied.end();
}

}  // namespace seam::measurement
