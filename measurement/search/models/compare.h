// One model held against one set: its error on held-out groups, and where it fails.
#pragma once

#include <vector>

#include "measurement/search/search.h"

namespace seam::measurement {

struct CompareResult {
  Grown base;  // The model given, refitted.
  std::vector<Structure> structure;
  std::vector<Structure> traces;  // Significant, but not material.
  double material = 0;            // The least that counts, in noise units.
  std::vector<Outlier> outliers;  // Of this model: compare knows no better one.
  double outlier_share = 0;       // Above kMostOutliers none is left out.
};

// Leaves the problem with its outliers marked.
CompareResult compare(Problem& problem, const Model& model, double material = kMaterial);

}  // namespace seam::measurement
