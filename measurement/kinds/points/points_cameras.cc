// Several cameras on one rig whose places are estimated: a fit begins where the views say that they
// are, each by the board's own pose before it.
#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "effects/registry.h"
#include "measurement/kinds/points/points_predictor.h"
#include "measurement/kinds/points/points_problem.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/robust.h"
#include "measurement/numerics/span.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

using Six = Eigen::Matrix<double, 6, 1>;

// The rotation that is left between two poses and their distance, as six numbers.
Six apart(const Pose& X_AB, const Pose& X_AC) {
  const Pose X_BC = X_AB.inverse() * X_AC;
  const Mat3& R = X_BC.R;
  const Vec3 axis(R[1][2] - R[2][1], R[2][0] - R[0][2], R[0][1] - R[1][0]);
  const double twice_sine = glm::length(axis), twice_cosine = R[0][0] + R[1][1] + R[2][2] - 1;
  const double angle = std::atan2(twice_sine, twice_cosine);
  const Vec3 turn = twice_sine > 0 ? axis * (angle / twice_sine) : Vec3(0.0);
  Six all;
  all << turn.x, turn.y, turn.z, X_BC.p.x, X_BC.p.y, X_BC.p.z;
  return all;
}

// Of poses that should be one, that which is nearest to all others.
Pose middle_of(const std::vector<Pose>& poses) {
  size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < poses.size(); ++i) {
    double sum = 0;
    for (const Pose& other : poses) sum += apart(poses[i], other).norm();
    if (sum < least) least = sum, best = i;
  }
  return poses[best];
}

bool is_place_of(const effects::ModelEffect& effect, const std::string& camera) {
  return effect.definition->mount && effects::camera_of(effect.definition->name) == camera;
}

// The catalogue's effect that says where a camera is, for messages.
std::string name_of_place() {
  const auto& all = effects::catalogue();
  const auto found = std::find_if(all.begin(), all.end(), [](const auto& effect) {
    return effect->mount && !effect->has_neutral;
  });
  return found == all.end() ? "" : (*found)->name;
}

// The root mean square of what one pose leaves of these sightings, in units of their noise; nothing
// where some have no image.
std::optional<double> left_of(const Cameras& cameras, const std::vector<Sighting>& seen,
                              const Pose& X_CW) {
  std::vector<double> residuals;
  if (!pose_residuals(cameras, seen, X_CW, residuals, nullptr) || residuals.empty())
    return std::nullopt;
  return length(residuals) / std::sqrt(static_cast<double>(residuals.size()));
}

// The same where each camera sees the target from a pose of its own; nothing where only one does.
std::optional<double> left_apart(const Cameras& cameras, const std::vector<Sighting>& seen,
                                 const Pose& X_CW) {
  std::map<int, std::vector<Sighting>> by_camera;
  for (const Sighting& sighting : seen) by_camera[sighting.camera].push_back(sighting);
  if (by_camera.size() < 2) return std::nullopt;
  double square = 0;
  for (const auto& [camera, own] : by_camera) {
    Pose pose = X_CW;
    const auto left = refine_pose(cameras, own, pose) ? left_of(cameras, own, pose) : std::nullopt;
    if (!left) return std::nullopt;
    square += *left * *left * static_cast<double>(own.size());
  }
  return std::sqrt(square / static_cast<double>(seen.size()));
}

}  // namespace

void PointsProblem::check_cameras(const Model& model) const {
  std::vector<std::string> names;
  for (const CameraView& view : data_.cameras) names.push_back(view.name);
  for (const effects::ModelEffect& effect : model.effects()) {
    const std::string camera = effects::camera_of(effect.definition->name);
    if (camera.empty() || std::find(names.begin(), names.end(), camera) != names.end()) continue;
    throw InputError(fmt::format("the model has '{}', and {} no camera '{}': expected {}",
                                 effect.definition->name, facts_.file, camera,
                                 names.front().empty()
                                     ? "a column camera"
                                     : fmt::format("one of {}", fmt::join(names, ", "))));
  }
  Cameras(model, data_.cameras);
  for (size_t k = 1; k < names.size() && data_.rig.type() == Rig::Type::unknown; ++k) {
    const bool placed = std::any_of(
        model.effects().begin(), model.effects().end(),
        [&](const effects::ModelEffect& effect) { return is_place_of(effect, names[k]); });
    if (placed) continue;
    throw InputError(
        fmt::format("the model does not say where camera '{}' is beside '{}': expected an effect "
                    "of the stage mount for it, such as {}@{}, each of its values {{value: 0, "
                    "free: true}} where it is not known",
                    names[k], names[0], name_of_place(), names[k]));
  }
}

// X_FK of each camera, F being the first; nothing where no view tells.
std::vector<std::optional<Pose>> PointsProblem::places_by_views(const Model& model,
                                                                const Groups& groups) const {
  const Cameras cameras(model, data_.cameras);
  const std::vector<Vec3> places_W = places_of_rows(data_, effects::target_of(model));
  const size_t count = data_.cameras.size();
  std::vector<std::vector<std::optional<Pose>>> X_KW;  // By frame and camera.
  for (size_t frame = 0; frame < data_.rows_of_frame.size(); ++frame) {
    X_KW.emplace_back(count);
    if (!groups[facts_.group_of_row[data_.rows_of_frame[frame].front()]]) continue;
    std::vector<int> rows;
    const std::vector<Sighting> all = sightings(static_cast<int>(frame), places_W, rows);
    for (size_t k = 0; k < count; ++k) {
      std::vector<Sighting> seen;
      for (Sighting s : all) {
        if (s.camera != static_cast<int>(k)) continue;
        s.camera = 0;
        seen.push_back(s);
      }
      const Cameras alone(cameras.lens(static_cast<int>(k)));
      Pose pose;
      if (initial_pose(alone, seen, pose) && refine_pose(alone, seen, pose)) X_KW.back()[k] = pose;
    }
  }
  std::vector<std::optional<Pose>> X_FK(count);
  X_FK[0] = Pose();
  // Those that share views with the first, then those that share some with these, and so on.
  for (bool found = true; found;) {
    found = false;
    for (size_t k = 1; k < count; ++k) {
      std::vector<Pose> said;
      for (const auto& frame : X_KW) {
        for (size_t other = 0; other < count && !X_FK[k] && frame[k]; ++other) {
          if (X_FK[other] && frame[other])
            said.push_back(*X_FK[other] * *frame[other] * frame[k]->inverse());
        }
      }
      if (said.empty()) continue;
      X_FK[k] = middle_of(said);
      found = true;
    }
  }
  return X_FK;
}

