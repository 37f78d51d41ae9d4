// Kind `points`: image positions of known points.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "measurement/fitting/low_rank.h"
#include "measurement/kinds/kinds.h"
#include "measurement/kinds/points/points_data.h"
#include "measurement/kinds/points/points_noise.h"
#include "measurement/kinds/points/points_predictor.h"
#include "measurement/kinds/points/pose_solver.h"
#include "measurement/numerics/linear_algebra.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

std::vector<effects::Lack> lacks_of(const Rig& rig) {
  using effects::Need;
  std::vector<effects::Lack> lacks = {{Need::colour, "points have no colour"}};
  if (rig.type() == Rig::Type::unknown)
    lacks.push_back({Need::known_pose, "the pose of each frame is estimated, which absorbs it"});
  if (rig.type() != Rig::Type::chain)
    lacks.push_back({Need::joints, "the camera hangs on no joint"});
  if (rig.cycle_s() == 0)
    lacks.push_back({Need::repeating_motion, "the head's motion does not repeat"});
  const auto without = [&](const std::string& joint, std::initializer_list<Need> needs) {
    const auto& joints = rig.joint_names();
    if (std::find(joints.begin(), joints.end(), joint) != joints.end()) return;
    for (const Need need : needs) lacks.push_back({need, "the rig has no joint " + joint});
  };
  without("tilt", {Need::tilt_joint, Need::tilt_reversals});
  without("roll", {Need::roll_joint, Need::roll_reversals});
  without("pan", {Need::pan_joint, Need::pan_reversals, Need::pan_turn});
  return lacks;
}

class PointsProblem : public Problem {
 public:
  explicit PointsProblem(const MeasurementSet& set) : data_(read_points(set, true, facts_)) {
    facts_.fingerprint = set.fingerprint();
    facts_.set.lacks = lacks_of(data_.rig);
    const std::array<const char*, 2> names = {"u_px", "v_px"};
    const bool known = set.noise.contains("u_px") && set.noise.contains("v_px");
    const std::array<double, 2> estimate =
        known ? std::array<double, 2>{1, 1} : estimate_points_noise(data_);
    for (int c = 0; c < 2; ++c) {
      const auto stated = set.noise.find(names[c]);
      const bool has = stated != set.noise.end();
      facts_.channels.push_back(
          {.name = names[c], .noise = has ? stated->second : estimate[c], .estimated = !has});
    }
  }

  void place(const Model& model) override {
    const Evaluation evaluation = evaluate(model, all_groups(), nullptr);
    if (evaluation.valid) place_covariates(data_, evaluation.residual, facts_);
  }

  void check_model(const Model& model) const override {
    effects::Projection(model, data_.camera.width_px, data_.camera.height_px);
  }

  Evaluation evaluate(const Model& model, const Groups& groups,
                      const Evaluation* warm) const override {
    return data_.rig.type() == Rig::Type::unknown ? evaluate_unknown(model, groups, warm)
                                                  : evaluate_rig(model, groups, warm);
  }

  std::vector<std::vector<double>> jacobian(const Model& model,
                                            const std::vector<Unknown>& unknowns,
                                            const Groups& groups,
                                            const Evaluation& here) const override;

  bool is_smooth() const override { return true; }

 private:
  Evaluation evaluate_rig(const Model& model, const Groups& groups, const Evaluation* warm) const;
  Evaluation evaluate_unknown(const Model& model, const Groups& groups,
                              const Evaluation* warm) const;
  // Derivatives of each row's image by latency and by each joint's angle: (u, v) pairs.
  struct Slopes {
    size_t width = 2;
    std::vector<double> by_row;
    std::vector<double> instant_s;
  };
  Slopes slopes_of(const PointsPredictor& predictor, const Groups& groups) const;
  void whiten_frames(const PointsPredictor& predictor, const Groups& groups, const Slopes& slopes,
                     Evaluation& evaluation) const;
  Evaluation blank() const;
  std::vector<int> neighbours(size_t row) const override;
  std::vector<Sighting> sightings(int frame, std::vector<int>& rows) const;

  PointsData data_;
};

