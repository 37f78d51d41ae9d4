// Results of the commands as JSON (docs/reference/schemas/results.schema.json) and as text.
#pragma once

#include <string>

#include "measurement/search/models/add_effects.h"
#include "measurement/search/models/compare.h"

namespace seam::measurement {

// Sentences that doubt the data (measurement/check/doubts.h). They follow the headline.
using Doubts = std::vector<std::string>;

std::string compare_json(const Problem& problem, const CompareResult& result,
                         const Doubts& doubts = {});
std::string diagnose_json(const Problem& problem, const SearchResult& result,
                          const Doubts& doubts = {});
// Of the same the candidates and what is not testable alone, in a search that goes on.
std::string looks_json(const SearchResult& result);
std::string discover_json(const Problem& problem, const SearchResult& result,
                          const Doubts& doubts = {});
std::string compare_text(const Problem& problem, const CompareResult& result,
                         const Doubts& doubts = {});
std::string diagnose_text(const Problem& problem, const SearchResult& result,
                          const Doubts& doubts = {});
std::string discover_text(const Problem& problem, const SearchResult& result,
                          const Doubts& doubts = {});
std::string doubts_text(const Doubts& doubts);  // A line each.
// The headline, behind those of the doubts that ask what the columns mean: no result is one before
// they are answered.
std::string with_questions(const std::string& headline, const Doubts& doubts);

std::string add_json(const Problem& problem, const AddResult& result, const std::string& format,
                     const Doubts& doubts = {});

// Which share of what an assessment leaves beyond the noise is gone where the error is `after`; NaN
// where it leaves nothing beyond it.
double gain_of(const Assessment& before, double after);

// How many observations take part: points, where each has a residual along u and one along v.
int64_t observations_used(const Problem& problem);

// Errors of free predictions on held-out groups; of all groups where each is held out in turn.
std::vector<FreeError> free_errors(const Problem& problem, const Assessment& assessment);

// What the best explanation leaves for the user to measure; empty where nothing would help.
std::string advice_for(const Problem& problem, const SearchResult& result);

}  // namespace seam::measurement
