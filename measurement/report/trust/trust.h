// How far a verdict can be trusted: of sets of the public benchmark of the same kind whose verdict
// was the same, how many verdicts were right (benchmark/README.md, "Trust").
#pragma once

#include <optional>
#include <string>

#include "measurement/judge/rate.h"
#include "measurement/search/search.h"

namespace seam::measurement {

struct Trust {
  std::string verdict;  // nothing, named, unexplained
  Rate right;           // Of these sets.
};

// Nothing where the benchmark has too few sets of this kind with this verdict to say anything.
std::optional<Trust> trust_in(const std::string& kind, const std::string& verdict);
std::optional<Trust> trust_in(const Problem& problem, const SearchResult& result);

// A line for people; empty where nothing is known.
std::string trust_text(const std::optional<Trust>& trust);

}  // namespace seam::measurement