// The nearest points in the same image.
std::vector<int> PointsProblem::neighbours(size_t row) const {
  std::vector<int> near = data_.rows_of_frame[data_.frame_of_row[row]];
  std::erase(near, static_cast<int>(row));
  const auto distance2 = [&](int other) {
    const double du = data_.u_px[other] - data_.u_px[row], dv = data_.v_px[other] - data_.v_px[row];
    return du * du + dv * dv;
  };
  const size_t count = std::min<size_t>(near.size(), 9);
  std::partial_sort(near.begin(), near.begin() + count, near.end(), [&](int a, int b) {
    return std::pair(distance2(a), a) < std::pair(distance2(b), b);
  });
  near.resize(count);
  return near;
}

Evaluation PointsProblem::blank() const {
  Evaluation evaluation;
  evaluation.residual.assign(facts_.scalars(), 0);
  evaluation.sigma.resize(facts_.scalars());
  for (size_t i = 0; i < facts_.scalars(); ++i) evaluation.sigma[i] = facts_.channels[i % 2].noise;
  return evaluation;
}

Evaluation PointsProblem::evaluate_rig(const Model& model, const Groups& groups,
                                       const Evaluation* warm) const {
  Evaluation evaluation = blank();
  evaluation.mean_key = mean_parameters(model);
  const bool reuse = warm && warm->valid && warm->mean_key == evaluation.mean_key;
  const PointsPredictor predictor(data_, model);
  if (reuse) evaluation.residual = warm->residual;
  for (size_t row = 0; row < data_.p_W.size() && !reuse; ++row) {
    if (!groups[facts_.group_of_row[row]]) continue;
    const effects::ImagePoint point = predictor.image(row);
    if (!point.visible && !(left_out(2 * row) && left_out(2 * row + 1))) evaluation.valid = false;
    evaluation.residual[2 * row] = point.visible ? data_.u_px[row] - point.u : 0;
    evaluation.residual[2 * row + 1] = point.visible ? data_.v_px[row] - point.v : 0;
  }
  whiten_diagonal(*this, groups, evaluation);
  const bool shared_causes =
      predictor.timing().jitter_sigma_s > 0 || predictor.motion().quantisation_step_rad > 0;
  if (!shared_causes) return evaluation;
  // Slopes hardly change on the way of a fit: it keeps those of its start and renews them.
  if (warm && warm->valid && warm->reusable) {
    evaluation.reusable = warm->reusable;
  } else {
    evaluation.reusable = std::make_shared<const Slopes>(slopes_of(predictor, groups));
  }
  whiten_frames(predictor, groups, *static_cast<const Slopes*>(evaluation.reusable.get()),
                evaluation);
  return evaluation;
}

PointsProblem::Slopes PointsProblem::slopes_of(const PointsPredictor& predictor,
                                               const Groups& groups) const {
  const size_t joints = data_.rig.type() == Rig::Type::chain ? data_.rig.joint_names().size() : 0;
  Slopes slopes{.width = 2 * (1 + joints)};
  slopes.by_row.assign(data_.p_W.size() * slopes.width, 0);
  slopes.instant_s.assign(data_.p_W.size(), 0);
  for (size_t row = 0; row < data_.p_W.size(); ++row) {
    if (!groups[facts_.group_of_row[row]]) continue;
    const effects::ImagePoint here = predictor.image(row);
    slopes.instant_s[row] = predictor.instant(data_.stamp_s[row], here.v);
    for (size_t cause = 0; cause < 1 + joints; ++cause) {
      std::vector<double> errors(joints, 0);
      const double by = cause == 0 ? 1e-5 : 1e-6;
      if (cause > 0) errors[cause - 1] = by;
      const effects::ImagePoint there =
          predictor.image(row, cause == 0 ? by : 0, errors.empty() ? nullptr : errors.data());
      if (!there.visible || !here.visible) continue;
      slopes.by_row[row * slopes.width + 2 * cause] = (there.u - here.u) / by;
      slopes.by_row[row * slopes.width + 2 * cause + 1] = (there.v - here.v) / by;
    }
  }
  return slopes;
}

