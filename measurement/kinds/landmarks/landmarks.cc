// Kind `landmarks`: range and bearing of known landmarks from a moving robot.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "effects/stages/detector.h"
#include "effects/stages/geometry.h"
#include "effects/stages/timing.h"
#include "measurement/fitting/low_rank.h"
#include "measurement/kinds/kinds.h"
#include "measurement/numerics/robust.h"
#include "measurement/sets/rig.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

const std::vector<std::string> kColumns = {"run", "time_s", "landmark", "range_m", "bearing_rad"};

struct PlanePose {
  double x_m, y_m, theta_rad;
};

// One run's measured poses.
struct Walk {
  Spline x, y, theta;  // Heading unwrapped.

  PlanePose at(double t_s) const { return {x.value(t_s), y.value(t_s), theta.value(t_s)}; }
};

struct LandmarkData {
  std::vector<Walk> walks;
  std::vector<int> walk_of_row;
  std::vector<double> stamp_s;                 // Since the first time of the poses.
  std::vector<double> landmark_x, landmark_y;  // By row.
  std::vector<int> landmark_of_row;
  std::vector<double> range_m, bearing_rad;
  std::vector<std::vector<int>> rows_of_frame;  // Seen at the same stamp of the same run.
};

void read_walks(const MeasurementSet& set, LandmarkData& data, std::vector<std::string>& runs,
                int64_t& reference_ns) {
  const CsvTable table = set.table("poses");
  if (table.rows() < 2)
    throw InputError(
        fmt::format("{}: found {} rows, expected 2 or more", table.file(), table.rows()));
  reference_ns = table.times_ns("time_s").front();
  const bool has_run = table.has("run");
  const std::vector<int> run_of_row =
      has_run ? number_groups(table.texts("run"), runs) : std::vector<int>(table.rows(), 0);
  if (!has_run) runs = {""};
  const std::vector<double> x = table.numbers("x_m"), y = table.numbers("y_m"),
                            theta = table.numbers("theta_rad");
  for (size_t run = 0; run < runs.size(); ++run) {
    std::vector<size_t> rows, keep;
    for (size_t row = 0; row < table.rows(); ++row) {
      if (run_of_row[row] == static_cast<int>(run)) rows.push_back(row);
    }
    const std::vector<double> times = log_seconds(table, "time_s", reference_ns, rows, keep);
    std::vector<double> px, py, heading;
    for (const size_t row : keep) {
      px.push_back(x[row]);
      py.push_back(y[row]);
      heading.push_back(heading.empty()
                            ? theta[row]
                            : heading.back() + maths::wrap_angle(theta[row] - heading.back()));
    }
    std::vector<double> steps;
    for (size_t i = 0; i + 1 < times.size(); ++i) steps.push_back(times[i + 1] - times[i]);
    const double gap = steps.empty() ? 1 : 6 * median_of(steps);
    data.walks.push_back(
        {Spline(times, px, gap), Spline(times, py, gap), Spline(times, heading, gap)});
  }
}

// Blocks of time serve as groups where the table has no column to hold out by.
std::vector<std::string> time_blocks(const std::vector<double>& stamps) {
  constexpr int kBlocks = 20;
  const auto [first, last] = std::minmax_element(stamps.begin(), stamps.end());
  std::vector<std::string> blocks;
  for (const double t : stamps) {
    const double share = *last > *first ? (t - *first) / (*last - *first) : 0;
    blocks.push_back("block " +
                     std::to_string(std::min(kBlocks - 1, static_cast<int>(share * kBlocks))));
  }
  return blocks;
}

