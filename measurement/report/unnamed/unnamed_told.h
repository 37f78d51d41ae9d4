// What is told of causes without a name, and of the lens that stands for one, in JSON and in words.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "measurement/search/search.h"

namespace seam::measurement {

// Causes without a name that explain the set better than the effects that imitate them.
void add_unnamed(nlohmann::ordered_json& json, const SearchResult& result);

// What a lens of splines leaves, where no lens with a formula leaves as little: a sentence after
// others, and lines of their own. Empty where none is held.
std::string splines_sentence(const SearchResult& result);
std::string splines_text(const SearchResult& result);

}  // namespace seam::measurement
