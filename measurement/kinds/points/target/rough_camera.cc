#include "measurement/kinds/points/target/rough_camera.h"

#include <algorithm>
#include <cmath>

#include "effects/registry.h"
#include "measurement/numerics/robust.h"

namespace seam::measurement {
namespace {

using effects::Base;
using effects::EffectDefinition;

// Focal lengths over the image's width, a factor of 1.4 apart: fields of view from 20 to 110
// degrees.
constexpr double kFocalLengths[] = {0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8};
// Views that choose the lens, and those of a lens that failed count as this.
constexpr size_t kChoosing = 6;
constexpr double kFailed_px = 1e3;

// Median distance between where the points are seen and where the lens's best pose has them.
double misfit_px(const effects::Projection& projection, const std::vector<Sighting>& seen) {
  Pose X_CW;
  std::vector<double> residuals, distances;
  if (!initial_pose(projection, seen, X_CW) ||
      !pose_residuals(projection, seen, X_CW, residuals, nullptr))
    return kFailed_px;
  for (size_t i = 0; i < seen.size(); ++i)
    distances.push_back(
        std::hypot(residuals[2 * i] * seen[i].sigma_u, residuals[2 * i + 1] * seen[i].sigma_v));
  return std::min(kFailed_px, median_of(std::move(distances)));
}

}  // namespace

effects::Model plain_lens(double focal_px, bool wide, int width_px, int height_px) {
  effects::Model model;
  for (const auto& effect : effects::catalogue()) {
    if (effect->base == Base::projection) {
      model.set(effect, {{.value = focal_px},
                         {.value = focal_px},
                         {.value = 0.5 * (width_px - 1)},
                         {.value = 0.5 * (height_px - 1)}});
    } else if (wide && effect->replaces_base == Base::projection) {
      model.set(effect, std::vector<effects::ParameterValue>(effect->parameters.size()));
    }
  }
  return model;
}

std::optional<RoughCamera> rough_camera(const std::vector<std::vector<Sighting>>& views,
                                        int width_px, int height_px) {
  std::optional<effects::Model> best;
  double least = kFailed_px * static_cast<double>(kChoosing);
  for (const bool wide : {false, true}) {
    for (const double focal : kFocalLengths) {
      const effects::Model model = plain_lens(focal * width_px, wide, width_px, height_px);
      const effects::Projection projection(model, width_px, height_px);
      double sum = 0;
      const size_t choosing = std::min(kChoosing, views.size());
      for (size_t i = 0; i < choosing && sum < least; ++i)
        sum += misfit_px(projection, views[i * views.size() / choosing]);
      if (sum < least) least = sum, best = model;
    }
  }
  if (!best) return std::nullopt;
  RoughCamera camera{.model = *best, .projection = {*best, width_px, height_px}};
  for (const std::vector<Sighting>& seen : views) {
    Pose X_CW;
    const bool found = initial_pose(camera.projection, seen, X_CW);
    camera.X_CW.push_back(found ? std::optional(X_CW) : std::nullopt);
  }
  return camera;
}

std::optional<Eigen::Matrix<double, 2, 3>> RoughCamera::slopes(size_t view, const Vec3& p_W,
                                                               const Mat3& axes_W) const {
  if (!X_CW[view]) return std::nullopt;
  const Vec3 p_C = *X_CW[view] * p_W;
  const effects::ImagePoint here = projection.project(p_C);
  if (!here.visible) return std::nullopt;
  Eigen::Matrix<double, 2, 3> slopes;
  const double h = 1e-6 * glm::length(p_C);
  for (int axis = 0; axis < 3; ++axis) {
    const effects::ImagePoint there = projection.project(p_C + h * (X_CW[view]->R * axes_W[axis]));
    if (!there.visible) return std::nullopt;
    slopes.col(axis) << (there.u - here.u) / h, (there.v - here.v) / h;
  }
  return slopes;
}

}  // namespace seam::measurement
