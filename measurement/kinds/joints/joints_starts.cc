// How logs start: the angle at the first row is measured like the others, and the rate of a motor
// that begins in motion is read off its first rows, so both are fitted, near what was measured.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "effects/questions.h"
#include "measurement/kinds/joints/joints.h"
#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {
namespace {

// A motor whose log begins in motion has two unknowns: its angle and its rate.
bool has_rate(const Model& model, const JointLog& log) {
  return log.start_radps != 0 && effects::has_base(model, effects::Base::motor);
}

}  // namespace

std::vector<double> JointsProblem::predict_from(const Model& model, const JointLog& log,
                                                const LogStart& start,
                                                std::vector<double>* drives) const {
  return predict_joint_log(model, set_, log, log.measured_rad.front() + start.offset_rad,
                           log.start_radps + start.offset_radps, {},
                           has_efforts() ? drives : nullptr);
}

int64_t JointsProblem::unknowns_of_start(const Model& model, const JointLog& log) const {
  return has_rate(model, log) ? 2 : 1;
}

std::vector<std::vector<double>> JointsProblem::start_slopes(const Model& model,
                                                             const JointLog& log,
                                                             const LogStart& start,
                                                             const std::vector<double>& predicted,
                                                             double sigma_rad) const {
  std::vector<std::vector<double>> slopes;
  const auto add = [&](LogStart moved, double by) {
    std::vector<double> column = predict_from(model, log, moved);
    for (size_t k = 0; k < column.size(); ++k) {
      column[k] = left_out(log.rows[k]) ? 0 : (column[k] - predicted[k]) / by;
    }
    slopes.push_back(std::move(column));
  };
  add({start.offset_rad + sigma_rad, start.offset_radps}, sigma_rad);
  const double step = 0.01 * std::abs(log.start_radps);
  if (has_rate(model, log)) add({start.offset_rad, start.offset_radps + step}, step);
  return slopes;
}

// One step of Gauss and Newton from where the log was measured.
JointsProblem::Prediction JointsProblem::fit_start(const Model& model, const JointLog& log,
                                                   double sigma_rad) const {
  const size_t n = log.rows.size();
  const auto chi2_of = [&](const std::vector<double>& angles) {
    double sum = 0;
    for (size_t k = 0; k < n; ++k) {
      if (left_out(log.rows[k])) continue;
      const double miss = log.measured_rad[k] - angles[k];
      sum += miss * miss;
    }
    return sum;
  };
  std::vector<double> drives, better_drives;
  const std::vector<double> predicted = predict_from(model, log, {}, &drives);
  const auto slopes = start_slopes(model, log, {}, predicted, sigma_rad);
  const auto count = static_cast<Eigen::Index>(slopes.size());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(count);
  for (size_t k = 0; k < n; ++k) {
    for (Eigen::Index a = 0; a < count; ++a) {
      if (!left_out(log.rows[k])) right[a] += slopes[a][k] * (log.measured_rad[k] - predicted[k]);
      for (Eigen::Index b = 0; b < count; ++b) normal(a, b) += slopes[a][k] * slopes[b][k];
    }
  }
  if (!(normal(0, 0) > 0)) return {{}, predicted, drives};
  Eigen::VectorXd step = right.head(1) / normal(0, 0);
  if (count > 1) solve_positive(normal, right, step);
  // The start is measured as well: a model that fails later must not move it far from there.
  const double most = kFarthestStart * sigma_rad;
  LogStart start{.offset_rad = std::clamp(step[0], -most, most), .log_det = std::log(normal(0, 0))};
  const double widest = 0.2 * std::abs(log.start_radps);
  if (step.size() > 1) start.offset_radps = std::clamp(step[1], -widest, widest);
  if (start.offset_rad == 0 && start.offset_radps == 0) return {start, predicted, drives};
  std::vector<double> better = predict_from(model, log, start, &better_drives);
  if (!(chi2_of(better) < chi2_of(predicted)))
    return {{.log_det = start.log_det}, predicted, std::move(drives)};
  return {start, std::move(better), std::move(better_drives)};
}

}  // namespace seam::measurement