Model PointsProblem::with_cameras_placed(const Model& model, const std::vector<Unknown>& unknowns,
                                         const Groups& groups) const {
  if (data_.cameras.size() < 2 || data_.rig.type() != Rig::Type::unknown) return model;
  std::vector<std::vector<Unknown>> of_camera(data_.cameras.size());
  bool any = false;
  for (const Unknown& unknown : unknowns) {
    for (size_t k = 1; k < of_camera.size(); ++k) {
      if (!is_place_of(*model.find(unknown.effect), data_.cameras[k].name)) continue;
      of_camera[k].push_back(unknown);
      any = true;
    }
  }
  // Near its end a fit needs no help.
  constexpr double kFar = 10;
  const auto error_of = [&](const Model& there) {
    const Evaluation evaluation = evaluate(there, groups, nullptr);
    return evaluation.valid ? score_of(*this, evaluation).error()
                            : std::numeric_limits<double>::infinity();
  };
  if (!any) return model;
  const double error = error_of(model);
  if (error < kFar) return model;
  const auto X_FK = places_by_views(model, groups);
  Model placed = model;
  for (size_t k = 1; k < of_camera.size(); ++k) {
    if (!X_FK[k] || of_camera[k].empty()) continue;
    const auto left = [&](const Model& there) {
      return apart(Cameras(there, data_.cameras).X_KC(static_cast<int>(k)).inverse(), *X_FK[k]);
    };
    // What is left is nearly linear in them.
    constexpr int kSteps = 12;
    for (int step = 0; step < kSteps; ++step) {
      const MovedModels moved(placed, of_camera[k]);
      const Six here = left(placed);
      Eigen::MatrixXd slopes(6, static_cast<Eigen::Index>(of_camera[k].size()));
      for (size_t p = 0; p < of_camera[k].size(); ++p)
        slopes.col(static_cast<Eigen::Index>(p)) = (left(moved.models[p]) - here) / moved.steps[p];
      const Eigen::VectorXd by = -solve_any_rank(slopes, here);
      for (size_t p = 0; p < of_camera[k].size(); ++p) {
        const Unknown& unknown = of_camera[k][p];
        const effects::ModelEffect& effect = *placed.find(unknown.effect);
        const effects::Parameter& parameter = effect.definition->parameters[unknown.parameter];
        const double value =
            effect.parameters[unknown.parameter].value + by[static_cast<Eigen::Index>(p)];
        placed.set_value(unknown.effect, unknown.parameter,
                         std::clamp(value, parameter.min, parameter.max));
      }
    }
  }
  return error_of(placed) < error ? placed : model;
}

// Where the cameras stand is the same in all frames: one frame in which they disagree far more than
// in most was not taken by all at once.
void PointsProblem::remark_on_agreement(const Model& model, const Evaluation& evaluation,
                                        std::vector<std::string>& remarks) const {
  constexpr double kFar = 5, kMatters = 0.5;  // Robust sigmas; of what a pose for each leaves.
  constexpr size_t kFewestFrames = 4;
  const Cameras cameras(model, data_.cameras);
  const std::vector<Vec3> places_W = places_of_rows(data_, effects::target_of(model));
  std::vector<double> moved;
  std::vector<std::string> names;
  for (size_t frame = 0; frame < data_.rows_of_frame.size(); ++frame) {
    std::vector<int> rows;
    const std::vector<Sighting> seen = sightings(static_cast<int>(frame), places_W, rows);
    Pose X_CW;
    if (seen.empty() || !stored_pose(evaluation.nuisance_values, frame, X_CW)) continue;
    const auto together = left_of(cameras, seen, X_CW), apart = left_apart(cameras, seen, X_CW);
    if (!together || !apart || !(*apart > 0)) continue;
    // By so much one pose moves the predictions of both.
    const double square = *together * *together / (*apart * *apart) - 1;
    moved.push_back(std::sqrt(std::max(0.0, square))), names.push_back(data_.frames[frame]);
  }
  if (moved.size() < kFewestFrames) return;
  const double usual = median_of(moved);
  std::vector<double> off;
  for (const double m : moved) off.push_back(m - usual);
  const double limit = std::max(usual + kFar * robust_sigma(off), kMatters);
  for (size_t i = 0; i < moved.size(); ++i) {
    if (moved[i] < limit) continue;
    remarks.push_back(fmt::format(
        "frame {}: the cameras see the target in places of their own (one pose moves predictions "
        "by {:.1f} of what a pose for each leaves, in most frames by {:.1f}): they did not take it "
        "at once, or it is another picture; leave it out or take it again",
        names[i], moved[i], usual));
  }
}

}  // namespace seam::measurement
