#include "effects/stages/walk/fading_velocity.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim_core/base/maths.h"

namespace seam::effects {
namespace {

constexpr int kNodes = 5;
using AtNodes = std::array<double, kNodes>;

// Gauss and Legendre's rule over 0 to 1, and what leads from values at the nodes to the integrals
// from 0 to each node of the polynomial through them:
//
//   A_ij = w_j sum_k (2 k + 1) P_k(2 c_j - 1) int_0^c_i P_k(2 x - 1) dx
//
// with Legendre's polynomials P_k, k < n, which the rule itself finds orthogonal.
struct Rule {
  AtNodes node{}, weight{};
  std::array<AtNodes, kNodes> to_node{};

  Rule() {
    const double inner = std::sqrt(5 - 2 * std::sqrt(10.0 / 7)) / 3,
                 outer = std::sqrt(5 + 2 * std::sqrt(10.0 / 7)) / 3;
    const double heavy = (322 + 13 * std::sqrt(70.0)) / 1800,
                 light = (322 - 13 * std::sqrt(70.0)) / 1800;
    const AtNodes y = {-outer, -inner, 0, inner, outer};
    weight = {light, heavy, 64.0 / 225, heavy, light};
    std::array<std::array<double, kNodes + 1>, kNodes> p;  // By node, P_0 to P_n.
    for (int i = 0; i < kNodes; ++i) {
      node[i] = 0.5 * (1 + y[i]);
      p[i][0] = 1, p[i][1] = y[i];
      for (int k = 1; k < kNodes; ++k)
        p[i][k + 1] = ((2 * k + 1) * y[i] * p[i][k] - k * p[i][k - 1]) / (k + 1);
    }
    for (int i = 0; i < kNodes; ++i) {
      for (int j = 0; j < kNodes; ++j) {
        double sum = node[i];
        for (int k = 1; k < kNodes; ++k) sum += 0.5 * p[j][k] * (p[i][k + 1] - p[i][k - 1]);
        to_node[i][j] = weight[j] * sum;
      }
    }
  }
};

const Rule& rule() {
  static const Rule kRule;
  return kRule;
}

// Sine and cosine; for small angles by their series, to double precision.
std::array<double, 2> turned_by(double angle_rad) {
  constexpr double kSmall_rad = 0.35;
  if (std::abs(angle_rad) > kSmall_rad) return {maths::sin(angle_rad), maths::cos(angle_rad)};
  const double x2 = angle_rad * angle_rad;
  const double sine =
      1 - x2 / 6 * (1 - x2 / 20 * (1 - x2 / 42 * (1 - x2 / 72 * (1 - x2 / 110 * (1 - x2 / 156)))));
  const double cosine =
      1 - x2 / 2 * (1 - x2 / 12 * (1 - x2 / 30 * (1 - x2 / 56 * (1 - x2 / 90 * (1 - x2 / 132)))));
  return {angle_rad * sine, cosine};
}

// When the body is slowest while it turns back: the speed has a kink there. Infinite: never.
double slowest_s(const FadingVelocity& v) {
  const double bx = v.from.vx_mps - v.to.vx_mps, by = v.from.vy_mps - v.to.vy_mps;
  const double share = -(v.to.vx_mps * bx + v.to.vy_mps * by) / (bx * bx + by * by);
  return share > 0 && share < 1 ? -v.tau_s * maths::log(share) : HUGE_VAL;
}

// One step of the rule, which begins `t_s` after the velocity began to fade.
void step(const FadingVelocity& v, double t_s, double h_s, Place& place) {
  const Rule& r = rule();
  const double turn_in_the_end = v.to.omega_radps, fades = v.from.omega_radps - turn_in_the_end;
  const double left = maths::exp(-t_s / v.tau_s);
  AtNodes vx, vy, speeds, angle;
  double path = 0;
  for (int i = 0; i < kNodes; ++i) {
    const double share = maths::exp(-(t_s + r.node[i] * h_s) / v.tau_s);
    vx[i] = v.to.vx_mps + (v.from.vx_mps - v.to.vx_mps) * share;
    vy[i] = v.to.vy_mps + (v.from.vy_mps - v.to.vy_mps) * share;
    speeds[i] = speed({vx[i], vy[i], 0});
    angle[i] = turn_in_the_end * r.node[i] * h_s + fades * v.tau_s * (left - share);
    path += h_s * r.weight[i] * speeds[i];
  }
  if (v.heading_rad_per_m != 0) {
    for (int i = 0; i < kNodes; ++i) {
      for (int j = 0; j < kNodes; ++j)
        angle[i] += v.heading_rad_per_m * h_s * r.to_node[i][j] * speeds[j];
    }
  }
  double along = 0, across = 0;
  for (int i = 0; i < kNodes; ++i) {
    const auto [s, c] = turned_by(angle[i]);
    along += h_s * r.weight[i] * (c * vx[i] - s * vy[i]);
    across += h_s * r.weight[i] * (s * vx[i] + c * vy[i]);
  }
  const double c = maths::cos(place.theta_rad), s = maths::sin(place.theta_rad);
  place.x_m += c * along - s * across;
  place.y_m += s * along + c * across;
  const double still_left = maths::exp(-(t_s + h_s) / v.tau_s);
  place.theta_rad +=
      turn_in_the_end * h_s + fades * v.tau_s * (left - still_left) + v.heading_rad_per_m * path;
  place.path_m += path;
}

}  // namespace

// Steps are as long as the lag, and grow as it fades; none turns far, none goes over a kink.
void move_along(const FadingVelocity& v, double dt_s, Place& place) {
  constexpr double kTurn_rad = 0.35, kSlowest_radps = 1e-3, kMostSteps = 1e4;
  const double rate = std::abs(v.from.omega_radps) + std::abs(v.to.omega_radps) +
                      std::abs(v.heading_rad_per_m) * (speed(v.from) + speed(v.to));
  const double longest = std::max(kTurn_rad / std::max(rate, kSlowest_radps), dt_s / kMostSteps);
  const double kink = slowest_s(v);
  double t = 0;
  while (t < dt_s) {
    const double h = std::min(longest, v.tau_s + 0.5 * t);
    double end = t + h;
    // No sliver at the end, nor beside the kink.
    const double sliver = 0.01 * h;
    if (kink > t + sliver && kink < end + sliver) end = kink;
    if (end + sliver >= dt_s) end = dt_s;
    step(v, t, end - t, place);
    t = end;
  }
}

}  // namespace seam::effects
