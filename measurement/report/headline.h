// The first line that a user reads, in the terminal, in JSON and on a page: what matters, at the
// size of the noise.
#pragma once

#include <string>

#include "measurement/search/models/compare.h"
#include "measurement/search/search.h"

namespace seam::measurement {

std::string headline(const Problem& problem, const CompareResult& result);
// Of diagnose and of discover: `traces` are as many as the command tells beside it.
std::string headline(const Problem& problem, const SearchResult& result, size_t traces);
std::string diagnose_headline(const Problem& problem, const SearchResult& result);
std::string discover_headline(const Problem& problem, const SearchResult& result);

// The traces of structure that diagnose tells: what the explanation leaves where it is none, else
// those of the model given.
const std::vector<Structure>& traces_told(const SearchResult& result);

// The traces in one line; empty where there are none.
std::string traces_text(const Facts& facts, const std::vector<Structure>& structure,
                        const std::vector<Candidate>& candidates);

}  // namespace seam::measurement
