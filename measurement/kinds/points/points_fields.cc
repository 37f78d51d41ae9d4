// Where causes without a name may act on points, beside the image as a whole: by the place within a
// pixel, as detectors of corners err, and on the target, as one that is not what its plan says.
#include <algorithm>
#include <cmath>

#include "effects/stages/target.h"
#include "measurement/kinds/points/points_problem.h"
#include "measurement/sets/pose_of_view.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

constexpr double kStep_m = 1e-6;

// From slopes by a shift of each point along three axes those by a shift across its ray, which
// moves its image by focal length over distance: the direction in which it moves least.
std::vector<std::vector<double>> slopes_by_shift_of_ray(
    const std::vector<std::vector<double>>& of_point) {
  const size_t scalars = of_point[0].size();
  std::vector<std::vector<double>> slopes(2, std::vector<double>(scalars, 0));
  for (size_t i = 0; i + 1 < scalars; i += 2) {
    double uu = 0, uv = 0, vv = 0;
    for (const std::vector<double>& along : of_point) {
      uu += along[i] * along[i], uv += along[i] * along[i + 1], vv += along[i + 1] * along[i + 1];
    }
    const double least = 0.5 * (uu + vv - std::hypot(uu - vv, 2 * uv));
    slopes[0][i] = slopes[1][i + 1] = std::sqrt(std::max(least, 0.0));
  }
  return slopes;
}

}  // namespace

std::vector<FieldPlace> PointsProblem::field_places(const Model& model,
                                                    const Evaluation& here) const {
  const std::vector<double>* measured[] = {&data_.u_px, &data_.v_px};
  FieldPlace pixel;
  for (size_t c = 0; c < 2; ++c) {
    std::vector<double> slope(facts_.scalars(), 0);
    Covariate phase{.name = c == 0 ? "column within a pixel" : "row within a pixel",
                    .type = Covariate::Type::cyclic};
    for (size_t row = 0; row < facts_.rows(); ++row) {
      slope[2 * row + c] = 1;
      const double predicted = (*measured[c])[row] - here.residual[2 * row + c];
      phase.values.push_back(2 * maths::kPi * (predicted - std::floor(predicted)));
    }
    pixel.slopes.push_back(std::move(slope));
    pixel.covariates.push_back(std::move(phase));
  }
  // What bends each view in its own way: a lens that depends on the distance, a camera that moved.
  const FieldPlace view{.slopes = pixel.slopes,
                        .covariates = {facts_.covariates[0], facts_.covariates[1]},
                        .part_of_row = data_.view_of_row,
                        .part = "view"};
  std::vector<FieldPlace> places = {std::move(pixel), view};
  if (data_.rig.type() != Rig::Type::unknown) return places;
  FieldPlace target{.slopes =
                        moves() ? slopes_on_path(model, here) : slopes_of_target(model, here)};
  // A pane before the lens, or a lens that has no one viewpoint: rays are shifted aside.
  places.push_back({.slopes = slopes_by_shift_of_ray(target.slopes),
                    .covariates = view.covariates,
                    .part = "distance"});
  if (effects::target_of(model).has_draws()) return places;
  for (int axis = 0; axis < 3; ++axis) {
    Covariate along{.name = std::string("target ") + "xyz"[axis]};
    for (const Vec3& point : data_.p_W) along.values.push_back(point[axis]);
    target.covariates.push_back(std::move(along));
  }
  places.push_back(std::move(target));
  return places;
}

// Of residuals over sigma by a shift of each point along the target's axes, with the views' poses
// at rest.
std::vector<std::vector<double>> PointsProblem::slopes_of_target(const Model& model,
                                                                 const Evaluation& here) const {
  std::vector<std::vector<double>> slopes(3, std::vector<double>(facts_.scalars(), 0));
  const Cameras cameras(model, data_.cameras);
  const std::vector<Vec3> places_W = places_of_rows(data_, effects::target_of(model));
  for (size_t frame = 0; frame < data_.rows_of_frame.size(); ++frame) {
    std::vector<int> rows;
    std::vector<Sighting> seen = sightings(static_cast<int>(frame), places_W, rows);
    Pose X_CW;
    std::vector<double> base, there;
    if (seen.empty() || !stored_pose(here.nuisance_values, frame, X_CW) ||
        !pose_residuals(cameras, seen, X_CW, base, nullptr))
      continue;
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<Sighting> moved = seen;
      for (Sighting& point : moved) point.p_W[axis] += kStep_m;
      if (!pose_residuals(cameras, moved, X_CW, there, nullptr)) continue;
      for (size_t i = 0; i < base.size(); ++i)
        slopes[axis][2 * rows[i / 2] + i % 2] = (there[i] - base[i]) / kStep_m;
    }
  }
  return slopes;
}

// The same with the path at rest.
std::vector<std::vector<double>> PointsProblem::slopes_on_path(const Model& model,
                                                               const Evaluation& here) const {
  std::vector<std::vector<double>> slopes(3, std::vector<double>(facts_.scalars(), 0));
  const PathLayout layout = layout_of(all_groups());
  const PathAdjustment adjustment = path_adjustment(model, all_groups(), layout);
  const RowCamera camera(model, data_.cameras, data_.gyroscope.get());
  std::vector<Control> controls(layout.controls());
  if (!stored_path(data_, here.nuisance_values, controls)) return slopes;
  for (const PathSighting& point : adjustment.seen()) {
    Eigen::Vector2d before, after;
    if (!adjustment.image(camera, controls, point, before)) continue;
    for (int axis = 0; axis < 3; ++axis) {
      PathSighting moved = point;
      moved.p_T[axis] += kStep_m;
      if (!adjustment.image(camera, controls, moved, after)) continue;
      const Eigen::Vector2d by = (before - after) / kStep_m;
      slopes[axis][2 * point.row] = by[0] / point.sigma_u;
      slopes[axis][2 * point.row + 1] = by[1] / point.sigma_v;
    }
  }
  return slopes;
}

}  // namespace seam::measurement