LandmarkData read_landmarks(const MeasurementSet& set, bool measured, Facts& facts) {
  LandmarkData data;
  std::vector<std::string> runs;
  int64_t reference_ns = 0;
  read_walks(set, data, runs, reference_ns);
  std::map<std::string, std::pair<double, double>> landmarks;
  const CsvTable known = set.table("landmarks");
  const std::vector<double> lx = known.numbers("x_m"), ly = known.numbers("y_m");
  const std::vector<std::string> names = known.texts("landmark");
  for (size_t row = 0; row < known.rows(); ++row) {
    if (!landmarks.emplace(names[row], std::pair(lx[row], ly[row])).second) {
      known.fail(row, "landmark", names[row], "each landmark once");
    }
  }
  const CsvTable table = set.table("observations");
  if (table.rows() == 0) throw InputError(table.file() + ": no rows, expected observations");
  facts.kind_bit = effects::kLandmarks;
  facts.title = set.title;
  facts.file = table.file();
  const std::vector<int64_t> ns = table.times_ns("time_s");
  data.range_m = measured ? table.numbers("range_m") : std::vector<double>(table.rows(), 0);
  data.bearing_rad = measured ? table.numbers("bearing_rad") : std::vector<double>(table.rows(), 0);
  std::vector<std::string> labels;
  data.landmark_of_row = number_groups(table.texts("landmark"), labels);
  std::vector<std::string> frames, frame_names;
  const bool has_run =
      table.has("run") && runs.size() > 0 && !(runs.size() == 1 && runs[0].empty());
  for (size_t row = 0; row < table.rows(); ++row) {
    const std::string run(has_run ? table.cell(row, "run") : "");
    const auto walk = std::find(runs.begin(), runs.end(), run);
    if (walk == runs.end()) table.fail(row, "run", run, "a run of " + set.files.at("poses"));
    data.walk_of_row.push_back(static_cast<int>(walk - runs.begin()));
    const std::string landmark(table.cell(row, "landmark"));
    const auto found = landmarks.find(landmark);
    if (found == landmarks.end())
      table.fail(row, "landmark", landmark, "a landmark of " + set.files.at("landmarks"));
    data.landmark_x.push_back(found->second.first);
    data.landmark_y.push_back(found->second.second);
    data.stamp_s.push_back(1e-9 * static_cast<double>(ns[row] - reference_ns));
    const std::vector<double>& times = data.walks[data.walk_of_row[row]].x.times();
    if (data.stamp_s[row] < times.front() - 1 || data.stamp_s[row] > times.back() + 1) {
      table.fail(row, "time_s", table.cell(row, "time_s"), "a time within the poses of its run");
    }
    if (measured && data.range_m[row] < 0)
      table.fail(row, "range_m", table.cell(row, "range_m"), "a distance of 0 or more");
    frames.push_back(run + "|" + std::to_string(ns[row]));
    facts.line_of_row.push_back(table.line(row));
    for (int channel = 0; channel < 2; ++channel) {
      facts.row_of.push_back(static_cast<int>(row));
      facts.channel_of.push_back(channel);
    }
  }
  const std::vector<std::string> groups =
      table.has(set.group) ? table.texts(set.group) : time_blocks(data.stamp_s);
  facts.group_of_row = number_groups(groups, facts.groups);
  // A frame is the same stamp of the same run, within one group.
  for (size_t row = 0; row < frames.size(); ++row) frames[row] += "|" + groups[row];
  const std::vector<int> frame_of_row = number_groups(frames, frame_names);
  data.rows_of_frame.resize(frame_names.size());
  for (size_t row = 0; row < frames.size(); ++row)
    data.rows_of_frame[frame_of_row[row]].push_back(static_cast<int>(row));
  facts.time_of_row = data.stamp_s;
  for (size_t row = 0; row < table.rows(); ++row) {
    facts.series_of_row.push_back(data.walk_of_row[row] * static_cast<int>(labels.size()) +
                                  data.landmark_of_row[row]);
  }
  if (measured) {
    for (const std::string& column : table.extra_numeric_columns(kColumns)) {
      facts.covariates.push_back({.name = column, .values = table.numbers(column)});
    }
  }
  return data;
}

// A model compiled for one set.
class Predictor {
 public:
  Predictor(const LandmarkData& data, const Model& model)
      : data_(data), timing_(effects::timing_of(model)), X_LC_(effects::mount_of(model)) {
    for (const effects::ModelEffect& effect : model.effects()) {
      if (effect.definition->detector) detectors_.push_back(effect);
    }
    // Landmarks lie in the plane: of the mount's rotation only the yaw matters. The camera looks
    // along its z, which is the link's x.
    yaw_rad_ = std::atan2(X_LC_.R[2].y, X_LC_.R[2].x);
  }

