// The search for the set of effects that the data support: forward steps, then dropping and
// exchanging, until nothing improves; then the test of what structure remains.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "measurement/search/candidates.h"

namespace seam::measurement {

struct Step {
  std::string effect;
  Assessment after;  // The model with this step and those before it.
  double error_before = 0;
  double error_after = 0;
  std::vector<std::string> indistinguishable_from;
};

struct SearchResult {
  Grown base;  // The model given, refitted.
  std::vector<Structure> base_structure;
  Looks first;                       // Candidates for the first step.
  Grown best;                        // With all effects found.
  std::vector<Step> steps;           // In the order in which they help most.
  std::vector<Structure> remaining;  // Significant structure after the last step.
  std::vector<Outlier> outliers;     // Of the best model.
  size_t outliers_of_given = 0;      // As many has the model given.
  double outlier_share = 0;          // Above kMostOutliers none is left out.
  std::string verdict;               // Of diagnose.
};

using Progress = std::function<void(const std::string&)>;

// Leaves the problem with its outliers marked.
SearchResult search(Problem& problem, const Model& model, const EffectList& own,
                    const Progress& progress);

// Marks outliers under this model; returns whether the marks changed.
bool mark_outliers(Problem& problem, const Model& model, SearchResult& result);

// Structures significant at the level designed for.
std::vector<Structure> significant_structure(const Problem& problem, const Grown& grown);
bool has_mean_structure(const std::vector<Structure>& structure);

}  // namespace seam::measurement
