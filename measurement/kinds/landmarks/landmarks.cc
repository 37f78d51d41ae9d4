// Kind `landmarks`: range and bearing of known landmarks from a moving robot.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "measurement/kinds/kinds.h"
#include "measurement/kinds/landmarks/landmark_findings.h"
#include "measurement/kinds/landmarks/landmark_noise.h"
#include "measurement/kinds/landmarks/landmark_predictor.h"
#include "measurement/kinds/landmarks/landmark_starts.h"
#include "measurement/noise/low_rank.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

class LandmarksProblem : public Problem {
 public:
  explicit LandmarksProblem(const MeasurementSet& set) : data_(read_landmarks(set, true, facts_)) {
    facts_.fingerprint = set.fingerprint();
    rows_of_errors_ = rows_of_errors(data_, facts_);
    facts_.set.lacks = {
        {effects::Need::space, data_.heights
                                   ? "bearings are angles in the plane, and heights are taken as "
                                     "the set states them"
                                   : "ranges and bearings in the plane do not see it"}};
    if (data_.channels[0] < 0)
      facts_.set.lacks.push_back({effects::Need::distances, "no range was measured"});
    if (data_.channels[1] < 0)
      facts_.set.lacks.push_back({effects::Need::bearings, "no bearing was measured"});
    if (stands_still())
      facts_.set.lacks.push_back({effects::Need::moving_view, "the robot stands in every row"});
    add_covariates();
    if (!sees_from_sides())
      facts_.set.lacks.push_back(
          {effects::Need::landmark_places,
           "each landmark is seen from one side alone, from where its place and a bias of the "
           "detector look the same"});
    const LandmarkPredictor ideal(data_, Model::from_config(ConfigNode::from_text(
                                             "format: seam-model/1\neffects: {}\n", "none")));
    for (int c = 0; c < 2; ++c) {
      if (data_.channels[c] < 0) continue;
      const auto stated = set.noise.find(kLandmarkColumns[c]);
      const bool known = stated != set.noise.end();
      facts_.channels.push_back({.name = kLandmarkColumns[c],
                                 .noise = known ? stated->second : estimate_noise(ideal, c),
                                 .estimated = !known,
                                 .correctable = !known});
    }
  }

  std::vector<std::string> formula_columns() const override { return data_.further.names; }
  void check_model(const Model& model) const override {
    check_columns(model, {effects::Stage::detector});
    for (const effects::ModelEffect& effect : model.effects()) {
      if (!acts(*effect.definition)) {
        throw InputError(
            fmt::format("effect '{}' does not act on landmarks, expected a model of their detector",
                        effect.definition->name));
      }
    }
  }

  Evaluation evaluate(const Model& model, const Groups& groups, const Evaluation*) const override;
  std::vector<Finding> findings(const Model& model) const override;
  std::vector<FieldPlace> field_places(const Model&, const Evaluation& here) const override {
    return {over_time_by_landmark(data_, facts_, here)};
  }
  std::vector<std::vector<double>> starts(const Model& model,
                                          const EffectDefinition& effect) const override {
    if (!has_shapes(effect)) return Problem::starts(model, effect);
    return best_shape(folds().size() == 1 ? training_groups() : all_groups(), model, effect);
  }
  std::vector<std::vector<double>> starts_on(const Groups& groups, const Model& model,
                                             const EffectDefinition& effect,
                                             const EffectList& companions) const override {
    if (!has_shapes(effect)) return Problem::starts_on(groups, model, effect, companions);
    return best_shape(groups, model, effect);
  }
  double looks(const Model& model, const EffectDefinition& effect) const override;

 private:
  // Whether no row would be another one at another time.
  bool stands_still() const;
  void add_covariates();
  double estimate_noise(const LandmarkPredictor& ideal, int channel) const;
  double residual(const effects::Detection& seen, size_t row, int channel) const {
    return channel == 0 ? data_.range_m[row] - seen.range_m
                        : std::remainder(data_.bearing_rad[row] - seen.bearing_rad, 2 * maths::kPi);
  }

