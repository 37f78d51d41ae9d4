#include "measurement/kinds/joints/stiffness.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "measurement/kinds/joints/motion_look.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr size_t kMostSamples = 3000, kLeastSamples = 20;
// Gains nearer than this may be one gain and a friction; so much of what one gain leaves (sum of
// squares) others must explain.
constexpr double kLeastRatio = 1.6, kLeastExplained = 0.4;

struct Sample {
  size_t log;
  double u_rad;  // How far the command is from the angle, over the reach of the acceleration.
  double q_rad, w_radps, a_radps2;
};

// A log's rows at which a driven joint moves.
std::vector<Sample> samples_of(const JointLogs& set, size_t which, size_t stride,
                               double noise_rad) {
  const JointLog& log = set.logs[which];
  std::vector<Sample> samples;
  for (const SeenMotion& at : seen_motion(log, stride, noise_rad)) {
    if (std::abs(at.w_radps) < at.rest_radps) continue;
    double sum = 0, weights = 0;
    bool driven = true;
    for (size_t k = at.row - at.reach; k < at.row + at.reach; ++k) {
      const double dt_s = 0.5 * (log.time_s[k] + log.time_s[k + 1]) - log.time_s[at.row];
      const double x = dt_s / at.reach_s, inside = std::max(0.0, 1 - x * x);
      // That of the acceleration (motion_look.cc).
      const double weight = inside * inside * (log.time_s[k + 1] - log.time_s[k]);
      const double q = at.q_rad + dt_s * (at.w_radps + 0.5 * dt_s * at.a_radps2);
      sum += weight * (log.command_rad[k] - q), weights += weight;
      driven = driven && log.enabled[k] != 0;
    }
    if (driven) samples.push_back({which, sum / weights, at.q_rad, at.w_radps, at.a_radps2});
  }
  return samples;
}

// Accelerations as one odd curve of gain times error, which may bend where a duty saturates, and
// what load and friction add.
class Curve {
 public:
  Curve(const std::vector<Sample>& samples, const std::vector<double>& gain) {
    std::vector<double> errors;
    for (const Sample& s : samples) errors.push_back(std::abs(gain[s.log] * s.u_rad));
    std::sort(errors.begin(), errors.end());
    for (const double share : {0.2, 0.4, 0.6, 0.8})
      knots_.push_back(errors[static_cast<size_t>(share * static_cast<double>(errors.size() - 1))]);
    MatrixXd rows(static_cast<Index>(samples.size()), row_of(samples[0], 1).size());
    VectorXd seen(rows.rows());
    for (Index i = 0; i < rows.rows(); ++i) {
      const Sample& s = samples[static_cast<size_t>(i)];
      rows.row(i) = row_of(s, gain[s.log]).transpose();
      seen[i] = s.a_radps2;
    }
    fit_ = solve_any_rank(rows, seen);
    left_ = (seen - rows * fit_).squaredNorm();
  }

  double left() const { return left_; }  // Sum of squares.
  double miss(const Sample& s, double gain) const { return s.a_radps2 - row_of(s, gain).dot(fit_); }

 private:
  VectorXd row_of(const Sample& s, double gain) const {
    VectorXd row(static_cast<Index>(knots_.size()) + 6);
    Index at = 0;
    const double error = gain * s.u_rad;
    for (const double knot : knots_) row[at++] = std::clamp(error, -knot, knot);
    row.tail(6) << error, s.w_radps, std::copysign(1.0, s.w_radps), maths::sin(s.q_rad),
        maths::cos(s.q_rad), 1;
    return row;
  }

  std::vector<double> knots_;
  VectorXd fit_;
  double left_ = 0;
};

// The gain with which the curve misses a log's samples least.
double best_gain(const Curve& curve, const std::vector<Sample>& samples, size_t log) {
  constexpr int kSteps = 40;
  constexpr double kMost = 32;
  double best = 1, least = std::numeric_limits<double>::infinity();
  for (int step = -kSteps; step <= kSteps; ++step) {
    const double gain = maths::exp(step * maths::log(kMost) / kSteps);
    double sum = 0;
    for (const Sample& s : samples) {
      if (s.log != log) continue;
      const double miss = curve.miss(s, gain);
      sum += miss * miss;
    }
    if (sum < least) least = sum, best = gain;
  }
  return best;
}

