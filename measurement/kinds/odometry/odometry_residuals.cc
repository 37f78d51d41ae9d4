// From a predicted path to residuals: the true start of a run, fitted; and predictions that nothing
// measured on their way corrects.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "measurement/kinds/odometry/log_of_product.h"
#include "measurement/kinds/odometry/odometry.h"
#include "measurement/numerics/linear_algebra.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

// A start from which the run's path leads through this pose.
WalkPose start_through(const WalkPose& pose, const effects::WalkState& there) {
  const double theta = pose[2] - there.theta_rad;
  const WalkPose moved = placed({0, 0, theta}, there);
  return {pose[0] - moved[0], pose[1] - moved[1], theta};
}

// Mean squares of a position's and a heading's errors.
struct Errors {
  double position2 = 0, heading2 = 0;
  int64_t count = 0;

  void add(const WalkPose& error) {
    position2 += error[0] * error[0] + error[1] * error[1];
    heading2 += error[2] * error[2];
    ++count;
  }
  void append(const std::string& over, const Errors& last, std::vector<FreeError>& to) const {
    if (count == 0) return;
    const auto root = [](double sum, int64_t n) {
      return n > 0 ? std::sqrt(sum / static_cast<double>(n)) : 0;
    };
    to.push_back(
        {over, "position_m", root(position2, count), root(last.position2, last.count), count});
    to.push_back(
        {over, "theta_rad", root(heading2, count), root(last.heading2, last.count), count});
  }
};

}  // namespace

// Gauss-Newton for the run's true start, from its first whole pose, by its first `rows` rows.
OdometryProblem::Start OdometryProblem::fit_start(const WalkRun& run, size_t rows,
                                                  const std::vector<effects::WalkState>& path,
                                                  const PoseSigmas& sigma) const {
  Start start;
  for (size_t k = 0; k < rows; ++k) {
    if (!is_whole(run, k)) continue;
    start.pose = start_through(run.pose[k], path[k]);
    break;
  }
  Eigen::Matrix3d information;
  for (int step = 0; step < 12; ++step) {
    information.setZero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    int count = 0;
    const double c = maths::cos(start.pose[2]), s = maths::sin(start.pose[2]);
    for (size_t k = 0; k < rows; ++k) {
      const double dx = c * path[k].x_m - s * path[k].y_m, dy = s * path[k].x_m + c * path[k].y_m;
      const auto r = missed(
          run.pose[k], {start.pose[0] + dx, start.pose[1] + dy, start.pose[2] + path[k].theta_rad});
      const std::array<double, 3> by_heading = {-dy, dx, 1};
      for (int channel = 0; channel < 3; ++channel) {
        if (!takes_part(run.rows[k], channel)) continue;
        const double weight = 1 / (sigma[k][channel] * sigma[k][channel]);
        information(2, 2) += weight * by_heading[channel] * by_heading[channel];
        right[2] += weight * by_heading[channel] * r[channel];
        ++count;
        if (channel == 2) continue;
        information(channel, channel) += weight;
        information(channel, 2) += weight * by_heading[channel];
        right[channel] += weight * r[channel];
      }
    }
    information(2, 0) = information(0, 2), information(2, 1) = information(1, 2);
    start.unknowns = std::min(3, count);
    // What no pose tells stays where it is.
    for (int i = 0; i < 3; ++i) {
      if (information(i, i) == 0) information(i, i) = 1;
    }
    const Eigen::Vector3d move = solve_symmetric(information, right);
    if (!move.allFinite()) break;
    for (int i = 0; i < 3; ++i) start.pose[i] += move[i];
    if (move.squaredNorm() < 1e-20) break;
  }
  start.log_det = log_det_of(run, information, sigma);
  return start;
}