  // What an evaluation predicted for a row; 0 where nothing was measured.
  effects::Detection predicted(const Evaluation& evaluation, size_t row) const {
    const auto [range, bearing] = data_.scalars[row];
    return {.range_m = range < 0 ? 0 : data_.range_m[row] - evaluation.residual[range],
            .bearing_rad = bearing < 0 ? 0 : data_.bearing_rad[row] - evaluation.residual[bearing],
            .t_s = data_.stamp_s[row]};
  }
  // By how much its frame's latency moves a row's range and bearing, a second.
  std::array<double, 2> slopes(const LandmarkPredictor& predictor, int row) const {
    const effects::Detection early = predictor.detect(row, -1e-3),
                             late = predictor.detect(row, 1e-3);
    return {(late.range_m - early.range_m) / 2e-3,
            std::remainder(late.bearing_rad - early.bearing_rad, 2 * maths::kPi) / 2e-3};
  }
  Evaluation each_by_itself(const Model& model, const LandmarkPredictor& predictor,
                            const Groups& groups, const Evaluation* warm) const;
  std::vector<Displacement> whiten_together(const Model& model, const LandmarkPredictor& predictor,
                                            const Groups& groups, Evaluation& evaluation,
                                            const std::vector<CommonSlopes>& common) const;
  std::vector<CommonSlopes> slopes_by_parameters(const Model& model, const Evaluation& here) const;
  bool sees_from_sides() const;
  bool has_shapes(const EffectDefinition& effect) const;
  std::vector<std::vector<double>> best_shape(const Groups& groups, const Model& model,
                                              const EffectDefinition& effect) const;
  std::vector<effects::Detection> predictions(const Model& model) const {
    const LandmarkPredictor predictor(data_, model);
    std::vector<effects::Detection> all;
    for (size_t row = 0; row < data_.stamp_s.size(); ++row) all.push_back(predictor.detect(row));
    return all;
  }
  void whiten_frames(const LandmarkPredictor& predictor, const Groups& groups,
                     Evaluation& evaluation) const;

  LandmarkData data_;
  std::vector<std::vector<int>> rows_of_errors_;
};

// From where the robot was, never from what it measured: an observation's noise must not stand on
// both sides of a regression.
bool LandmarksProblem::stands_still() const {
  constexpr double kStill = 1e-9;  // m/s and rad/s.
  for (size_t row = 0; row < data_.stamp_s.size(); ++row) {
    const Walk& walk = data_.walks[data_.walk_of_row[row]];
    for (const Spline* along : {&walk.x, &walk.y, &walk.theta}) {
      if (std::abs(along->rate(data_.stamp_s[row])) > kStill) return false;
    }
  }
  return true;
}

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
                                      const Evaluation* warm) const {
  const LandmarkPredictor predictor(data_, model);
  Evaluation evaluation = each_by_itself(model, predictor, groups, warm);
  whiten_together(model, predictor, groups, evaluation, {});
  return evaluation;
}

// Residuals with the errors that each has of its own.
Evaluation LandmarksProblem::each_by_itself(const Model& model, const LandmarkPredictor& predictor,
                                            const Groups& groups, const Evaluation* warm) const {
  Evaluation evaluation;
  evaluation.mean_key = mean_parameters(model);
  // Where only a spread changed, residuals stay.
  const bool reuse = warm != nullptr && warm->valid && warm->mean_key == evaluation.mean_key &&
                     predictor.spreads_last();
  evaluation.residual.assign(facts_.scalars(), 0);
  evaluation.sigma.assign(facts_.scalars(), 1);
  for (size_t row = 0; row < data_.stamp_s.size(); ++row) {
    if (!groups[facts_.group_of_row[row]]) continue;
    const effects::Detection seen =
        reuse ? predictor.spread_about(predicted(*warm, row)) : predictor.detect(row);
    const double variance[2] = {seen.range_variance, seen.bearing_variance};
    for (int c = 0; c < 2; ++c) {
      const int scalar = data_.scalars[row][c];
      if (scalar < 0) continue;
      const double noise = facts_.channels[data_.channels[c]].noise;
      evaluation.residual[scalar] = reuse ? warm->residual[scalar] : residual(seen, row, c);
      evaluation.sigma[scalar] = std::sqrt(noise * noise + variance[c]);
    }
  }
  whiten_diagonal(*this, groups, evaluation);
  return evaluation;
}

