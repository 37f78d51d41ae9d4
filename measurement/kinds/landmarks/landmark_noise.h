// Noise of landmarks that is not white: errors that wander along a landmark's track, last for a
// run, or are shared by all bearings of it; ranges that are too long now and then.
#pragma once

#include <functional>

#include "effects/stages/noise.h"
#include "measurement/kinds/landmarks/landmark_data.h"
#include "measurement/problem/problem.h"
#include "sim_core/base/random.h"

namespace seam::measurement {

// Rows that may share errors, in order of time: those of one run and one group, as a held-out group
// knows nothing of the others.
std::vector<std::vector<int>> rows_of_errors(const LandmarkData& data, const Facts& facts);

// By how much a latency of its own moves range and bearing of a row, at one sigma; none where
// frames have none.
using JitterSlopes = std::function<std::array<double, 2>(int row)>;

// By how much range and bearing of a row, the two rows of the result, grow with x and y of its
// landmark.
using PlaceSlopes = std::function<std::array<std::array<double, 2>, 2>(int row)>;

// By scalar: by how much a residual grows with something unknown that all have in common.
using CommonSlopes = std::vector<double>;

// What all residuals say of a landmark's error of place, and of the delay in its ranges.
struct Displacement {
  std::array<double, 2> mean_m = {0, 0};
  // Variances of x and y, and their covariance.
  std::array<double, 3> covariance_m2 = {0, 0, 0};
  double delay_m = 0, delay_variance_m2 = 0;
};

// Whitens an evaluation that whiten_diagonal has filled. Returns, where places or delays are
// uncertain, what is found of each landmark. Unknowns in `common` have sigma 1.
std::vector<Displacement> whiten_landmarks(const LandmarkData& data, const Facts& facts,
                                           const std::vector<std::vector<int>>& rows_of_errors,
                                           const effects::Noise& noise, const JitterSlopes& jitter,
                                           const PlaceSlopes& places,
                                           const std::vector<CommonSlopes>& common,
                                           const Groups& groups, Evaluation& evaluation);

// Draws such errors of range and bearing, by row.
struct LandmarkErrors {
  std::vector<double> range_m, bearing_rad;
};
LandmarkErrors draw_landmark_errors(const LandmarkData& data, const effects::Noise& noise,
                                    RandomStream stream);

}  // namespace seam::measurement
