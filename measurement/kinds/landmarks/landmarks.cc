// Kind `landmarks`: range and bearing of known landmarks from a moving robot.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "measurement/fitting/low_rank.h"
#include "measurement/kinds/kinds.h"
#include "measurement/kinds/landmarks/landmark_predictor.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

class LandmarksProblem : public Problem {
 public:
  explicit LandmarksProblem(const MeasurementSet& set) : data_(read_landmarks(set, true, facts_)) {
    facts_.fingerprint = set.fingerprint();
    facts_.set.lacks = {{effects::Need::space, "ranges and bearings in the plane do not see it"}};
    add_covariates();
    const LandmarkPredictor ideal(data_, Model::from_config(ConfigNode::from_text(
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

 private:
  void add_covariates();
  double estimate_noise(const LandmarkPredictor& ideal, int channel) const;
  double residual(const effects::Detection& seen, size_t row, int channel) const {
    return channel == 0 ? data_.range_m[row] - seen.range_m
                        : std::remainder(data_.bearing_rad[row] - seen.bearing_rad, 2 * maths::kPi);
  }

  LandmarkData data_;
};

// From where the robot was, never from what it measured: an observation's noise must not stand on
// both sides of a regression.
void LandmarksProblem::add_covariates() {
  const LandmarkPredictor ideal(data_, Model::from_config(ConfigNode::from_text(
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
  const LandmarkPredictor predictor(data_, model);
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
double LandmarksProblem::estimate_noise(const LandmarkPredictor& ideal, int channel) const {
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
