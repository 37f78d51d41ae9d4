#include "effects/stages/walk/locomotion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "effects/not_a_number.h"
#include "effects/stages/walk/fading_velocity.h"
#include "sim_core/base/maths.h"

namespace seam::effects {
namespace {

// After this many time constants the lag is over to double precision of a millimetre.
constexpr double kLagIsOver = 30;

// A commanded velocity as wheels carry it out that do not slip.
BodyVelocity gripping(const Wheels& wheels, const BodyVelocity& commanded) {
  const double half_turn = 0.5 * wheels.base_m * commanded.omega_radps;
  double left = (commanded.vx_mps - half_turn) * (1 + wheels.left_scale);
  double right = (commanded.vx_mps + half_turn) * (1 + wheels.right_scale);
  if (wheels.growth_s_per_m != 0 || wheels.inner_s2_per_m != 0) {
    const double inner = wheels.inner_s2_per_m * commanded.vx_mps * commanded.omega_radps;
    left *= 1 + wheels.growth_s_per_m * std::abs(left) + inner;
    right *= 1 + wheels.growth_s_per_m * std::abs(right) - inner;
  }
  return {0.5 * (left + right), 0, (right - left) / (wheels.base_m * (1 + wheels.base_scale))};
}

BodyVelocity rolled(const Wheels& wheels, const BodyVelocity& commanded) {
  BodyVelocity v = gripping(wheels, commanded);
  const double omega =
      wheels.slips_in ? gripping(wheels, *wheels.slips_in).omega_radps : v.omega_radps;
  v.vx_mps *= std::max(0.0, 1 - wheels.slip_s * std::abs(omega));
  return v;
}

BodyVelocity scaled(const Locomotion& walk, const BodyVelocity& commanded) {
  const BodyVelocity v = walk.wheels.driven ? rolled(walk.wheels, commanded) : commanded;
  double omega_radps = v.omega_radps * (1 + walk.omega_scale);
  if (commanded.omega_radps > 0) omega_radps += walk.left_excess * commanded.omega_radps;
  return {v.vx_mps * (1 + walk.vx_scale), v.vy_mps * (1 + walk.vy_scale), omega_radps};
}

// The command as followed `t_s` after the state's time.
BodyVelocity followed_after(const Locomotion& walk, const BodyVelocity& command,
                            const WalkState& state, double t_s) {
  if (walk.tau_s <= 0) return command;
  const double fading = maths::exp(-t_s / walk.tau_s);
  const auto mix = [&](double to, double from) { return to + (from - to) * fading; };
  return {mix(command.vx_mps, state.followed.vx_mps), mix(command.vy_mps, state.followed.vy_mps),
          mix(command.omega_radps, state.followed.omega_radps)};
}

struct Rates {
  double x, y, theta, path;
};

BrokenWalk look_at(const ModelEffect& formula, const VelocitySample& sample) {
  const BodyVelocity& v = sample.velocity;
  const std::array<std::pair<const char*, double>, 3> outputs = {
      {{"vx", v.vx_mps}, {"vy", v.vy_mps}, {"omega", v.omega_radps}}};
  for (const auto& [name, value] : outputs)
    if (!usable(value)) return {formula.definition.get(), name, value, sample.t_s};
  return {};
}

struct Direction {
  double cosine = 1, sine = 0;
};

// d(x, y, theta, path)/dt at a time and place; the first formula without a number is noted. `from`
// is the direction of state.from.
Rates rates_at(const Locomotion& walk, const BodyVelocity& command, const WalkState& state,
               const Direction& from, double t_s, const Place& at, BrokenWalk& broken) {
  VelocitySample sample{.velocity = scaled(walk, followed_after(walk, command, state, t_s)),
                        .theta_rad = state.from.theta_rad + at.theta_rad,
                        .path_m = state.from.path_m + at.path_m,
                        .t_s = state.t_s + t_s,
                        .columns = state.columns};
  if (!walk.formulas.empty()) {
    sample.x_m = state.from.x_m + from.cosine * at.x_m - from.sine * at.y_m;
    sample.y_m = state.from.y_m + from.sine * at.x_m + from.cosine * at.y_m;
  }
  sample.velocity.omega_radps += walk.heading_rad_per_m * speed(sample.velocity);
  for (const ModelEffect& formula : walk.formulas) {
    formula.definition->velocity_map(formula.values(), sample);
    if (broken.formula == nullptr) broken = look_at(formula, sample);
  }
  const BodyVelocity& v = sample.velocity;
  const double c = maths::cos(at.theta_rad), s = maths::sin(at.theta_rad);
  return {c * v.vx_mps - s * v.vy_mps, s * v.vx_mps + c * v.vy_mps, v.omega_radps, speed(v)};
}

// Fourth-order Runge-Kutta steps fine enough for lag, turn and what bends velocities on their way
// (a formula, wheels that slip); they grow as the lag fades.
void integrate(const Locomotion& walk, const BodyVelocity& command, double dt_s, WalkState& state) {
  const double turn = std::abs(command.omega_radps) + std::abs(state.followed.omega_radps) +
                      std::abs(walk.heading_rad_per_m) * (speed(command) + speed(state.followed));
  double longest = 0.1 / std::max(turn, 1e-3);
  if (!walk.formulas.empty()) longest = std::min(longest, 0.02);
  longest = std::max(longest, dt_s * 1e-4);
  const WalkState start = state;
  Direction from;
  if (!walk.formulas.empty())
    from = {maths::cos(start.from.theta_rad), maths::sin(start.from.theta_rad)};
  double t = 0;
  while (t < dt_s) {
    const double fading = walk.tau_s > 0 ? 0.125 * walk.tau_s + 0.15 * t : longest;
    double h = std::min(longest, fading);
    // No sliver at the end.
    h = t + 1.01 * h >= dt_s ? dt_s - t : h;
    BrokenWalk& broken = state.broken;
    const auto rates = [&](double at_s, const Place& at) {
      return rates_at(walk, command, start, from, at_s, at, broken);
    };
    const auto moved = [&](double for_s, const Rates& by) {
      return Place{state.x_m + for_s * by.x, state.y_m + for_s * by.y,
                   state.theta_rad + for_s * by.theta, state.path_m + for_s * by.path};
    };
    const Rates a = rates(t, state);
    const Rates b = rates(t + h / 2, moved(h / 2, a));
    const Rates c = rates(t + h / 2, moved(h / 2, b));
    const Rates d = rates(t + h, moved(h, c));
    state.x_m += h / 6 * (a.x + 2 * b.x + 2 * c.x + d.x);
    state.y_m += h / 6 * (a.y + 2 * b.y + 2 * c.y + d.y);
    state.theta_rad += h / 6 * (a.theta + 2 * b.theta + 2 * c.theta + d.theta);
    state.path_m += h / 6 * (a.path + 2 * b.path + 2 * c.path + d.path);
    t = t + 1.01 * h >= dt_s ? dt_s : t + h;
  }
  state.followed = followed_after(walk, command, start, dt_s);
  state.t_s = start.t_s + dt_s;
}

// Where nothing bends what is followed, it fades from one velocity to another. All turns are to one
// side (1: left, -1: right), though those of the command may be to the other.
void fade_one_way(const Locomotion& walk, const BodyVelocity& command, double dt_s, double side,
                  WalkState& state) {
  const BodyVelocity followed = followed_after(walk, command, state, dt_s);
  BodyVelocity to = scaled(walk, command);
  if (side * command.omega_radps < 0)
    to.omega_radps += side * walk.left_excess * command.omega_radps;
  move_along({.from = scaled(walk, state.followed),
              .to = to,
              .tau_s = walk.tau_s,
              .heading_rad_per_m = walk.heading_rad_per_m},
             dt_s, state);
  state.followed = followed;
  state.t_s += dt_s;
}

void fade(const Locomotion& walk, const BodyVelocity& command, double dt_s, WalkState& state) {
  // A turn to the left and one to the right are not of one law: the way from one to the other is
  // two, which meet where the body does not turn.
  const double from = state.followed.omega_radps, to = command.omega_radps;
  const double still_s = from * to < 0 ? walk.tau_s * maths::log(1 - from / to) : dt_s;
  if (walk.left_excess != 0 && still_s < dt_s) {
    const double left_s = dt_s - still_s;
    fade_one_way(walk, command, still_s, from > 0 ? 1 : -1, state);
    state.followed.omega_radps = 0;
    dt_s = left_s;
  }
  const double turning = state.followed.omega_radps != 0 ? state.followed.omega_radps : to;
  fade_one_way(walk, command, dt_s, turning > 0 ? 1 : -1, state);
}

}  // namespace

Place Tracker::seen(const Place& body) const {
  const double c = maths::cos(body.theta_rad), s = maths::sin(body.theta_rad);
  const auto [ahead, left] =
      on_own_axes(body.x_m + (c - 1) * x_m - s * y_m, body.y_m + s * x_m + (c - 1) * y_m);
  return {.x_m = ahead, .y_m = left, .theta_rad = body.theta_rad};
}

std::array<double, 2> Tracker::on_own_axes(double ahead, double left) const {
  if (yaw_rad == 0) return {ahead, left};
  const double c = maths::cos(yaw_rad), s = maths::sin(yaw_rad);
  return {c * ahead + s * left, c * left - s * ahead};
}

std::array<double, 2> Tracker::forward(double cosine, double sine) const {
  const auto [ahead, left] = on_own_axes(1, 0);
  return {cosine * ahead - sine * left, sine * ahead + cosine * left};
}

std::vector<double> read_in_time(const std::vector<double>& ticks,
                                 const std::vector<double>& time_s, double late_s) {
  const size_t n = ticks.size();
  std::vector<double> counted(n, 0), in_time(n, 0);
  for (size_t k = 1; k < n; ++k) counted[k] = counted[k - 1] + ticks[k];
  size_t next = 0;  // The first reading after the time that is asked for.
  double before = 0;
  for (size_t k = 0; k < n; ++k) {
    while (next < n && time_s[next] + late_s <= time_s[k]) ++next;
    double count = 0;
    if (n > 1 && next > 0) {
      const size_t to = std::min(next, n - 1), from = to - 1;
      const double share = (time_s[k] - late_s - time_s[from]) / (time_s[to] - time_s[from]);
      count = counted[from] + share * ticks[to];
    }
    in_time[k] = k > 0 ? count - before : 0;
    before = count;
  }
  return in_time;
}

void move_along_arc(const BodyVelocity& v, double dt_s, double& x_m, double& y_m,
                    double& theta_rad) {
  const double turn = v.omega_radps * dt_s;
  // sin(turn)/turn and (1 - cos(turn))/turn, by series where the quotient loses digits.
  double along = 1 - turn * turn / 6, across = turn / 2 * (1 - turn * turn / 12);
  if (std::abs(turn) > 1e-3) {
    const double half_sine = maths::sin(turn / 2);
    along = maths::sin(turn) / turn;
    across = 2 * half_sine * half_sine / turn;
  }
  const double dx = (along * v.vx_mps - across * v.vy_mps) * dt_s;
  const double dy = (across * v.vx_mps + along * v.vy_mps) * dt_s;
  const double c = maths::cos(theta_rad), s = maths::sin(theta_rad);
  x_m += c * dx - s * dy;
  y_m += s * dx + c * dy;
  theta_rad += turn;
}

Locomotion locomotion_of(const Model& model) {
  Locomotion walk;
  for (const ModelEffect& effect : model.effects()) {
    if (effect.definition->locomotion) effect.definition->locomotion(effect.values(), walk);
    if (effect.definition->velocity_map) walk.formulas.push_back(effect);
    if (effect.definition->tracker) effect.definition->tracker(effect.values(), walk.tracker);
  }
  return walk;
}

void advance_walk(const Locomotion& walk, const BodyVelocity& command, double dt_s,
                  WalkState& state) {
  if (dt_s <= 0) return;
  double left_s = dt_s;
  if (walk.tau_s > 0 || !walk.formulas.empty()) {
    const double lagging_s =
        walk.formulas.empty() ? std::min(left_s, kLagIsOver * walk.tau_s) : left_s;
    const bool bent = !walk.formulas.empty() || walk.wheels.bend_commands();
    (bent ? integrate : fade)(walk, command, lagging_s, state);
    left_s -= lagging_s;
  }
  if (left_s <= 0) return;
  BodyVelocity v = scaled(walk, command);
  v.omega_radps += walk.heading_rad_per_m * speed(v);
  move_along_arc(v, left_s, state.x_m, state.y_m, state.theta_rad);
  state.path_m += speed(v) * left_s;
  state.followed = command;
  state.t_s += left_s;
}

}  // namespace seam::effects