  effects::Detection detect(size_t row, double late_s = 0) const {
    const double stamp = data_.stamp_s[row];
    const double t = stamp + timing_.row_middle_after_stamp_s(0, stamp) + late_s;
    const PlanePose pose = data_.walks[data_.walk_of_row[row]].at(t);
    const double dx = data_.landmark_x[row] - pose.x_m, dy = data_.landmark_y[row] - pose.y_m;
    const double c = std::cos(pose.theta_rad), s = std::sin(pose.theta_rad);
    const double ahead = c * dx + s * dy - X_LC_.p.x;
    const double left = -s * dx + c * dy - X_LC_.p.y;
    effects::Detection seen{.range_m = std::hypot(ahead, left),
                            .bearing_rad = maths::wrap_angle(std::atan2(left, ahead) - yaw_rad_),
                            .t_s = t};
    for (const effects::ModelEffect& effect : detectors_)
      effect.definition->detector(effect.values(), seen);
    return seen;
  }

  const effects::Timing& timing() const { return timing_; }

 private:
  const LandmarkData& data_;
  effects::Timing timing_;
  Pose X_LC_;
  double yaw_rad_ = 0;
  std::vector<effects::ModelEffect> detectors_;
};

class LandmarksProblem : public Problem {
 public:
  explicit LandmarksProblem(const MeasurementSet& set) : data_(read_landmarks(set, true, facts_)) {
    facts_.fingerprint = set.fingerprint();
    add_covariates();
    const Predictor ideal(data_, Model::from_config(ConfigNode::from_text(
                                     "format: seam-model/1\neffects: {}\n", "none")));
    const std::array<const char*, 2> names = {"range_m", "bearing_rad"};
    for (int c = 0; c < 2; ++c) {
      const auto stated = set.noise.find(names[c]);
      const bool known = stated != set.noise.end();
      facts_.channels.push_back({.name = names[c],
                                 .noise = known ? stated->second : estimate_noise(ideal, c),
                                 .estimated = !known});
    }
  }

  void check_model(const Model& model) const override {
    for (const effects::ModelEffect& effect : model.effects()) {
      if (!acts(*effect.definition)) {
        throw InputError(
            fmt::format("effect '{}' does not act on landmarks, expected a model of their detector",
                        effect.definition->name));
      }
    }
  }

  Evaluation evaluate(const Model& model, const Groups& groups, const Evaluation*) const override;

  std::string not_testable(const Model&, const EffectDefinition& effect,
                           size_t parameter) const override {
    const std::string& name = effect.parameters[parameter].name;
    const bool plane = (effect.name == "mount_misalignment" && name != "yaw_rad") ||
                       (effect.name == "mount_offset" && name == "z_m");
    return plane ? "ranges and bearings in the plane do not see it" : "";
  }

  std::string advice(const std::string& a, const std::string& b) const override {
    const auto pair = [&](const char* x, const char* y) {
      return (a == x && b == y) || (a == y && b == x);
    };
    if (pair("range_scale", "range_offset"))
      return "See landmarks from near and from far: a scale grows with the range.";
    if (pair("mount_misalignment", "frame_latency"))
      return "Turn both ways: a latency changes its sign with the turn, a mount does not.";
    if (pair("bearing_scale", "mount_misalignment"))
      return "See landmarks on both sides: a scale changes its sign, a mount does not.";
    if (pair("mount_offset", "range_offset"))
      return "See landmarks in all directions: an offset of the mount turns with the bearing.";
    return "";
  }

 private:
  void add_covariates();
  double estimate_noise(const Predictor& ideal, int channel) const;
  double residual(const effects::Detection& seen, size_t row, int channel) const {
    return channel == 0 ? data_.range_m[row] - seen.range_m
                        : std::remainder(data_.bearing_rad[row] - seen.bearing_rad, 2 * maths::kPi);
  }

  LandmarkData data_;
};