// Errors that residuals share, and unknowns that they have in `common`. Returns the displacements
// of landmarks whose places are uncertain.
std::vector<Displacement> LandmarksProblem::whiten_together(
    const Model& model, const LandmarkPredictor& predictor, const Groups& groups,
    Evaluation& evaluation, const std::vector<CommonSlopes>& common) const {
  const double jitter = predictor.timing().jitter_sigma_s;
  const effects::Noise noise = effects::noise_of(model);
  if (!noise.hangs_together() && noise.range_tail.none()) {
    if (jitter > 0) whiten_frames(predictor, groups, evaluation);
    return {};
  }
  JitterSlopes of_jitter;
  if (jitter > 0) {
    of_jitter = [&](int row) {
      const std::array<double, 2> slope = slopes(predictor, row);
      return std::array<double, 2>{jitter * slope[0], jitter * slope[1]};
    };
  }
  return whiten_landmarks(
      data_, facts_, rows_of_errors_, noise, of_jitter,
      [&](int row) { return predictor.slopes_by_place(static_cast<size_t>(row)); }, common, groups,
      evaluation);
}

// What a model's fitted parameters could change, each by far more than the data leave open.
std::vector<CommonSlopes> LandmarksProblem::slopes_by_parameters(const Model& model,
                                                                 const Evaluation& here) const {
  constexpr double kFarMore = 1e3;  // Standard errors.
  std::vector<CommonSlopes> all;
  for (const effects::ModelEffect& effect : model.effects()) {
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      const effects::Parameter& parameter = effect.definition->parameters[i];
      if (!effect.parameters[i].refitted() || parameter.integer) continue;
      const double value = effect.parameters[i].value;
      double step = 1e-3 * std::max(parameter.scale, std::abs(value));
      if (value + step > parameter.max) step = -step;
      Model moved = model;
      moved.set_value(effect.definition->name, i, value + step);
      const Evaluation there =
          each_by_itself(moved, LandmarkPredictor(data_, moved), all_groups(), nullptr);
      CommonSlopes slopes(here.residual.size(), 0);
      double square = 0;
      for (size_t k = 0; k < slopes.size(); ++k) {
        if (!here.used[k]) continue;
        slopes[k] = there.residual[k] - here.residual[k];
        square += slopes[k] * slopes[k] / (here.sigma[k] * here.sigma[k]);
      }
      if (!(square > 0)) continue;
      for (double& slope : slopes) slope *= kFarMore / std::sqrt(square);
      all.push_back(std::move(slopes));
    }
  }
  return all;
}

// Landmarks with clear errors of their own.
std::vector<Finding> LandmarksProblem::findings(const Model& model) const {
  const effects::Noise noise = effects::noise_of(model);
  if (!(noise.place_variance > 0) && !(noise.delay_variance > 0)) return {};
  const Groups all = all_groups();
  const LandmarkPredictor predictor(data_, model);
  Evaluation evaluation = each_by_itself(model, predictor, all, nullptr);
  const auto displacements =
      whiten_together(model, predictor, all, evaluation, slopes_by_parameters(model, evaluation));
  return found_of(data_.landmarks, noise, displacements);
}

