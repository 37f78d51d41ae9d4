// Reading servo logs, and predicting them.
#include <Eigen/Core>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <optional>
#include <unordered_map>

#include "effects/stages/servo.h"
#include "measurement/kinds/joints/joints.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/robust.h"
#include "measurement/sets/temperatures.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

// Angles beyond this are a wrong unit or a broken log.
constexpr double kLargestAngle_rad = 1e4;

void check_angles(const CsvTable& table, const std::vector<double>& values, const char* column) {
  for (size_t row = 0; row < values.size(); ++row) {
    if (std::abs(values[row]) > kLargestAngle_rad) {
      table.fail(row, column, table.cell(row, column), "an angle in radians");
    }
  }
}

// The gain's factor in each row.
std::vector<double> read_kp(const CsvTable& table) {
  if (!table.has("kp")) return std::vector<double>(table.rows(), 1);
  const auto kp = table.numbers("kp");
  for (size_t row = 0; row < kp.size(); ++row) {
    if (kp[row] < 0) table.fail(row, "kp", table.cell(row, "kp"), "a gain, 0 or more");
  }
  return kp;
}

// The supply in each row, in units of its median.
std::vector<double> read_voltage(const CsvTable& table) {
  constexpr double kLargest_V = 1000;  // No servo's.
  if (!table.has("voltage_v")) return std::vector<double>(table.rows(), 1);
  auto voltage = table.numbers("voltage_v");
  for (size_t row = 0; row < voltage.size(); ++row) {
    if (!(voltage[row] > 0 && voltage[row] < kLargest_V)) {
      table.fail(row, "voltage_v", table.cell(row, "voltage_v"),
                 "a supply in volts, above 0 (one in millivolts is to be divided by 1000)");
    }
  }
  const double median = voltage.empty() ? 1 : median_of(voltage);
  for (double& value : voltage) value /= median;
  return voltage;
}

// By how much the motor is warmer in each row than in the median one.
std::vector<double> read_warmth(const CsvTable& table) {
  if (!table.has(kTemperature)) return std::vector<double>(table.rows(), 0);
  auto warmth = table.numbers(kTemperature);
  check_temperatures(table, warmth);
  const double median = warmth.empty() ? 0 : median_of(warmth);
  for (double& value : warmth) value -= median;
  return warmth;
}

std::vector<char> read_enabled(const CsvTable& table) {
  if (!table.has("torque_enable")) return std::vector<char>(table.rows(), 1);
  const auto values = table.numbers("torque_enable");
  std::vector<char> enabled;
  for (size_t row = 0; row < values.size(); ++row) {
    if (values[row] != 0 && values[row] != 1)
      table.fail(row, "torque_enable", table.cell(row, "torque_enable"), "0 (off) or 1 (on)");
    enabled.push_back(values[row] != 0);
  }
  return enabled;
}

// A cubic through a log's first rows.
struct FirstRows {
  double radps = 0;               // At the first of them.
  double variance = 0;            // Of what they miss it by.
  double radps2_of_variance = 0;  // The rate's own variance, in units of that.
};

std::optional<FirstRows> first_rows(const JointLog& log) {
  constexpr size_t kRows = 8;
  if (log.time_s.size() < kRows) return std::nullopt;
  Eigen::MatrixXd powers(kRows, 4);
  Eigen::VectorXd angles(kRows);
  const double span = log.time_s[kRows - 1];
  for (size_t k = 0; k < kRows; ++k) {
    const double t = log.time_s[k] / span;
    powers.row(static_cast<Eigen::Index>(k)) << 1, t, t * t, t * t * t;
    angles[static_cast<Eigen::Index>(k)] = log.measured_rad[k];
  }
  const Eigen::MatrixXd inverse = inverse_of(powers.transpose() * powers);
  const Eigen::VectorXd c = inverse * powers.transpose() * angles;
  return FirstRows{.radps = c[1] / span,
                   .variance = (powers * c - angles).squaredNorm() / (kRows - 4.0),
                   .radps2_of_variance = inverse(1, 1) / (span * span)};
}