// Jitter moves all points of a frame together; rounding of the encoder moves those seen between
// the same two samples of its log together.
void PointsProblem::whiten_frames(const PointsPredictor& predictor, const Groups& groups,
                                  const Slopes& slopes, Evaluation& evaluation) const {
  const double jitter = predictor.timing().jitter_sigma_s;
  const double step = predictor.motion().quantisation_step_rad / std::sqrt(12.0);
  const size_t joints = step > 0 ? slopes.width / 2 - 1 : 0;
  const std::vector<double>& log = data_.rig.log_times();
  for (const std::vector<int>& rows : data_.rows_of_frame) {
    if (!groups[facts_.group_of_row[rows.front()]]) continue;
    std::vector<size_t> scalars;
    double early = 1e300, late = -1e300;
    for (const int row : rows) {
      for (size_t c = 0; c < 2; ++c) {
        if (evaluation.used[2 * row + c]) scalars.push_back(2 * row + c);
      }
      early = std::min(early, slopes.instant_s[row]), late = std::max(late, slopes.instant_s[row]);
    }
    if (scalars.empty()) continue;
    size_t first = 0, nodes = 0;
    if (joints > 0) {
      first = std::upper_bound(log.begin(), log.end(), early) - log.begin();
      first = first > 0 ? first - 1 : 0;
      const size_t last = std::min<size_t>(
          std::upper_bound(log.begin(), log.end(), late) - log.begin(), log.size() - 1);
      nodes = last - first + 1;
    }
    Eigen::MatrixXd causes =
        Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(scalars.size()),
                              static_cast<Eigen::Index>((jitter > 0 ? 1 : 0) + nodes * joints));
    for (size_t k = 0; k < scalars.size(); ++k) {
      const size_t row = scalars[k] / 2;
      const double* slope = &slopes.by_row[row * slopes.width + scalars[k] % 2];
      Eigen::Index column = 0;
      if (jitter > 0) causes(static_cast<Eigen::Index>(k), column++) = jitter * slope[0];
      for (size_t j = 0; j < joints; ++j) {
        const double t = slopes.instant_s[row];
        for (size_t node = first; node < first + nodes; ++node, ++column) {
          const double width = t < log[node]
                                   ? (node > 0 ? log[node] - log[node - 1] : 1)
                                   : (node + 1 < log.size() ? log[node + 1] - log[node] : 1);
          causes(static_cast<Eigen::Index>(k), column) =
              step * slope[2 * (1 + j)] * std::max(0.0, 1 - std::abs(t - log[node]) / width);
        }
      }
    }
    whiten_low_rank(scalars, causes, facts_.group_of_row[rows.front()], evaluation);
  }
}

std::vector<Sighting> PointsProblem::sightings(int frame, std::vector<int>& rows) const {
  std::vector<Sighting> seen;
  for (const int row : data_.rows_of_frame[frame]) {
    if (left_out(2 * row) || left_out(2 * row + 1)) continue;
    rows.push_back(row);
    seen.push_back({.p_W = data_.p_W[row],
                    .u_px = data_.u_px[row],
                    .v_px = data_.v_px[row],
                    .sigma_u = facts_.channels[0].noise,
                    .sigma_v = facts_.channels[1].noise,
                    .t_s = data_.stamp_s[row]});
  }
  return seen;
}

Evaluation PointsProblem::evaluate_unknown(const Model& model, const Groups& groups,
                                           const Evaluation* warm) const {
  const effects::Projection projection(model, data_.camera.width_px, data_.camera.height_px);
  Evaluation evaluation = blank();
  evaluation.nuisance_values.assign(12 * data_.rows_of_frame.size(), 0);
  for (size_t frame = 0; frame < data_.rows_of_frame.size(); ++frame) {
    if (!groups[facts_.group_of_row[data_.rows_of_frame[frame].front()]]) continue;
    std::vector<int> rows;
    const std::vector<Sighting> seen = sightings(static_cast<int>(frame), rows);
    if (seen.empty()) continue;
    Pose X_CW;
    bool have = false;
    if (warm && warm->nuisance_values.size() == evaluation.nuisance_values.size() && warm->valid) {
      const double* stored = &warm->nuisance_values[12 * frame];
      for (int c = 0; c < 3; ++c)
        X_CW.R[c] = Vec3(stored[3 * c], stored[3 * c + 1], stored[3 * c + 2]);
      X_CW.p = Vec3(stored[9], stored[10], stored[11]);
      have = stored[0] != 0 || stored[1] != 0 || stored[2] != 0;
      have = have && refine_pose(projection, seen, X_CW);
    }
    have = have || (initial_pose(projection, seen, X_CW) && refine_pose(projection, seen, X_CW));
    std::vector<double> whitened;
    if (!have || !pose_residuals(projection, seen, X_CW, whitened, nullptr)) {
      evaluation.valid = false;
      continue;
    }
    evaluation.nuisances += 6;
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r < 3; ++r) evaluation.nuisance_values[12 * frame + 3 * c + r] = X_CW.R[c][r];
      evaluation.nuisance_values[12 * frame + 9 + c] = X_CW.p[c];
    }
    for (const int row : data_.rows_of_frame[frame]) {  // Outliers too: they may come back.
      const effects::ImagePoint point =
          projection.project(X_CW * data_.p_W[row], data_.stamp_s[row], data_.v_px[row]);
      evaluation.residual[2 * row] = point.visible ? data_.u_px[row] - point.u : 0;
      evaluation.residual[2 * row + 1] = point.visible ? data_.v_px[row] - point.v : 0;
    }
  }
  whiten_diagonal(*this, groups, evaluation);
  return evaluation;
}