bool LandmarksProblem::has_shapes(const EffectDefinition& effect) const {
  return effects::start_rule(effect, facts_.set.kind).search == effects::StartSearch::shapes;
}

std::vector<std::vector<double>> LandmarksProblem::best_shape(
    const Groups& groups, const Model& model, const EffectDefinition& effect) const {
  return landmark_shape(data_, predictions(model), evaluate(model, groups, nullptr), effect,
                        effects::start_rule(effect, facts_.set.kind).values);
}

double LandmarksProblem::looks(const Model& model, const EffectDefinition& effect) const {
  if (!has_shapes(effect)) return Problem::looks(model, effect);
  return shapes_that_act(predictions(model), effect,
                         effects::start_rule(effect, facts_.set.kind).values);
}

// Whether some landmark is seen from sides that lie clearly apart: from one side alone, a range
// that is too long is a landmark that lies too near, and a bearing likewise.
bool LandmarksProblem::sees_from_sides() const {
  constexpr double kNarrow = 0.97;  // Length of the mean direction: within 25 degrees to each side.
  const size_t n = data_.landmarks.size();
  std::vector<double> east(n, 0), north(n, 0), count(n, 0);
  for (size_t row = 0; row < data_.stamp_s.size(); ++row) {
    const PlanePose pose = data_.walks[data_.walk_of_row[row]].at(data_.stamp_s[row]);
    const double dx = data_.landmark_x[row] - pose.x_m, dy = data_.landmark_y[row] - pose.y_m;
    const double way = std::max(std::hypot(dx, dy), 1e-9);
    const int k = data_.landmark_of_row[row];
    east[k] += dx / way;
    north[k] += dy / way;
    ++count[k];
  }
  for (size_t k = 0; k < n; ++k) {
    if (std::hypot(east[k], north[k]) < kNarrow * count[k]) return true;
  }
  return false;
}

// Jitter moves all landmarks of a frame together.
void LandmarksProblem::whiten_frames(const LandmarkPredictor& predictor, const Groups& groups,
                                     Evaluation& evaluation) const {
  const double jitter = predictor.timing().jitter_sigma_s;
  for (const std::vector<int>& rows : data_.rows_of_frame) {
    if (!groups[facts_.group_of_row[rows.front()]]) continue;
    std::vector<size_t> scalars;
    std::vector<double> effect;
    for (const int row : rows) {
      const std::array<double, 2> slope = slopes(predictor, row);
      for (int c = 0; c < 2; ++c) {
        const int scalar = data_.scalars[row][c];
        if (scalar < 0 || !evaluation.used[scalar]) continue;
        scalars.push_back(scalar);
        effect.push_back(jitter * slope[c]);
      }
    }
    if (scalars.empty()) continue;
    const Eigen::MatrixXd causes =
        Eigen::Map<const Eigen::VectorXd>(effect.data(), static_cast<Eigen::Index>(effect.size()));
    whiten_low_rank(scalars, causes, facts_.group_of_row[rows.front()], evaluation);
  }
}

// What a straight line between the two neighbours on a landmark's track leaves.
double LandmarksProblem::estimate_noise(const LandmarkPredictor& ideal, int channel) const {
  std::vector<int> order;
  for (size_t row = 0; row < data_.stamp_s.size(); ++row) {
    if (data_.scalars[row][channel] >= 0) order.push_back(static_cast<int>(row));
  }
  const size_t n = order.size();
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
  std::vector<double> r(data_.stamp_s.size(), 0);
  for (const int row : order) r[row] = residual(ideal.detect(row), row, channel);
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
          .rows_follow_time = true,
          .open = [](const MeasurementSet& set, const Instruments&) { return open_landmarks(set); },
          .measure = [](const Model& truth, const MeasurementSet& protocol,
                        const MeasureOptions& options,
                        const Instruments&) { measure_landmarks(truth, protocol, options); }};
}

}  // namespace seam::measurement
