// The first line that a user reads: what matters, at the size of the noise.
#pragma once

#include <string>

#include "measurement/search/models/compare.h"
#include "measurement/search/search.h"

namespace seam::measurement {

std::string headline(const Problem& problem, const CompareResult& result);
// Of diagnose and of discover: `traces` are as many as the command tells beside it.
std::string headline(const Problem& problem, const SearchResult& result, size_t traces);

// The traces in one line; empty where there are none.
std::string traces_text(const Facts& facts, const std::vector<Structure>& structure,
                        const std::vector<Candidate>& candidates);

}  // namespace seam::measurement