std::vector<std::vector<double>> PointsProblem::jacobian(const Model& model,
                                                         const std::vector<Unknown>& unknowns,
                                                         const Groups& groups,
                                                         const Evaluation& here) const {
  if (data_.rig.type() != Rig::Type::unknown)
    return Problem::jacobian(model, unknowns, groups, here);
  // Differences at fixed poses, less what the frame's own pose can follow (Kaufman 1975).
  std::vector<std::vector<double>> columns(unknowns.size(),
                                           std::vector<double>(facts_.scalars(), 0));
  const effects::Projection projection(model, data_.camera.width_px, data_.camera.height_px);
  std::vector<effects::Projection> moved;
  std::vector<double> steps;
  for (const Unknown& unknown : unknowns) {
    const effects::ModelEffect& effect = *model.find(unknown.effect);
    const double value = effect.parameters[unknown.parameter].value;
    const double step =
        1e-5 * std::max(effect.definition->parameters[unknown.parameter].scale, std::abs(value));
    Model changed = model;
    changed.set_value(unknown.effect, unknown.parameter, value + step);
    moved.emplace_back(changed, data_.camera.width_px, data_.camera.height_px);
    steps.push_back(step);
  }
  for (size_t frame = 0; frame < data_.rows_of_frame.size(); ++frame) {
    if (!groups[facts_.group_of_row[data_.rows_of_frame[frame].front()]]) continue;
    std::vector<int> rows;
    const std::vector<Sighting> seen = sightings(static_cast<int>(frame), rows);
    if (seen.empty()) continue;
    const double* stored = &here.nuisance_values[12 * frame];
    Pose X_CW;
    for (int c = 0; c < 3; ++c)
      X_CW.R[c] = Vec3(stored[3 * c], stored[3 * c + 1], stored[3 * c + 2]);
    X_CW.p = Vec3(stored[9], stored[10], stored[11]);
    std::vector<double> base, derivatives, there;
    if (!pose_residuals(projection, seen, X_CW, base, &derivatives)) continue;
    const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>> pose(
        derivatives.data(), base.size(), 6);
    const Eigen::MatrixXd basis = column_basis(pose);
    for (size_t p = 0; p < unknowns.size(); ++p) {
      if (!pose_residuals(moved[p], seen, X_CW, there, nullptr)) continue;
      Eigen::VectorXd column(base.size());
      for (size_t k = 0; k < base.size(); ++k) column[k] = (there[k] - base[k]) / steps[p];
      column -= basis * (basis.transpose() * column);
      for (size_t k = 0; k < rows.size(); ++k) {
        for (size_t c = 0; c < 2; ++c) columns[p][2 * rows[k] + c] = column[2 * k + c];
      }
    }
  }
  return columns;
}

std::unique_ptr<Problem> open_points(const MeasurementSet& set) {
  return std::make_unique<PointsProblem>(set);
}

}  // namespace

Kind points_kind() {
  return {.bit = effects::kPoints,
          .observations = {.file = "points",
                           .keys = {"frame", "time_s", "point"},
                           .measured = {"u_px", "v_px"},
                           .in_image = true},
          .open = [](const MeasurementSet& set, const Instruments&) { return open_points(set); },
          .measure = [](const Model& truth, const MeasurementSet& protocol,
                        const MeasureOptions& options,
                        const Instruments&) { measure_points(truth, protocol, options); },
          .behind_camera = lines_behind_camera};
}

}  // namespace seam::measurement
