// Kind `points`: image positions of known points.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "effects/stages/geometry.h"
#include "effects/stages/timing.h"
#include "measurement/fitting/low_rank.h"
#include "measurement/kinds/kinds.h"
#include "measurement/kinds/points/points_data.h"
#include "measurement/kinds/points/points_noise.h"
#include "measurement/kinds/points/pose_solver.h"
#include "measurement/numerics/linear_algebra.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

// A model compiled for one set: stamps to instants, instants to poses, poses to image points.
class Predictor {
 public:
  Predictor(const PointsData& data, const Model& model)
      : data_(data),
        timing_(effects::timing_of(model)),
        motion_(data.rig.motion(model)),
        projection_(model, data.camera.width_px, data.camera.height_px) {}

  // Seconds since the reference at which the frame's row is seen.
  double instant(double stamp_s, double row) const {
    double start = stamp_s;
    const double cycle = data_.rig.cycle_s();
    if (timing_.sync_period_frames > 0 && cycle > 0) {
      const double slot = cycle / timing_.sync_period_frames;
      start = std::round(stamp_s / slot) * slot;
    }
    return start + timing_.row_middle_after_stamp_s(row, stamp_s);
  }

  // `late_s` and `joint_errors` are small changes for derivatives.
  effects::ImagePoint image(size_t row, double late_s = 0,
                            const double* joint_errors = nullptr) const {
    const Vec3& p_W = data_.p_W[row];
    double v = data_.v_px[row];
    if (timing_.line_delay_s == 0) {
      const double t = instant(data_.stamp_s[row], v) + late_s;
      return projection_.project(motion_.to_camera(t, p_W, joint_errors), t, v);
    }
    effects::ImagePoint point;
    double previous_v = v, previous_f = 0;
    for (int step = 0; step < 30; ++step) {
      const double t = instant(data_.stamp_s[row], v) + late_s;
      point = projection_.project(motion_.to_camera(t, p_W, joint_errors), t, v);
      if (!point.visible) return point;
      // The row at which the point is seen is the fixed point of v -> image row; secant steps.
      const double f = point.v - v;
      if (std::abs(f) < 1e-8) break;
      const double slope = step == 0 || v == previous_v ? -1 : (f - previous_f) / (v - previous_v);
      previous_v = v, previous_f = f;
      v = std::abs(slope) > 0.1 ? v - f / slope : point.v;
    }
    return point;
  }

  const effects::Timing& timing() const { return timing_; }
  const Rig::Motion& motion() const { return motion_; }
  const effects::Projection& projection() const { return projection_; }

 private:
  const PointsData& data_;
  effects::Timing timing_;
  Rig::Motion motion_;
  effects::Projection projection_;
};