// The rate at the log's first row where its first rows cannot be those of a joint at rest that
// something begins to accelerate; else 0. Each angle may be off by half of the encoder's step.
double rate_at_start(const JointLog& log, const FirstRows& seen, double step_rad) {
  constexpr double kClearly = 8;  // Standard errors.
  const double rate = seen.radps;
  const double variance = std::max(seen.variance, step_rad * step_rad / 12);
  if (std::abs(rate) < kClearly * std::sqrt(variance * seen.radps2_of_variance)) return 0;
  // A joint in motion moves in the first step, too, and half as far as in the first two. Noise
  // alone looks so in one of them at times, hardly in both.
  const double first = log.measured_rad[1] - log.measured_rad[0];
  const double both = log.measured_rad[2] - log.measured_rad[0];
  const bool moves = first * rate > 0.5 * rate * rate * log.time_s[1] &&
                     both * rate > 0.5 * rate * rate * log.time_s[2] &&
                     std::abs(first) - step_rad > 0.35 * (std::abs(both) - step_rad);
  return moves ? rate : 0;
}

// Eight rows may lie on a curve by luck, those of half of the logs hardly: no log's scatter counts
// as less than that of the middle one.
void look_at_starts(JointLogs& set) {
  const double step_rad = step_of_angles(set);
  std::vector<std::optional<FirstRows>> seen;
  std::vector<double> variances;
  for (const JointLog& log : set.logs) {
    seen.push_back(first_rows(log));
    if (seen.back()) variances.push_back(seen.back()->variance);
  }
  const double middle = variances.empty() ? 0 : median_of(variances);
  for (size_t i = 0; i < seen.size(); ++i) {
    if (!seen[i]) continue;
    seen[i]->variance = std::max(seen[i]->variance, middle);
    set.logs[i].start_radps = rate_at_start(set.logs[i], *seen[i], step_rad);
  }
}

// The joint's angle as its encoder logs it: catalogue encoders, in reverse order of composition.
double logged_angle(const Model& model, effects::JointRole role, double q_rad) {
  const auto& all = model.effects();
  for (auto effect = all.rbegin(); effect != all.rend(); ++effect) {
    if (effect->definition->logged)
      q_rad = effect->definition->logged(effect->values(), role, q_rad);
  }
  return q_rad;
}

}  // namespace

std::string pause_too_long(const CsvTable& table, const JointLogs& set) {
  constexpr double kLongestPause_s = 60;
  constexpr double kMean_s = 1;  // No motor is seen in rows farther apart.
  double longest_s = 0, all_s = 0, count = 0;
  size_t at = 0, pauses = 0;
  for (const JointLog& log : set.logs) {
    for (size_t k = 1; k < log.rows.size(); ++k) {
      const double step_s = log.time_s[k] - log.time_s[k - 1];
      all_s += step_s, ++count;
      if (step_s > kLongestPause_s && pauses++ == 0) at = log.rows[k];
      longest_s = std::max(longest_s, step_s);
    }
  }
  if (pauses > 0)
    return fmt::format(
        "{}:{}: rows of one run are up to {:.4g} s apart ({} times more than {:g} s, here first), "
        "expected at most {:g} s: begin a new run after each pause",
        table.file(), table.line(at), longest_s, pauses, kLongestPause_s, kLongestPause_s);
  if (all_s > kMean_s * count)
    return fmt::format(
        "{}: rows of a run are {:.4g} s apart in the mean, expected at most {:g} s (are the times "
        "seconds?)",
        table.file(), all_s / count, kMean_s);
  return "";
}

bool moves_by_itself(const EffectDefinition& effect) {
  if (!effect.servo) return false;
  std::vector<double> values;
  for (const effects::Parameter& parameter : effect.parameters) values.push_back(parameter.scale);
  effects::ServoModel servo;
  effect.servo(values, servo);
  return servo.torque.present || servo.elastic.present();
}

void expect_no_pause(const std::string& pause, const Model& model) {
  if (pause.empty()) return;
  for (const effects::ModelEffect& effect : model.effects()) {
    if (moves_by_itself(*effect.definition))
      throw InputError(fmt::format("{} (the model's effect '{}' moves the joint all that time)",
                                   pause, effect.definition->name));
  }
}

