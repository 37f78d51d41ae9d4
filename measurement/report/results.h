// The results of the commands as JSON (schemas: docs/schemas) and as text for people.
#pragma once

#include <string>

#include "measurement/search/suggest.h"

namespace seam::measurement {

struct CompareResult {
  Grown base;
  std::vector<Structure> structure;
  std::vector<Outlier> outliers;
  double outlier_share = 0;
};

// Residuals of a model on held-out groups and where they fail.
CompareResult compare(Problem& problem, const Model& model);

std::string compare_json(const Problem& problem, const CompareResult& result);
std::string diagnose_json(const Problem& problem, const SearchResult& result,
                          const std::optional<Suggestion>& suggestion = {});
std::string discover_json(const Problem& problem, const SearchResult& result);
std::string compare_text(const Problem& problem, const CompareResult& result);
std::string diagnose_text(const Problem& problem, const SearchResult& result);
std::string discover_text(const Problem& problem, const SearchResult& result);

struct AddResult {
  Model model;  // With sigmas and history, ready to be written.
  std::string effect;
  std::vector<std::pair<std::string, effects::ParameterValue>> parameters;
  double error_before = 0;
  double error_after = 0;
  std::vector<NotTestable> not_testable;
};

// Fits and adds effects, all at once (a file may hold several). Throws InputError where one of
// them cannot be tested with these data.
AddResult add_effects(Problem& problem, const Model& model, const EffectList& effects);
// Refits every parameter of the model but counts and bits.
AddResult refit_all(Problem& problem, const Model& model);
std::string add_json(const Problem& problem, const AddResult& result, const std::string& format);

// The model that discover found, with its history.
Model discovered_model(const Problem& problem, const Model& start, const SearchResult& result);

// What the best explanation leaves for the user to measure; empty where nothing would help.
std::string advice_for(const Problem& problem, const SearchResult& result);

}  // namespace seam::measurement