// det S = det R det P det(P^-1 + H' R^-1 H), S the covariance of all poses but the first, whose own
// is P; the information that all poses have of the start is the last factor's.
double OdometryProblem::log_det_of(const WalkRun& run, const Eigen::Matrix3d& information,
                                   const PoseSigmas& sigma) const {
  Eigen::Matrix3d all = information;
  LogOfProduct product;
  for (int i = 0; i < 3; ++i) {
    if (takes_part(run.rows[0], i)) {
      product.times(sigma[0][i] * sigma[0][i]);
    } else {
      product.times(kUntold2);
      all(i, i) += 1 / kUntold2;
    }
  }
  for (size_t k = 1; k < run.rows.size(); ++k) {
    for (int channel = 0; channel < 3; ++channel) {
      if (takes_part(run.rows[k], channel)) product.times(sigma[k][channel] * sigma[k][channel]);
    }
  }
  return product.log() + std::log(all.determinant());
}

void OdometryProblem::take_start(const WalkRun& run, const WalkPose& start,
                                 const std::vector<effects::WalkState>& path,
                                 const PoseSigmas& sigma, Evaluation& evaluation) const {
  const From from_start(start);
  for (size_t k = 0; k < run.rows.size(); ++k) {
    const auto r = missed(run.pose[k], from_start(path[k]));
    for (int channel = 0; channel < 3; ++channel) {
      const int here = scalar(run.rows[k], channel);
      if (here < 0) continue;
      // Outliers keep their residuals, so that the next look for outliers finds them again.
      evaluation.residual[here] = r[channel];
      evaluation.sigma[here] = sigma[k][channel];
      if (left_out(here)) continue;
      evaluation.used[here] = 1;
      evaluation.whitened[here] = r[channel] / sigma[k][channel];
    }
  }
}

std::vector<FreeError> OdometryProblem::free_prediction(const Model& model,
                                                        const Groups& groups) const {
  const effects::Locomotion walk = effects::locomotion_of(model);
  const effects::Timing timing = effects::timing_of(model);
  const std::vector<effects::MovingNoise> noise = effects::noise_of(model).pose;
  constexpr double kShort_s = 1, kSlack_s = 0.5, kNanosecond = 1e-9;
  Errors shortly, wholly, ends;
  for (const WalkRun& run : runs_) {
    if (!groups[facts_.group_of_row[run.rows[0]]]) continue;
    const auto path = predict_walk(walk, run, timing, ticks_as(walk));
    std::vector<size_t> seen;
    for (size_t k = 0; k < run.rows.size(); ++k) {
      if (takes_part(run.rows[k], 0) && takes_part(run.rows[k], 1) && takes_part(run.rows[k], 2))
        seen.push_back(k);
    }
    if (seen.empty()) continue;
    for (size_t a = 0, b = 0; a < seen.size(); ++a) {
      const double until = run.time_s[seen[a]] + kShort_s;
      while (b < seen.size() && run.time_s[seen[b]] < until - kNanosecond) ++b;
      if (b == seen.size()) break;
      if (run.time_s[seen[b]] > until + kSlack_s) continue;
      shortly.add(missed(run.pose[seen[b]],
                         placed(run.pose[seen[a]], between(path[seen[a]], path[seen[b]]))));
    }
    // A run starts where the poses of its first second say.
    const auto after = std::find_if(seen.begin(), seen.end(), [&](size_t k) {
      return run.time_s[k] > run.time_s[seen.front()] + kShort_s;
    });
    if (after == seen.end()) continue;
    const Start start = fit_start(run, *after, path, pose_sigmas(noise, noise_of_set(), run, path));
    const From from_start(start.pose);
    for (auto k = after; k != seen.end(); ++k)
      wholly.add(missed(run.pose[*k], from_start(path[*k])));
    ends.add(missed(run.pose[seen.back()], from_start(path[seen.back()])));
  }
  std::vector<FreeError> all;
  shortly.append("1 s", shortly, all);
  wholly.append("run", ends, all);
  return all;
}

}  // namespace seam::measurement
