// A filter over a run that whitens what wanders and what counting rounds off.
#include <Eigen/Core>
#include <cmath>

#include "measurement/kinds/odometry/log_of_product.h"
#include "measurement/kinds/odometry/odometry.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

// What the poses so far tell of the body's own, and of the errors of its wheels' counts (of N = 5,
// in ticks).
template <int N>
struct Belief {
  WalkPose pose{};
  std::array<double, 2> count{};
  Eigen::Matrix<double, N, N> P = Eigen::Matrix<double, N, N>::Zero();

  // To the next row, which lies `step` from this in the body's frame. P = F P F', F the identity
  // but for what the heading does to x and y.
  void move(const WalkPose& step, double c, double s) {
    const WalkPose before = pose;
    pose = {pose[0] + c * step[0] - s * step[1], pose[1] + s * step[0] + c * step[1],
            pose[2] + step[2]};
    const double by_x = -(pose[1] - before[1]), by_y = pose[0] - before[0];
    const double x_theta = P(0, 2) + by_x * P(2, 2), y_theta = P(1, 2) + by_y * P(2, 2);
    P(0, 0) += by_x * (P(0, 2) + x_theta);
    P(1, 1) += by_y * (P(1, 2) + y_theta);
    P(0, 1) = P(1, 0) += by_x * P(1, 2) + by_y * x_theta;
    P(0, 2) = P(2, 0) = x_theta, P(1, 2) = P(2, 1) = y_theta;
    for (int i = 3; i < N; ++i) {
      P(0, i) = P(i, 0) += by_x * P(2, i);
      P(1, i) = P(i, 1) += by_y * P(2, i);
    }
  }

  // A wheel has rolled as its count says and by what the count's error is less than at the row
  // before. `c` and `s` are of the heading there.
  void count_on(const effects::Wheels& wheels, const std::array<CountError, 2>& error,
                const WalkPose& step, double c, double s) requires(N == 5) {
    const double base_m = wheels.base_m * (1 + wheels.base_scale);
    // What a tick more of each wheel does to the pose, which it turns on its way; what of the last
    // count's error is gone, and what is new.
    Eigen::Matrix<double, 3, 2> by_tick, by_lost, by_fresh;
    for (int wheel = 0; wheel < 2; ++wheel) {
      const double metres =
          wheels.metres_per_tick * (1 + (wheel == 0 ? wheels.left_scale : wheels.right_scale));
      const double along = 0.5 * metres, turn = (wheel == 0 ? -metres : metres) / base_m;
      const double half = 0.5 * turn, lost = 1 - error[wheel].kept;
      by_tick.col(wheel) << c * along - half * (s * step[0] + c * step[1]),
          s * along + half * (c * step[0] - s * step[1]), turn;
      by_lost.col(wheel) = lost * by_tick.col(wheel);
      by_fresh.col(wheel) = error[wheel].fresh * by_tick.col(wheel);
      for (int i = 0; i < 3; ++i) pose[i] += by_lost(i, wheel) * count[wheel];
      count[wheel] *= error[wheel].kept;
    }
    const Eigen::Matrix<double, 3, 2> both = P.template block<3, 2>(0, 3);
    const Eigen::Matrix<double, 3, 2> moved = both + by_lost * P.template block<2, 2>(3, 3);
    P.template block<3, 3>(0, 0) +=
        moved * by_lost.transpose() + by_lost * both.transpose() + by_fresh * by_tick.transpose();
    for (int wheel = 0; wheel < 2; ++wheel) {
      const double kept = error[wheel].kept;
      P.template block<3, 1>(0, 3 + wheel) = kept * moved.col(wheel) - by_fresh.col(wheel);
      P.template block<1, 3>(3 + wheel, 0) = P.template block<3, 1>(0, 3 + wheel).transpose();
      P(3 + wheel, 3 + wheel) = kept * kept * P(3 + wheel, 3 + wheel) + error[wheel].fresh;
    }
    P(3, 4) = P(4, 3) *= error[0].kept * error[1].kept;
  }

  void correct(int channel, double innovation, double variance) {
    const Eigen::Matrix<double, N, 1> column = P.col(channel);
    const double share = 1 / variance;
    for (int i = 0; i < 3; ++i) pose[i] += share * column[i] * innovation;
    for (int i = 3; i < N; ++i) count[i - 3] += share * column[i] * innovation;
    P -= share * (column * column.transpose());
  }
};

}  // namespace

// An extended Kalman filter over the run, one scalar at a time: innovations are white where the
// model is right. The first pose starts it (a flat prior), so that its own innovations are zero.
// Where nothing wanders and nothing is counted it is the same least squares as fit_start.
template <int N>
double OdometryProblem::filter(const effects::Locomotion& walk, const WalkRun& run,
                               const Start& start, const Walked& walked, const PoseSigmas& sigma,
                               Evaluation& evaluation) const {
  const std::vector<effects::WalkState>& path = walked.path;
  const double q_xy = walk.xy_sigma * walk.xy_sigma, q_theta = walk.theta_sigma * walk.theta_sigma;
  Belief<N> belief;
  belief.pose = placed(start.pose, path[0]);
  for (int i = 0; i < 3; ++i) {
    // A first pose that is blank or gross tells nothing of the start.
    const bool told = takes_part(run.rows[0], i);
    belief.P(i, i) = told ? sigma[0][i] * sigma[0][i] : kUntold2;
    if (told) belief.pose[i] = run.pose[0][i];
  }
  if constexpr (N == 5) {
    for (int wheel = 0; wheel < 2; ++wheel)
      belief.P(3 + wheel, 3 + wheel) = walked.counted[0][wheel].variance;
  }
  LogOfProduct variances;
  for (size_t k = 0; k < run.rows.size(); ++k) {
    if (k > 0) {
      const double c = maths::cos(belief.pose[2]), s = maths::sin(belief.pose[2]);
      belief.move(walked.steps[k], c, s);
      if constexpr (N == 5) belief.count_on(walk.wheels, walked.counted[k], walked.steps[k], c, s);
      const double metres = path[k].path_m - path[k - 1].path_m;
      belief.P(0, 0) += q_xy * metres;
      belief.P(1, 1) += q_xy * metres;
      belief.P(2, 2) += q_theta * metres;
    }
    for (int channel = 0; channel < 3; ++channel) {
      const int here = scalar(run.rows[k], channel);
      if (here < 0) continue;
      double innovation = run.pose[k][channel] - belief.pose[channel];
      if (channel == 2) innovation = maths::wrap_angle(innovation);
      const double variance = belief.P(channel, channel) + sigma[k][channel] * sigma[k][channel];
      const double root = std::sqrt(variance);
      evaluation.residual[here] = k == 0 && !left_out(here) ? 0 : innovation;
      evaluation.sigma[here] = root;
      if (left_out(here)) continue;
      evaluation.used[here] = 1;
      evaluation.whitened[here] = k == 0 ? 0 : innovation / root;
      if (k == 0) continue;
      variances.times(variance);
      belief.correct(channel, innovation, variance);
    }
  }
  return variances.log();
}

double OdometryProblem::filter(const effects::Locomotion& walk, const WalkRun& run,
                               const Start& start, const Walked& walked, const PoseSigmas& sigma,
                               Evaluation& evaluation) const {
  return walked.counted.empty() ? filter<3>(walk, run, start, walked, sigma, evaluation)
                                : filter<5>(walk, run, start, walked, sigma, evaluation);
}

}  // namespace seam::measurement