// From where the robot was, never from what it measured: an observation's noise must not stand on
// both sides of a regression.
void LandmarksProblem::add_covariates() {
  const Predictor ideal(data_, Model::from_config(ConfigNode::from_text(
                                   "format: seam-model/1\neffects: {}\n", "none")));
  const size_t n = data_.stamp_s.size();
  std::vector<double> range(n), bearing(n), heading(n), speed(n), turn(n), sign(n);
  for (size_t row = 0; row < n; ++row) {
    const effects::Detection seen = ideal.detect(row);
    const Walk& walk = data_.walks[data_.walk_of_row[row]];
    const double t = data_.stamp_s[row];
    range[row] = seen.range_m;
    bearing[row] = seen.bearing_rad;
    heading[row] = maths::wrap_angle(walk.theta.value(t));
    speed[row] = std::cos(walk.theta.value(t)) * walk.x.rate(t) +
                 std::sin(walk.theta.value(t)) * walk.y.rate(t);
    turn[row] = walk.theta.rate(t);
    sign[row] = turn[row] > 0 ? 1 : turn[row] < 0 ? -1 : 0;
  }
  auto& all = facts_.covariates;
  const auto add = [&](const char* name, std::vector<double> values,
                       Covariate::Type type = Covariate::Type::smooth) {
    all.push_back({.name = name, .type = type, .values = std::move(values)});
  };
  add("time", data_.stamp_s);
  add("range", std::move(range));
  add("bearing", std::move(bearing));
  add("heading", std::move(heading));
  add("speed", std::move(speed));
  add("heading_rate", std::move(turn));
  add("sign(heading_rate)", std::move(sign), Covariate::Type::sign);
  add("landmark", {data_.landmark_of_row.begin(), data_.landmark_of_row.end()},
      Covariate::Type::category);
  add("run", {facts_.group_of_row.begin(), facts_.group_of_row.end()}, Covariate::Type::category);
}

Evaluation LandmarksProblem::evaluate(const Model& model, const Groups& groups,
                                      const Evaluation*) const {
  const Predictor predictor(data_, model);
  Evaluation evaluation;
  evaluation.residual.assign(facts_.scalars(), 0);
  evaluation.sigma.assign(facts_.scalars(), 1);
  for (size_t row = 0; row < data_.stamp_s.size(); ++row) {
    if (!groups[facts_.group_of_row[row]]) continue;
    const effects::Detection seen = predictor.detect(row);
    const double variance[2] = {seen.range_variance, seen.bearing_variance};
    for (int c = 0; c < 2; ++c) {
      const double noise = facts_.channels[c].noise;
      evaluation.residual[2 * row + c] = residual(seen, row, c);
      evaluation.sigma[2 * row + c] = std::sqrt(noise * noise + variance[c]);
    }
  }
  whiten_diagonal(*this, groups, evaluation);
  const double jitter = predictor.timing().jitter_sigma_s;
  if (!(jitter > 0)) return evaluation;
  for (const std::vector<int>& rows : data_.rows_of_frame) {
    if (!groups[facts_.group_of_row[rows.front()]]) continue;
    std::vector<size_t> scalars;
    std::vector<double> effect;
    for (const int row : rows) {
      const effects::Detection early = predictor.detect(row, -1e-3),
                               late = predictor.detect(row, 1e-3);
      const double slope[2] = {
          (late.range_m - early.range_m) / 2e-3,
          std::remainder(late.bearing_rad - early.bearing_rad, 2 * maths::kPi) / 2e-3};
      for (int c = 0; c < 2; ++c) {
        if (!evaluation.used[2 * row + c]) continue;
        scalars.push_back(2 * row + c);
        effect.push_back(jitter * slope[c]);
      }
    }
    if (scalars.empty()) continue;
    const Eigen::MatrixXd causes =
        Eigen::Map<const Eigen::VectorXd>(effect.data(), static_cast<Eigen::Index>(effect.size()));
    whiten_low_rank(scalars, causes, facts_.group_of_row[rows.front()], evaluation);
  }
  return evaluation;
}