void centre(const std::vector<size_t>& logs, std::vector<double>& gain) {
  std::vector<double> some;
  for (const size_t log : logs) some.push_back(gain[log]);
  const double middle = median_of(some);
  for (const size_t log : logs) gain[log] /= middle;
}

std::vector<Sample> samples_of_all(const JointLogs& set, const std::vector<size_t>& logs,
                                   double noise_rad) {
  size_t rows = 0;
  for (const size_t log : logs) rows += set.logs[log].rows.size();
  std::vector<Sample> samples;
  for (const size_t log : logs) {
    const auto some = samples_of(set, log, std::max<size_t>(1, rows / kMostSamples), noise_rad);
    if (some.size() >= kLeastSamples) samples.insert(samples.end(), some.begin(), some.end());
  }
  return samples;
}

std::map<std::string, std::vector<size_t>> logs_by_joint(const JointLogs& set) {
  std::map<std::string, std::vector<size_t>> joints;
  for (size_t i = 0; i < set.logs.size(); ++i) joints[set.logs[i].joint].push_back(i);
  return joints;
}

// Of one joint's logs: changes `gain` where gains that differ explain what one does not.
void tell_gains(const JointLogs& set, const std::vector<size_t>& logs, double noise_rad,
                std::vector<double>& gain) {
  const std::vector<Sample> samples = samples_of_all(set, logs, noise_rad);
  std::vector<size_t> told;  // Logs with enough of them.
  for (const Sample& s : samples) {
    if (told.empty() || told.back() != s.log) told.push_back(s.log);
  }
  if (told.size() < 2) return;
  const double of_one = Curve(samples, gain).left();
  std::vector<double> best = gain, here = gain;
  double least = of_one;
  constexpr int kRounds = 12;
  for (int round = 0; round < kRounds; ++round) {
    const Curve curve(samples, here);
    if (curve.left() < least) least = curve.left(), best = here;
    for (const size_t log : told) here[log] = best_gain(curve, samples, log);
    centre(told, here);
  }
  if (least > (1 - kLeastExplained) * of_one) return;
  gain = best;
}

}  // namespace

std::vector<double> stiffness_of(const JointLogs& set, double noise_rad) {
  std::vector<double> gain(set.logs.size(), 1);
  for (const auto& [name, logs] : logs_by_joint(set)) tell_gains(set, logs, noise_rad, gain);
  return gain;
}

std::string note_of_stiffness(const CsvTable& table, const JointLogs& set, double noise_rad) {
  for (const JointLog& log : set.logs) {
    for (const double kp : log.kp)
      if (kp != set.logs[0].kp[0]) return "";
  }
  const std::vector<double> gain = stiffness_of(set, noise_rad);
  const auto [soft, stiff] = std::minmax_element(gain.begin(), gain.end());
  if (gain.empty() || *stiff < kLeastRatio * *soft) return "";
  const auto line_of = [&](auto log) {
    return table.line(set.logs[static_cast<size_t>(log - gain.begin())].rows.front());
  };
  return fmt::format(
      "{}:1: {}, and the data show another stiffness in other runs: that of line {} is about "
      "{:.2g} "
      "times that of line {}; expected a column kp with the controller's gain in each row",
      table.file(), table.has("kp") ? "column kp does not change" : "no column kp", line_of(stiff),
      *stiff / *soft, line_of(soft));
}

std::string note_of_unlike_joints(const CsvTable& table, const JointLogs& set, double noise_rad) {
  const auto joints = logs_by_joint(set);
  if (joints.size() < 2) return "";
  std::vector<double> gain;
  for (const JointLog& log : set.logs) gain.push_back(log.kp[0]);
  std::vector<Sample> all;
  std::vector<std::string> names;
  double alone = 0;
  for (const auto& [name, logs] : joints) {
    const std::vector<Sample> own = samples_of_all(set, logs, noise_rad);
    if (own.empty()) continue;
    alone += Curve(own, gain).left();
    all.insert(all.end(), own.begin(), own.end());
    names.push_back(name);
  }
  if (names.size() < 2) return "";
  const double together = Curve(all, gain).left();
  if (alone > (1 - kLeastExplained) * together) return "";
  return fmt::format(
      "{}:1: joints {} move unlike each other (by themselves they leave {:.2g} of what they leave "
      "together), and a model moves all joints alike: expected one joint, which `joint: {}` in "
      "measurement.yaml takes alone",
      table.file(), fmt::join(names, ", "), std::sqrt(alone / together), names[0]);
}

}  // namespace seam::measurement
