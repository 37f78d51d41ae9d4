#include "measurement/kinds/landmarks/landmark_starts.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

// How far a shape moves each scalar, against what is left there.
struct Taken {
  double slope2 = 0, slope_left = 0;

  double size() const { return slope_left / slope2; }
  double gain() const { return slope_left * slope_left / slope2; }
};

std::array<double, 2> moved_by(const effects::EffectDefinition& effect,
                               const std::vector<double>& shape, const effects::Detection& seen) {
  effects::Detection moved = seen;
  effect.detector(shape, moved);
  return {moved.range_m - seen.range_m,
          std::remainder(moved.bearing_rad - seen.bearing_rad, 2 * maths::kPi)};
}

Taken taken_by(const LandmarkData& data, const std::vector<effects::Detection>& predicted,
               const Evaluation& left, const effects::EffectDefinition& effect,
               const std::vector<double>& shape) {
  Taken taken;
  for (size_t row = 0; row < predicted.size(); ++row) {
    const std::array<double, 2> slopes = moved_by(effect, shape, predicted[row]);
    for (int c = 0; c < 2; ++c) {
      const int scalar = data.scalars[row][c];
      if (scalar < 0 || slopes[c] == 0 || !left.used[scalar]) continue;
      const double weight = 1 / (left.sigma[scalar] * left.sigma[scalar]);
      taken.slope2 += weight * slopes[c] * slopes[c];
      taken.slope_left += weight * slopes[c] * left.residual[scalar];
    }
  }
  return taken;
}

}  // namespace

std::vector<std::vector<double>> landmark_shape(const LandmarkData& data,
                                                const std::vector<effects::Detection>& predicted,
                                                const Evaluation& left,
                                                const effects::EffectDefinition& effect,
                                                const std::vector<std::vector<double>>& shapes) {
  const effects::Parameter& size = effect.parameters.front();
  std::vector<std::vector<double>> best;
  double most = 0;
  for (const std::vector<double>& shape : shapes) {
    const Taken taken = taken_by(data, predicted, left, effect, shape);
    if (!(taken.slope2 > 0) || !(taken.gain() > most)) continue;
    most = taken.gain();
    best = {shape};
    best[0][0] = std::clamp(shape[0] * taken.size(), size.min, size.max);
  }
  return best;
}

double shapes_that_act(const std::vector<effects::Detection>& predicted,
                       const effects::EffectDefinition& effect,
                       const std::vector<std::vector<double>>& shapes) {
  return static_cast<double>(
      std::count_if(shapes.begin(), shapes.end(), [&](const std::vector<double>& shape) {
        return std::any_of(predicted.begin(), predicted.end(), [&](effects::Detection seen) {
          const std::array<double, 2> slopes = moved_by(effect, shape, seen);
          return std::max(std::abs(slopes[0]), std::abs(slopes[1])) > 0.5 * std::abs(shape[0]);
        });
      }));
}

}  // namespace seam::measurement