// What a straight line between the two neighbours on a landmark's track leaves.
double LandmarksProblem::estimate_noise(const Predictor& ideal, int channel) const {
  const size_t n = data_.stamp_s.size();
  std::vector<int> order(n);
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](int row) {
    return std::pair(facts_.series_of_row[row], data_.stamp_s[row]);
  };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
  std::vector<double> steps, second, plain;
  for (size_t i = 0; i + 1 < n; ++i) {
    if (key(order[i]).first == key(order[i + 1]).first)
      steps.push_back(key(order[i + 1]).second - key(order[i]).second);
  }
  const double longest = 4 * std::max(median_of(steps), 1e-3);
  std::vector<double> r(n);
  for (size_t row = 0; row < n; ++row) r[row] = residual(ideal.detect(row), row, channel);
  for (size_t i = 1; i + 1 < n; ++i) {
    const int a = order[i - 1], b = order[i], c = order[i + 1];
    plain.push_back(r[b]);
    const double before = data_.stamp_s[b] - data_.stamp_s[a],
                 after = data_.stamp_s[c] - data_.stamp_s[b];
    if (key(a).first != key(c).first || before > longest || after > longest ||
        !(before + after > 0))
      continue;
    const double w = after / (before + after);
    second.push_back((r[b] - w * r[a] - (1 - w) * r[c]) / std::sqrt(1 + w * w + (1 - w) * (1 - w)));
  }
  if (second.size() < 30) {
    const double middle = median_of(plain);
    for (double& value : plain) value -= middle;
    second = plain;
  }
  return std::max(robust_sigma(second), 1e-9);
}

std::unique_ptr<Problem> open_landmarks(const MeasurementSet& set) {
  return std::make_unique<LandmarksProblem>(set);
}

void measure_landmarks(const Model& truth, const MeasurementSet& protocol,
                       const MeasureOptions& options) {
  Facts facts;
  const LandmarkData data = read_landmarks(protocol, false, facts);
  const CsvTable table = protocol.table("observations");
  const Predictor predictor(data, truth);
  const RandomStream stream =
      RandomStream{.seed = options.seed}.child("measure").child("landmarks");
  std::vector<std::string> columns = table.columns();
  for (const char* name : {"range_m", "bearing_rad"}) {
    if (!table.has(name)) columns.push_back(name);
  }
  std::vector<uint64_t> frame_of_row(data.stamp_s.size());
  for (size_t frame = 0; frame < data.rows_of_frame.size(); ++frame) {
    for (const int row : data.rows_of_frame[frame]) frame_of_row[row] = frame;
  }
  CsvWriter out(columns);
  for (size_t row = 0; row < data.stamp_s.size(); ++row) {
    const double late = options.noise ? predictor.timing().jitter_sigma_s *
                                            normal(stream.child("frame_jitter"), frame_of_row[row])
                                      : 0;
    effects::Detection seen = predictor.detect(row, late);
    if (options.noise) {
      const auto stated = [&](const char* name) {
        return protocol.noise.contains(name) ? protocol.noise.at(name) : 0.0;
      };
      seen.range_m += std::hypot(stated("range_m"), std::sqrt(seen.range_variance)) *
                      normal(stream.child("noise"), 2 * row);
      seen.bearing_rad += std::hypot(stated("bearing_rad"), std::sqrt(seen.bearing_variance)) *
                          normal(stream.child("noise"), 2 * row + 1);
    }
    std::vector<std::string> cells;
    for (const std::string& name : columns) {
      cells.push_back(name == "range_m" ? fmt::format("{:.7f}", std::max(0.0, seen.range_m))
                      : name == "bearing_rad"
                          ? fmt::format("{:.8f}", maths::wrap_angle(seen.bearing_rad))
                          : std::string(table.cell(row, name)));
    }
    out.row(cells);
  }
  copy_protocol(protocol, options.out, {"observations"});
  out.write(written_path(options.out, protocol.files.at("observations")));
}

}  // namespace

Kind landmarks_kind() {
  return {.bit = effects::kLandmarks,
          .observations = {.file = "observations",
                           .keys = {"run", "time_s", "landmark"},
                           .measured = {"range_m", "bearing_rad"}},
          .open = [](const MeasurementSet& set, const Instruments&) { return open_landmarks(set); },
          .measure = [](const Model& truth, const MeasurementSet& protocol,
                        const MeasureOptions& options,
                        const Instruments&) { measure_landmarks(truth, protocol, options); }};
}

}  // namespace seam::measurement
