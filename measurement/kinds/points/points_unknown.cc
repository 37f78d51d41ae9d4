// Points seen by a camera whose pose in each frame is estimated with the model.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "effects/questions.h"
#include "effects/registry.h"
#include "measurement/imaging/lens_like.h"
#include "measurement/kinds/points/points_predictor.h"
#include "measurement/kinds/points/points_problem.h"
#include "measurement/numerics/parallel_for.h"

namespace seam::measurement {

MovedModels::MovedModels(const Model& model, const std::vector<Unknown>& unknowns) {
  for (const Unknown& unknown : unknowns) {
    const effects::ModelEffect& effect = *model.find(unknown.effect);
    const effects::Parameter& parameter = effect.definition->parameters[unknown.parameter];
    const double value = effect.parameters[unknown.parameter].value;
    double step = 1e-5 * std::max(parameter.scale, std::abs(value));
    if (value + step > parameter.max) step = -step;
    models.push_back(model);
    models.back().set_value(unknown.effect, unknown.parameter, value + step);
    steps.push_back(step);
  }
}

std::vector<Sighting> PointsProblem::sightings(int frame, const std::vector<Vec3>& places_W,
                                               std::vector<int>& rows) const {
  std::vector<Sighting> seen;
  for (const int row : data_.rows_of_frame[frame]) {
    if (!takes_part(row)) continue;
    rows.push_back(row);
    seen.push_back({.p_W = places_W[row],
                    .u_px = data_.u_px[row],
                    .v_px = data_.v_px[row],
                    .sigma_u = sigma_of(row, 0),
                    .sigma_v = sigma_of(row, 1),
                    .t_s = data_.stamp_s[row],
                    .camera = data_.camera_of_row[row],
                    .columns = data_.columns_of(row)});
  }
  return seen;
}

// A view that the model finds no pose for counts as if all of its points were predicted in their
// middle: finite, and far off.
void PointsProblem::count_as_missed(int frame, Evaluation& evaluation) const {
  double u = 0, v = 0, count = 0;
  for (const int row : data_.rows_of_frame[frame]) {
    if (takes_part(row)) u += data_.u_px[row], v += data_.v_px[row], ++count;
  }
  for (const int row : data_.rows_of_frame[frame]) {
    evaluation.residual[2 * row] = count > 0 ? data_.u_px[row] - u / count : 0;
    evaluation.residual[2 * row + 1] = count > 0 ? data_.v_px[row] - v / count : 0;
  }
}

Evaluation PointsProblem::evaluate_unknown(const Model& model, const Groups& groups,
                                           const Evaluation* warm, bool refined) const {
  const Cameras cameras(model, data_.cameras);
  const std::vector<Vec3> places_W = places_of_rows(data_, effects::target_of(model));
  const std::optional<FewErrors> scatter = scatter_of(model);
  Evaluation evaluation = blank();
  evaluation.nuisance_values.assign(12 * data_.rows_of_frame.size(), 0);
  const auto taken = [&](size_t frame) {
    const std::vector<int>& rows = data_.rows_of_frame[frame];
    return groups[facts_.group_of_row[rows.front()]] &&
           std::any_of(rows.begin(), rows.end(), [&](int row) { return takes_part(row); });
  };
  parallel_for(data_.rows_of_frame.size(), [&](size_t frame) {
    if (!taken(frame)) return;
    std::vector<int> rows;
    const std::vector<Sighting> seen = sightings(static_cast<int>(frame), places_W, rows);
    Pose X_CW;
    const bool near = warm && warm->valid && stored_pose(warm->nuisance_values, frame, X_CW);
    bool have =
        (near && (scatter || refine_pose(cameras, seen, X_CW))) ||
        (initial_pose(cameras, seen, X_CW) && (!refined || refine_pose(cameras, seen, X_CW)));
    if (have && scatter) have = refine_scattered_pose(*scatter, cameras, seen, near, X_CW);
    for (const int row : data_.rows_of_frame[frame]) {  // Outliers too: they may come back.
      if (!have) break;
      const effects::ImagePoint point =
          cameras.project(X_CW * places_W[row], data_.stamp_s[row], data_.v_px[row],
                          data_.camera_of_row[row], data_.columns_of(row));
      const bool predicted = point.has_place();
      evaluation.residual[2 * row] = predicted ? data_.u_px[row] - point.u : 0;
      evaluation.residual[2 * row + 1] = predicted ? data_.v_px[row] - point.v : 0;
      have = predicted || !takes_part(row);
    }
    if (have) {
      store_pose(X_CW, frame, evaluation.nuisance_values);
    } else {
      count_as_missed(static_cast<int>(frame), evaluation);
    }
  });
  evaluation.valid = false;
  for (size_t frame = 0; frame < data_.rows_of_frame.size(); ++frame) {
    Pose X_CW;
    if (taken(frame)) evaluation.nuisances += 6;
    evaluation.valid = evaluation.valid || stored_pose(evaluation.nuisance_values, frame, X_CW);
  }
  whiten_diagonal(*this, groups, evaluation);
  if (scatter) whiten_all_scattered(*scatter, groups, evaluation);
  return evaluation;
}

// By row: of what takes the place of its whitened residuals by the residuals themselves.
std::vector<Eigen::Matrix2d> PointsProblem::slopes_of_scattered(const FewErrors& scatter,
                                                                const Groups& groups,
                                                                const Evaluation& here) const {
  constexpr double kStep = 1e-4;  // Of a row's noise.
  std::vector<Eigen::Matrix2d> slopes(data_.p_W.size(), Eigen::Matrix2d::Zero());
  for (size_t channel = 0; channel < 2; ++channel) {
    Evaluation there = blank();
    there.residual = here.residual;
    for (size_t i = channel; i < facts_.scalars(); i += 2)
      there.residual[i] += kStep * there.sigma[i];
    whiten_diagonal(*this, groups, there);
    whiten_all_scattered(scatter, groups, there);
    for (size_t i = 0; i < facts_.scalars(); ++i)
      slopes[i / 2](static_cast<Eigen::Index>(i % 2), static_cast<Eigen::Index>(channel)) =
          (there.whitened[i] - here.whitened[i]) /
          (kStep * sigma_of(i / 2, static_cast<int>(channel)));
  }
  return slopes;
}

// The number of the camera whose rows alone an effect moves at fixed poses; -1: those of all. Where
// the first camera is says where the others are beside it.
int PointsProblem::only_camera(const effects::EffectDefinition& effect) const {
  const std::string name = effects::camera_of(effect.name);
  const auto found = std::find_if(data_.cameras.begin(), data_.cameras.end(),
                                  [&](const CameraView& view) { return view.name == name; });
  const bool moves_all = name.empty() || found == data_.cameras.end() ||
                         (effect.mount && found == data_.cameras.begin());
  return moves_all ? -1 : static_cast<int>(found - data_.cameras.begin());
}

// The largest angle from a camera's axis under which its rows that take part are seen, poses being
// those of this model.
double PointsProblem::reach_rad(const Model& model, int camera) const {
  const Evaluation evaluation = evaluate(model, all_groups(), nullptr);
  if (!evaluation.valid) return 0;
  const Pose X_KC = Cameras(model, data_.cameras).X_KC(camera);
  double most = 0;
  for (size_t row = 0; row < data_.p_W.size(); ++row) {
    Pose X_CW;
    if (!takes_part(row) || data_.camera_of_row[row] != camera ||
        !stored_pose(evaluation.nuisance_values, static_cast<size_t>(data_.frame_of_row[row]),
                     X_CW))
      continue;
    const Vec3 p_K = X_KC * (X_CW * data_.p_W[row]);
    most = std::max(most, std::atan2(std::hypot(p_K.x, p_K.y), p_K.z));
  }
  return most;
}

// What stands in the model's lens already cannot be beside another of its kind: that one begins at
// the same image. A lens of all cameras is told by the first.
std::vector<std::vector<double>> PointsProblem::starts(
    const Model& model, const effects::EffectDefinition& effect) const {
  if (effects::is_any_lens(effect)) {
    // The poses of views must be free to take what its control points leave to them.
    const bool told =
        data_.rig.type() == Rig::Type::unknown && !moves() && data_.cameras.size() == 1;
    const CameraView& only = data_.cameras.front();
    const auto like =
        told ? spline_lens_like(model, effect, only.width_px, only.height_px) : std::nullopt;
    return like ? std::vector<std::vector<double>>{*like} : std::vector<std::vector<double>>{};
  }
  if (effect.term != effects::Term::radial || data_.rig.type() != Rig::Type::unknown || moves())
    return Problem::starts(model, effect);
  const std::string name = effects::camera_of(effect.name);
  const auto of_it = std::find_if(data_.cameras.begin(), data_.cameras.end(),
                                  [&](const CameraView& view) { return view.name == name; });
  const CameraView& view = of_it == data_.cameras.end() ? data_.cameras.front() : *of_it;
  const Model own = model_of(model, view.name);
  const auto plain = effects::find_effect(effects::plain_name(effect.name));
  if (!plain || !(effects::is_excluded(*plain, own) || own.has(plain->name)))
    return Problem::starts(model, effect);
  const auto like = lens_like(own, *plain, view.width_px, view.height_px,
                              reach_rad(model, static_cast<int>(&view - data_.cameras.data())));
  return like ? std::vector<std::vector<double>>{*like} : std::vector<std::vector<double>>{};
}

}  // namespace seam::measurement