std::vector<std::string> notes_of_joint_logs(const CsvTable& table) {
  std::vector<std::string> notes;
  if (table.has("torque_enable")) {
    const std::vector<char> enabled = read_enabled(table);
    const bool same =
        std::adjacent_find(enabled.begin(), enabled.end(), std::not_equal_to<>()) == enabled.end();
    if (same && !enabled.empty()) {
      notes.push_back(fmt::format(
          "{}:{}: column torque_enable is {} in this row and in all others, expected a column that "
          "changes: {}",
          table.file(), table.line(0), table.cell(0, "torque_enable"),
          enabled[0] ? "no free swing tells gravity and friction from the drive"
                     : "no command ever acts"));
    }
  }
  if (table.has("kp")) return notes;
  for (const std::string& name : table.extra_numeric_columns({})) {
    std::string low = name;
    std::transform(low.begin(), low.end(), low.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    if (low.find("kp") == std::string::npos && low.find("gain") == std::string::npos) continue;
    notes.push_back(
        fmt::format("{}:1: column {} is not read as a gain, expected a column kp where the "
                    "controller's gain differs between rows",
                    table.file(), name));
  }
  return notes;
}

JointLogs read_joint_logs(const CsvTable& table, const std::string& group_column, bool measured) {
  const auto times = table.times_ns("time_s");
  const auto commands = table.numbers("command_rad");
  const auto joints = table.texts("joint");
  const auto runs = table.texts(table.has("run") ? "run" : group_column);
  check_angles(table, commands, "command_rad");
  std::vector<double> angles(table.rows(), 0);
  if (measured) {
    angles = table.numbers("measured_rad");
    check_angles(table, angles, "measured_rad");
  }
  const auto enabled = read_enabled(table);
  const auto kp = read_kp(table), voltage = read_voltage(table), warmth = read_warmth(table);
  JointLogs set;
  set.column_names = table.extra_numeric_columns(
      {"run", "time_s", "joint", "command_rad", "measured_rad", "effort_nm", group_column});
  std::vector<std::vector<double>> columns;
  for (const std::string& name : set.column_names) columns.push_back(table.numbers(name));
  std::unordered_map<std::string, size_t> place;  // Only looked up.
  std::vector<int64_t> first_ns, last_ns;
  for (size_t row = 0; row < table.rows(); ++row) {
    if (joints[row].empty()) table.fail(row, "joint", "", "the joint's name");
    const auto [found, is_new] = place.try_emplace(runs[row] + "\n" + joints[row], set.logs.size());
    if (is_new) {
      JointLog log{.joint = joints[row]};
      const auto role = effects::joint_role(joints[row]);
      log.role = role == effects::JointRole::other ? effects::JointRole::pan : role;
      log.columns.resize(columns.size());
      set.logs.push_back(std::move(log));
      first_ns.push_back(times[row]);
      last_ns.push_back(times[row] - 1);
    }
    const size_t i = found->second;
    JointLog& log = set.logs[i];
    if (times[row] <= last_ns[i]) {
      table.fail(row, "time_s", table.cell(row, "time_s"),
                 "a later time than the row before it in its run");
    }
    last_ns[i] = times[row];
    log.rows.push_back(row);
    log.time_s.push_back(static_cast<double>(times[row] - first_ns[i]) * 1e-9);
    log.command_rad.push_back(commands[row]);
    log.measured_rad.push_back(angles[row]);
    log.enabled.push_back(enabled[row]);
    log.kp.push_back(kp[row]);
    log.voltage.push_back(voltage[row]);
    log.warmer_k.push_back(warmth[row]);
    for (size_t c = 0; c < columns.size(); ++c) log.columns[c].push_back(columns[c][row]);
  }
  if (measured) look_at_starts(set);
  return set;
}

std::vector<double> predict_joint_log(
    const Model& model, const JointLogs& set, const JointLog& log, double start_rad,
    double start_radps, const std::function<void(size_t, const effects::Servo&)>& at_row,
    std::vector<double>* drives) {
  const effects::ServoModel servo = effects::servo_of(model);
  effects::JointSample sample{.role = log.role, .columns = {set.column_names, log.columns, 0}};
  // What the log shows when the joint (before formulas) is at q.
  const auto shown = [&](double q, double rate, double command, size_t k) {
    if (!servo.formulas.empty()) {
      sample.columns.row = k;
      sample.q_rad = q, sample.rate_rad_per_s = rate, sample.command_rad = command,
      sample.t_s = log.time_s[k];
      for (const auto& formula : servo.formulas)
        sample.q_rad = formula.definition->joint_map(formula.values(), sample);
      q = sample.q_rad;
    }
    return logged_angle(model, log.role, q);
  };
  // At rest where the log shows start_rad: a fixed point, since formulas and encoders change angles
  // little.
  double start = start_rad;
  for (int step = 0; step < 40; ++step) {
    const double miss = start_rad - shown(start, 0, start_rad, 0);
    if (!(std::abs(miss) > 1e-14)) break;
    start += miss;
  }
  if (!std::isfinite(start)) start = start_rad;
  effects::Servo joint(servo, log.time_s.front(), start);
  if (start_radps != 0 && servo.torque.present)
    joint.begin_moving(start_radps, log.command_rad[0], log.enabled[0] != 0, log.kp[0]);
  std::vector<double> angles(log.time_s.size());
  if (drives != nullptr) drives->resize(angles.size());
  double before = start;
  for (size_t k = 0; k < angles.size(); ++k) {
    joint.advance_to(log.time_s[k]);
    if (drives != nullptr) (*drives)[k] = joint.drive_rad_per_s2();
    const double q = joint.joint_rad();
    const double rate = k == 0 ? 0 : (q - before) / (log.time_s[k] - log.time_s[k - 1]);
    angles[k] = shown(q, rate, joint.acting_command_rad(), k);
    before = q;
    const double late_s = log.late_s.empty() ? 0 : log.late_s[k];
    joint.command(log.time_s[k] + late_s, log.command_rad[k], log.enabled[k] != 0, log.kp[k]);
    joint.set_voltage(log.voltage[k]);
    joint.set_warmer(log.warmer_k[k]);
    if (at_row) at_row(k, joint);
  }
  return angles;
}

double noise_from_neighbours(const std::vector<std::vector<double>>& time_s,
                             const std::vector<std::vector<double>>& values) {
  constexpr double kRepeats = 1e-12;
  std::vector<double> misses;
  double smallest_step = INFINITY;
  for (size_t s = 0; s < values.size(); ++s) {
    const auto& t = time_s[s];
    const auto& x = values[s];
    for (size_t k = 2; k + 2 < x.size(); ++k) {
      // Lagrange's cubic through the two neighbours on either side.
      double miss = x[k], weight2 = 1;
      for (const size_t a : {k - 2, k - 1, k + 1, k + 2}) {
        double weight = 1;
        for (const size_t b : {k - 2, k - 1, k + 1, k + 2}) {
          if (b != a) weight *= (t[k] - t[b]) / (t[a] - t[b]);
        }
        miss -= weight * x[a];
        weight2 += weight * weight;
      }
      // A joint at rest repeats what its encoder shows, which says nothing.
      if (std::abs(miss) > kRepeats) misses.push_back(std::abs(miss) / std::sqrt(weight2));
    }
    for (size_t k = 1; k < x.size(); ++k) {
      const double step = std::abs(x[k] - x[k - 1]);
      if (step > kRepeats) smallest_step = std::min(smallest_step, step);
    }
  }
  const double floor = std::isfinite(smallest_step) ? smallest_step / std::sqrt(12.0) : 1e-9;
  if (misses.empty()) return floor;
  std::sort(misses.begin(), misses.end());
  double sigma = misses[misses.size() / 2] / 0.6745;
  if (sigma < floor) return floor;
  // The clipped root mean square uses more of the data than the median; 0.9733 is what clipping a
  // Gaussian at 3 sigma leaves of its variance, as a share of the rows kept.
  for (int round = 0; round < 10; ++round) {
    double sum2 = 0;
    size_t n = 0;
    while (n < misses.size() && misses[n] <= 3 * sigma) sum2 += misses[n] * misses[n], ++n;
    const double next = std::sqrt(sum2 / (0.9733 * static_cast<double>(n)));
    if (std::abs(next - sigma) < 1e-9 * sigma) break;
    sigma = next;
  }
  return std::max(sigma, floor);
}

}  // namespace seam::measurement
