#include "measurement/kinds/joints/joints.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "effects/questions.h"
#include "effects/stages/noise.h"
#include "effects/stages/servo.h"
#include "measurement/kinds/joints/stiffness.h"
#include "measurement/kinds/joints/torque/effort.h"
#include "measurement/kinds/series_facts.h"
#include "measurement/noise/hidden_errors.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/parallel_for.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"

namespace seam::measurement {

Around parabola_around(const std::vector<double>& t, const std::vector<double>& x, size_t k) {
  constexpr size_t kReach = 4;
  const size_t from = k >= kReach ? k - kReach : 0, to = std::min(t.size(), k + kReach + 1);
  const auto count = static_cast<Eigen::Index>(to - from - 1);
  if (count < 3) return {};
  Eigen::MatrixXd powers(count, 3);
  Eigen::VectorXd values(count);
  Eigen::Index at = 0;
  for (size_t i = from; i < to; ++i) {
    if (i == k) continue;
    const double d = t[i] - t[k];
    powers.row(at) << 1, d, d * d;
    values[at++] = x[i];
  }
  Eigen::Index rank = 0;
  const Eigen::VectorXd c = solve_any_rank(powers, values, &rank);
  if (rank < 3) return {};
  return {c[0], c[1], 2 * c[2]};
}

JointsProblem::JointsProblem(const MeasurementSet& set) {
  const CsvTable table = set.table("joints");
  if (table.rows() == 0)
    throw InputError(fmt::format("{}: no rows, expected observations", table.file()));
  set_ = read_joint_logs(table, set.group, true);
  pause_ = pause_too_long(table, set_);
  predictions_.emplace(set_.logs.size());
  late_steps_.emplace(set_.logs.size());
  describe(set, table);
  facts_.notes = notes_of_joint_logs(table);
  add_efforts(table, set);
  const double noise_rad = facts_.channels[0].noise;
  for (std::string note :
       {note_of_stiffness(table, set_, noise_rad), note_of_unlike_joints(table, set_, noise_rad)}) {
    if (!note.empty()) facts_.notes.push_back(std::move(note));
  }
  add_covariates();
  look_for_steps();
  facts_.set.lacks = lacks();
  for (effects::Lack& lack : lacks_of_torques(nullptr)) facts_.set.lacks.push_back(std::move(lack));
}

void JointsProblem::describe(const MeasurementSet& set, const CsvTable& table) {
  facts_.set.kind = effects::kJoints;
  describe_rows(set, table, 1, facts_);
  std::vector<std::vector<double>> times, values;
  for (size_t i = 0; i < set_.logs.size(); ++i) {
    const JointLog& log = set_.logs[i];
    add_series(set, table, i, log.rows, log.time_s, facts_);
    times.push_back(log.time_s);
    values.push_back(log.measured_rad);
  }
  Channel channel{.name = "measured_rad"};
  const auto given = set.noise.find("measured_rad");
  channel.estimated = given == set.noise.end();
  channel.noise = channel.estimated ? noise_from_neighbours(times, values) : given->second;
  facts_.channels = {channel};
}

void JointsProblem::add_covariates() {
  const size_t rows = facts_.rows();
  std::vector<std::string> names;  // Of joints, in order of appearance.
  for (const JointLog& log : set_.logs) {
    if (std::find(names.begin(), names.end(), log.joint) == names.end()) names.push_back(log.joint);
  }
  const auto blank = [&] { return std::vector<double>(rows, NAN); };
  auto time = blank(), command = blank(), command_rate = blank();
  std::map<std::string, std::vector<double>> angle, rate, sign, acceleration;
  for (const std::string& name : names) {
    angle[name] = rate[name] = sign[name] = acceleration[name] = blank();
  }
  for (const JointLog& log : set_.logs) {
    for (size_t k = 0; k < log.rows.size(); ++k) {
      const size_t row = log.rows[k];
      Around around = parabola_around(log.time_s, log.measured_rad, k);
      // A run of one or two rows: as if at rest at its command.
      if (!std::isfinite(around.value)) around = {log.command_rad[k], 0, 0};
      time[row] = log.time_s[k];
      command[row] = k == 0 ? log.command_rad[0] : log.command_rad[k - 1];
      command_rate[row] = k == 0 ? 0
                                 : (log.command_rad[k] - log.command_rad[k - 1]) /
                                       (log.time_s[k] - log.time_s[k - 1]);
      angle[log.joint][row] = around.value;
      rate[log.joint][row] = around.slope;
      acceleration[log.joint][row] = around.curvature;
      // Slower than its own uncertainty (noise over the reach of some rows) counts as at rest.
      const size_t near = std::min<size_t>(k + 1, log.rows.size() - 1), far = k > 0 ? k - 1 : 0;
      const double dt =
          near > far ? (log.time_s[near] - log.time_s[far]) / static_cast<double>(near - far) : 1;
      const double slowest = 3 * facts_.channels[0].noise / (dt * 7.7);
      sign[log.joint][row] = std::abs(around.slope) < slowest ? 0 : std::copysign(1, around.slope);
    }
  }
  const auto add = [&](std::string name, Covariate::Type type, std::vector<double> values,
                       bool products, bool measured = false) {
    facts_.covariates.push_back({std::move(name), type, std::move(values), products, measured});
  };
  add("time", Covariate::Type::smooth, std::move(time), true);
  for (const std::string& name : names) {
    add(name, Covariate::Type::smooth, angle[name], true, /*measured=*/true);
    add(name + "_rate", Covariate::Type::smooth, rate[name], true, /*measured=*/true);
    add("sign(" + name + "_rate)", Covariate::Type::sign, sign[name], true, /*measured=*/true);
    add(name + "_acceleration", Covariate::Type::smooth, acceleration[name], false,
        /*measured=*/true);
  }
  add("command_rad", Covariate::Type::smooth, std::move(command), false);
  add("command_rate", Covariate::Type::smooth, std::move(command_rate), false);
  for (size_t c = 0; c < set_.column_names.size(); ++c) {
    auto values = blank();
    for (const JointLog& log : set_.logs) {
      for (size_t k = 0; k < log.rows.size(); ++k) values[log.rows[k]] = log.columns[c][k];
    }
    add(set_.column_names[c], Covariate::Type::smooth, std::move(values), true);
  }
}

std::vector<size_t> JointsProblem::used_logs(const Groups& groups) const {
  std::vector<size_t> used;
  for (size_t i = 0; i < set_.logs.size(); ++i) {
    if (groups[facts_.group_of_row[set_.logs[i].rows[0]]]) used.push_back(i);
  }
  return used;
}

// Residuals of the logs, each from the start that fits it best.
void JointsProblem::evaluate_logs(const Model& model, const Groups& groups, double sigma_rad,
                                  const Evaluation* warm, Evaluation& evaluation) const {
  // A motor's fit takes the starts of its last look as they are: it looks again between rounds.
  const bool motor = effects::has_base(model, effects::Base::motor);
  const std::vector<double>* starts =
      motor && warm != nullptr && warm->reusable ? &warm->nuisance_values : nullptr;
  // Rows that are left out do not tell where a log starts.
  std::vector<double> key = evaluation.mean_key;
  key.push_back(static_cast<double>(times_marked()));
  const std::vector<size_t> used = used_logs(groups);
  evaluation.nuisance_values.resize(kStartValues * used.size());
  std::vector<double> drive_of_row(has_efforts() ? facts_.rows() : 0, 0);
  // Rules without torque take less than a thread does.
  parallel_for(
      used.size(),
      [&](size_t at) {
        const JointLog& log = set_.logs[used[at]];
        const size_t place = kStartValues * at;
        const auto show = [&](const LogStart& start, const std::vector<double>& angles,
                              const std::vector<double>& drives) {
          for (size_t k = 0; k < angles.size(); ++k)
            evaluation.residual[log.rows[k]] = log.measured_rad[k] - angles[k];
          for (size_t k = 0; k < drives.size(); ++k) drive_of_row[log.rows[k]] = drives[k];
          evaluation.nuisance_values[place] = start.offset_rad;
          evaluation.nuisance_values[place + 1] = start.offset_radps;
          evaluation.nuisance_values[place + 2] = start.log_det;
        };
        if (starts != nullptr) {
          const LogStart start{starts->at(place), starts->at(place + 1), starts->at(place + 2)};
          std::vector<double> drives;
          const std::vector<double> angles = predict_from(model, log, start, &drives);
          return show(start, angles, drives);
        }
        const auto known =
            predictions_->of(used[at], key, [&] { return fit_start(model, log, sigma_rad); });
        show(known->start, known->angles, known->drives);
      },
      /*worth_threads=*/motor);
  for (const size_t i : used) evaluation.nuisances += unknowns_of_start(model, set_.logs[i]);
  if (motor) evaluation.reusable = starts ? warm->reusable : std::make_shared<const LateSteps>();
  if (has_efforts()) predict_efforts(model, groups, drive_of_row, evaluation);
}

Evaluation JointsProblem::evaluate(const Model& model, const Groups& groups,
                                   const Evaluation* warm) const {
  Evaluation evaluation;
  const size_t n = facts_.scalars();
  evaluation.residual.assign(n, 0);
  const auto [sigma, rounded] = reading_of(model);
  set_sigma(sigma, evaluation);
  evaluation.mean_key = mean_parameters(model);
  evaluation.mean_key.push_back(sigma);
  // Where only a spread changed, residuals and starts stay.
  if (warm != nullptr && warm->valid && warm->mean_key == evaluation.mean_key) {
    evaluation.residual = warm->residual;
    evaluation.nuisance_values = warm->nuisance_values, evaluation.nuisances = warm->nuisances;
    evaluation.reusable = warm->reusable;
  } else {
    evaluate_logs(model, groups, sigma, warm, evaluation);
  }
  for (const double r : evaluation.residual) evaluation.valid &= std::isfinite(r);
  whiten_diagonal(*this, groups, evaluation);
  if (rounded) {
    const RoundedAngle& likeliest = likeliest_rounding(evaluation);
    set_sigma(likeliest.sigma_rad(), evaluation);
    whiten_diagonal(*this, groups, evaluation);
    whiten_rounded(likeliest, evaluation);
  } else {
    bound_chances(evaluation);
  }
  whiten_wander(model, groups, evaluation);
  auto told = evaluation.nuisance_values.begin();
  for (const JointLog& log : set_.logs) {
    const size_t group = facts_.group_of_row[log.rows[0]];
    if (!groups[group]) continue;
    evaluation.log_det[group] += told[kStartValues - 1];
    told += kStartValues;
  }
  return evaluation;
}

void JointsProblem::whiten_wander(const Model& model, const Groups& groups,
                                  Evaluation& evaluation) const {
  const effects::Noise noise = effects::noise_of(model);
  if (noise.command_sigma_s > 0) return whiten_late_commands(model, noise, groups, evaluation);
  if (noise.joint.empty()) return;
  HiddenErrors errors;
  for (const JointLog& log : set_.logs) {
    if (!groups[facts_.group_of_row[log.rows[0]]]) continue;
    std::vector<HiddenErrors::Share> shares;
    for (const effects::Wander& wander : noise.joint)
      shares.push_back({.hidden = errors.add(wander.sigma * wander.sigma, wander.tau_s)});
    for (size_t k = 0; k < log.rows.size(); ++k) errors.observe(log.rows[k], log.time_s[k], shares);
  }
  errors.whiten(facts_, evaluation);
}

namespace {

using Shows = std::function<bool(const JointLog&)>;

// How much of its duty a controller is asked for at most, in a unit of its own.
double most_asked(const JointLog& log) {
  double most = 0;
  for (size_t k = 0; k < log.kp.size(); ++k) {
    const double asked = log.kp[k] * std::abs(log.command_rad[k] - log.measured_rad[k]);
    if (log.enabled[k] != 0) most = std::max(most, asked);
  }
  return most;
}

// A fall, a drive, and, where gains differ, a duty that is nearly the largest, since only that may
// saturate.
std::vector<Shows> all_shown(const std::vector<JointLog>& logs) {
  constexpr double kNearly = 0.9;
  std::vector<Shows> all;
  for (const bool torque : {false, true}) {
    all.push_back([torque](const JointLog& log) {
      return std::any_of(log.enabled.begin(), log.enabled.end(),
                         [&](char enabled) { return (enabled != 0) == torque; });
    });
  }
  double most = 0, softest = INFINITY, stiffest = 0;
  for (const JointLog& log : logs) {
    const auto [least, largest] = std::minmax_element(log.kp.begin(), log.kp.end());
    most = std::max(most, most_asked(log));
    softest = std::min(softest, *least), stiffest = std::max(stiffest, *largest);
  }
  if (softest < stiffest)
    all.push_back([=](const JointLog& log) { return most_asked(log) >= kNearly * most; });
  return all;
}

}  // namespace

std::vector<Groups> JointsProblem::regimes() const {
  std::vector<Groups> regimes = Problem::regimes();
  for (const Shows& shows : all_shown(set_.logs)) {
    Groups& groups = regimes.emplace_back(facts_.groups.size(), 0);
    for (const JointLog& log : set_.logs)
      groups[static_cast<size_t>(facts_.group_of_row[log.rows[0]])] |= shows(log);
  }
  return regimes;
}

bool JointsProblem::is_smooth(const Model& model) const {
  return effects::has_base(model, effects::Base::motor);
}

void JointsProblem::check_model(const Model& model) const {
  expect_no_pause(pause_, model);
  check_columns(model, {effects::Stage::joint});
}

std::string JointsProblem::not_testable(const Model& model, const EffectDefinition& effect,
                                        size_t parameter) const {
  if (!pause_.empty() && moves_by_itself(effect)) return pause_;
  return Problem::not_testable(model, effect, parameter);
}

std::vector<effects::Lack> JointsProblem::lacks() const {
  using effects::JointRole;
  using effects::Need;
  const auto has = [&](JointRole role) {
    return std::any_of(set_.logs.begin(), set_.logs.end(),
                       [&](const JointLog& log) { return log.role == role; });
  };
  std::vector<effects::Lack> lacks = {
      {Need::tilt_reversals, "width_rad is the play of a logged joint"},
      {Need::roll_reversals, "width_rad is the play of a logged joint"}};
  if (largest_step_rad_ == 0)
    lacks.push_back({Need::encoder_steps, "the logged angles are multiples of no step"});
  if (!has(JointRole::tilt)) lacks.push_back({Need::tilt_joint, "the set has no tilt joint"});
  if (!has(JointRole::roll)) lacks.push_back({Need::roll_joint, "the set has no roll joint"});
  if (!has(JointRole::pan)) {
    lacks.push_back({Need::pan_turn, "the set has no pan joint"});
    lacks.push_back({Need::pan_joint, "the set has no joint besides tilt and roll"});
  }
  return lacks;
}

Kind joints_kind() {
  return {.bit = effects::kJoints,
          .observations = {.file = "joints",
                           .keys = {"run", "time_s", "joint"},
                           .measured = {"measured_rad"}},
          .rows_follow_time = true,
          .open = [](const MeasurementSet& set, const Instruments&) -> std::unique_ptr<Problem> {
            return std::make_unique<JointsProblem>(set);
          },
          .measure = [](const Model& truth, const MeasurementSet& protocol,
                        const MeasureOptions& options,
                        const Instruments&) { measure_joints(truth, protocol, options); }};
}

// Right after a change of command a missing effect leaves residuals that stand out of their
// neighbours just as gross errors do; what tells them apart is that the former come with nearly
// every change of that size.
std::vector<char> JointsProblem::find_outliers(const Model& model) const {
  std::vector<char> outlier = Problem::find_outliers(model);
  if (std::find(outlier.begin(), outlier.end(), 1) == outlier.end()) return outlier;
  constexpr size_t kMemory = 4;      // Rows for which a change of command counts as recent.
  constexpr double kOftenIs = 0.05;  // A larger share of like rows is no accident.
  const Evaluation evaluation = evaluate(model, all_groups(), nullptr);
  // By row: the recent range of the command.
  std::vector<double> range(facts_.rows(), 0);
  for (const JointLog& log : set_.logs) {
    for (size_t k = 0; k < log.rows.size(); ++k) {
      const size_t from = k > kMemory ? k - kMemory : 0;
      const auto [low, high] =
          std::minmax_element(log.command_rad.begin() + static_cast<std::ptrdiff_t>(from),
                              log.command_rad.begin() + static_cast<std::ptrdiff_t>(k) + 1);
      // The joint's own way from its start counts as a change of command.
      const double start = k <= kMemory ? std::abs(log.command_rad[0] - log.measured_rad[0]) : 0;
      range[log.rows[k]] = std::max(*high - *low, start);
    }
  }
  const std::vector<double> distance = out_of_neighbours(evaluation);
  std::vector<char> kept = outlier;
  for (size_t i = 0; i < outlier.size(); ++i) {
    const auto changed = [&](size_t scalar) { return range[facts_.row_of[scalar]]; };
    const bool torque = facts_.channel_of[i] != 0;
    // No change of command moves an angle farther than it goes itself; a torque has no such bound.
    const double least = torque ? 0.5 * changed(i) : distance[i];
    if (!outlier[i] || !(changed(i) > 0) || (!torque && distance[i] > 1.2 * changed(i))) continue;
    size_t like = 0, deviating = 0;
    for (size_t other = 0; other < outlier.size(); ++other) {
      if (facts_.channel_of[other] != facts_.channel_of[i] || changed(other) < least) continue;
      ++like;
      deviating += outlier[other] && distance[other] > 0.3 * distance[i];
    }
    if (static_cast<double>(deviating) > kOftenIs * static_cast<double>(like)) kept[i] = 0;
  }
  return kept;
}

}  // namespace seam::measurement