class PointsProblem : public Problem {
 public:
  explicit PointsProblem(const MeasurementSet& set) : data_(read_points(set, true, facts_)) {
    facts_.fingerprint = set.fingerprint();
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

  std::string not_testable(const Model& model, const EffectDefinition& effect,
                           size_t parameter) const override;
  std::vector<std::vector<double>> starts(const Model& model,
                                          const EffectDefinition& effect) const override;
  std::string advice(const std::string& effect, const std::string& other) const override;
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
  Slopes slopes_of(const Predictor& predictor, const Groups& groups) const;
  void whiten_frames(const Predictor& predictor, const Groups& groups, const Slopes& slopes,
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
  const Predictor predictor(data_, model);
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

PointsProblem::Slopes PointsProblem::slopes_of(const Predictor& predictor,
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
void PointsProblem::whiten_frames(const Predictor& predictor, const Groups& groups,
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

std::string PointsProblem::not_testable(const Model&, const EffectDefinition& effect,
                                        size_t parameter) const {
  const std::string& name = effect.parameters[parameter].name;
  const bool unknown = data_.rig.type() == Rig::Type::unknown;
  if (unknown && effect.stage != effects::Stage::geometry)
    return "the pose of each frame is estimated, which absorbs it";
  if (effect.stage == effects::Stage::joint) {
    if (data_.rig.type() != Rig::Type::chain) return "the camera hangs on no joint";
    const std::string joint = name.rfind("tilt", 0) == 0   ? "tilt"
                              : name.rfind("roll", 0) == 0 ? "roll"
                                                           : "pan";
    const auto& joints = data_.rig.joint_names();
    if (!effect.spread_only && std::find(joints.begin(), joints.end(), joint) == joints.end() &&
        !effect.joint_map) {
      return "the rig has no joint " + joint;
    }
  }
  if (effect.name == "frame_sync" && data_.rig.cycle_s() == 0)
    return "the head's motion does not repeat";
  if (effect.name == "chromatic_aberration") return "points have no colour";
  return "";
}

std::vector<std::vector<double>> PointsProblem::starts(const Model& model,
                                                       const EffectDefinition& effect) const {
  if (effect.name == "frame_sync") {
    std::vector<std::vector<double>> all;
    for (int frames = 2; frames <= 100; ++frames) all.push_back({static_cast<double>(frames)});
    return all;
  }
  if (effect.name == "encoder_eccentricity") {
    std::vector<std::vector<double>> all;
    for (int k = 0; k < 4; ++k) all.push_back({0.005, -2.4 + 1.6 * k});
    return all;
  }
  if (effect.name == "fisheye") return {{0, 0, 0, 0}};
  return Problem::starts(model, effect);
}

std::string PointsProblem::advice(const std::string& effect, const std::string& other) const {
  const auto pair = [&](const char* a, const char* b) {
    return (effect == a && other == b) || (effect == b && other == a);
  };
  if (pair("frame_latency", "exposure"))
    return "Expose for two different known times: only the window's length moves with the "
           "exposure.";
  if (pair("rolling_shutter", "frame_latency"))
    return "Swing faster with points over all rows: a line delay grows with the row, a latency "
           "does not.";
  if (pair("encoder_offset", "principal_point_offset"))
    return "Tilt the head far while panning, and bring points near: an offset of a joint turns "
           "with the chain.";
  if (pair("focal_length_error", "encoder_scale"))
    return "See the same points at several head angles, up to both ends of the joint.";
  if (pair("encoder_offset", "mount_misalignment"))
    return "Tilt the head over its whole range: a mount turns with the last link.";
  if (pair("mount_offset", "encoder_offset"))
    return "Bring points near to the camera: a shift shows in proportion to 1 / distance.";
  return "";
}

std::unique_ptr<Problem> open_points(const MeasurementSet& set) {
  return std::make_unique<PointsProblem>(set);
}

void measure_points(const Model& truth, const MeasurementSet& protocol,
                    const MeasureOptions& options) {
  Facts facts;
  PointsData data = read_points(protocol, false, facts);
  if (data.rig.type() == Rig::Type::unknown) {
    protocol.root.at("rig").fail(
        "found an unknown pose, expected a chain or poses: a protocol must say where the camera "
        "is");
  }
  const CsvTable table = protocol.table("points");
  std::fill(data.v_px.begin(), data.v_px.end(), 0.5 * data.camera.height_px);
  const effects::Timing timing = effects::timing_of(truth);
  const RandomStream stream = RandomStream{.seed = options.seed}.child("measure").child("points");
  // Spreads of whole frames are drawn: a latency a frame, an error at each sample of the log.
  const Predictor predictor(data, truth);
  const double step = options.noise ? predictor.motion().quantisation_step_rad : 0;
  std::vector<std::string> columns = table.columns();
  for (const char* name : {"u_px", "v_px"}) {
    if (!table.has(name)) columns.push_back(name);
  }
  CsvWriter out(columns);
  for (size_t row = 0; row < data.p_W.size(); ++row) {
    const uint64_t frame = static_cast<uint64_t>(data.frame_of_row[row]);
    const double late =
        options.noise ? timing.jitter_sigma_s * normal(stream.child("frame_jitter"), frame) : 0;
    std::vector<double> errors(data.rig.joint_names().size(), 0);
    if (step > 0) {
      for (size_t j = 0; j < errors.size(); ++j) {
        // The logged angle is the true one rounded; the true one lies within half a step of it.
        const auto& log = data.rig.log_times();
        const double t = predictor.instant(data.stamp_s[row], 0.5 * data.camera.height_px);
        const size_t node = std::min<size_t>(
            std::upper_bound(log.begin(), log.end(), t) - log.begin(), log.size() - 1);
        errors[j] = step * (uniform(stream.child("encoder_quantisation").child(j), node) - 0.5);
      }
    }
    const effects::ImagePoint point =
        predictor.image(row, late, errors.empty() ? nullptr : errors.data());
    double u = point.u, v = point.v;
    if (options.noise) {
      const auto sigma = [&](const char* name) {
        return protocol.noise.contains(name) ? protocol.noise.at(name) : 0.0;
      };
      u += sigma("u_px") * normal(stream.child("noise"), 2 * row);
      v += sigma("v_px") * normal(stream.child("noise"), 2 * row + 1);
    }
    const bool inside =
        u > -0.5 && v > -0.5 && u < data.camera.width_px - 0.5 && v < data.camera.height_px - 0.5;
    if (!point.visible || !inside) continue;
    std::vector<std::string> cells;
    for (const std::string& name : columns) {
      cells.push_back(name == "u_px"   ? fmt::format("{:.6f}", u)
                      : name == "v_px" ? fmt::format("{:.6f}", v)
                                       : std::string(table.cell(row, name)));
    }
    out.row(cells);
  }
  copy_protocol(protocol, options.out, {"points"});
  out.write(written_path(options.out, protocol.files.at("points")));
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
