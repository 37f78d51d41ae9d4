// A filter over a run that whitens what wanders and what counting rounds off.
#include <Eigen/Core>
#include <cmath>

#include "measurement/kinds/odometry/log_of_product.h"
#include "measurement/kinds/odometry/odometry.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

// What the poses so far tell of the body's own, and (of N = 7) of the errors of way and speed of
// its left and its right wheel, in ticks.
template <int N>
struct Belief {
  Eigen::Matrix<double, N, 1> mean = Eigen::Matrix<double, N, 1>::Zero();
  Eigen::Matrix<double, N, N> P = Eigen::Matrix<double, N, N>::Zero();

  // To the next row, which lies `step` from this in the body's frame. P = F P F', F the identity
  // but for what the heading does to x and y.
  void move(const WalkPose& step, double c, double s) {
    const double by_x = -(s * step[0] + c * step[1]), by_y = c * step[0] - s * step[1];
    mean[0] += by_y, mean[1] -= by_x, mean[2] += step[2];
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

  // The body turns a little more, which swings the measured point round the axle.
  void turn(const std::array<double, 2>& swing, double variance) {
    for (int i = 0; i < 2; ++i) {
      P(i, 2) = P(2, i) += variance * swing[i];
      for (int j = 0; j < 2; ++j) P(i, j) += variance * swing[i] * swing[j];
    }
    P(2, 2) += variance;
  }

  // A wheel has rolled by what its error is more than at the row before. `c` and `s` are of the
  // heading there.
  void roll_on(const effects::Wheels& wheels, const effects::Tracker& tracker,
               const std::array<RolledWay::Step, 2>& error, const WalkPose& step, double c,
               double s) requires(N == 7) {
    const double base_m = wheels.base_m * (1 + wheels.base_scale);
    Eigen::Matrix<double, N, N> F = Eigen::Matrix<double, N, N>::Identity();
    Eigen::Matrix<double, N, N> fresh = Eigen::Matrix<double, N, N>::Zero();
    for (int wheel = 0; wheel < 2; ++wheel) {
      const double metres =
          wheels.metres_per_tick * (1 + (wheel == 0 ? wheels.left_scale : wheels.right_scale));
      const double along = 0.5 * metres, turn = (wheel == 0 ? -metres : metres) / base_m;
      const double half = 0.5 * turn;
      // What a tick more does to the pose, which it turns on its way, and to the errors. The
      // measured point swings round the axle.
      const std::array<double, 2> swing = tracker.by_turn(c, s), forward = tracker.forward(c, s);
      Eigen::Matrix<double, 3, 1> by_tick;
      by_tick << forward[0] * along - half * (s * step[0] + c * step[1]) + turn * swing[0],
          forward[1] * along + half * (c * step[0] - s * step[1]) + turn * swing[1], turn;
      const int at = 3 + 2 * wheel;
      const auto& [kept, new_error] = error[static_cast<size_t>(wheel)];
      F.template block<3, 2>(0, at) = by_tick * (kept.row(0) - Eigen::RowVector2d(1, 0));
      F.template block<2, 2>(at, at) = kept;
      Eigen::Matrix<double, N, 2> by_new = Eigen::Matrix<double, N, 2>::Zero();
      by_new.template block<3, 1>(0, 0) = by_tick;
      by_new.template block<2, 2>(at, 0) = Eigen::Matrix2d::Identity();
      fresh += by_new * new_error * by_new.transpose();
    }
    mean = F * mean;
    P = F * P * F.transpose() + fresh;
  }

  void correct(int channel, double innovation, double variance) {
    const Eigen::Matrix<double, N, 1> column = P.col(channel);
    const double share = 1 / variance;
    mean += share * innovation * column;
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
  const WalkPose first = placed(start.pose, path[0]);
  for (int i = 0; i < 3; ++i) {
    // A first pose that is blank or gross tells nothing of the start.
    const bool told = takes_part(run.rows[0], i);
    belief.P(i, i) = told ? sigma[0][i] * sigma[0][i] : kUntold2;
    belief.mean[i] = told ? run.pose[0][i] : first[i];
  }
  if constexpr (N == 7) {
    for (int wheel = 0; wheel < 2; ++wheel)
      belief.P.template block<2, 2>(3 + 2 * wheel, 3 + 2 * wheel) = walked.counted.first[wheel];
  }
  LogOfProduct variances;
  for (size_t k = 0; k < run.rows.size(); ++k) {
    if (k > 0) {
      const double c = maths::cos(belief.mean[2]), s = maths::sin(belief.mean[2]);
      belief.move(walked.steps[k], c, s);
      if constexpr (N == 7)
        belief.roll_on(walk.wheels, walk.tracker, walked.counted.step[k], walked.steps[k], c, s);
      const double metres = path[k].path_m - path[k - 1].path_m;
      belief.P(0, 0) += q_xy * metres;
      belief.P(1, 1) += q_xy * metres;
      std::array<double, 2> swing = {0, 0};
      if (q_theta > 0 && !walk.tracker.is_axle())
        swing = walk.tracker.by_turn(maths::cos(belief.mean[2]), maths::sin(belief.mean[2]));
      belief.turn(swing, q_theta * metres);
    }
    for (int channel = 0; channel < 3; ++channel) {
      const int here = scalar(run.rows[k], channel);
      if (here < 0) continue;
      double innovation = run.pose[k][channel] - belief.mean[channel];
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
                                : filter<7>(walk, run, start, walked, sigma, evaluation);
}

}  // namespace seam::measurement
