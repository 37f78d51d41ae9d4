// Models that grow: an effect that the user names is fitted and added, all parameters are refitted,
// or what a search found is written down. Each step goes into the model's history.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "measurement/search/search.h"

namespace seam::measurement {

// Parameters of an effect, with standard errors where they were fitted.
using NamedValues = std::vector<std::pair<std::string, effects::ParameterValue>>;
NamedValues parameters_of(const Assessment& assessment, const std::string& effect);

struct AddResult {
  Model model;  // With sigmas and history, ready to be written.
  std::string effect;
  std::vector<std::string> replaced;  // Effects of the model that have no place beside it.
  NamedValues parameters;
  double error_before = 0;
  double error_after = 0;
  std::vector<NotTestable> not_testable;
  Assessment assessment;  // Of the model.
};

// Fits and adds effects, all at once (a file may hold several). Throws InputError where one of
// them cannot be tested with these data, or excludes what the model has.
AddResult add_effects(Problem& problem, const Model& model, const EffectList& effects);
// Refits every parameter of the model but counts and bits, and those that the data do not tell
// beside the others (told_apart.h), which stay as they are and are named.
AddResult refit_all(Problem& problem, const Model& model);

// The model that a search found, with its history.
Model discovered_model(const Problem& problem, const Model& start, const SearchResult& result);

}  // namespace seam::measurement
