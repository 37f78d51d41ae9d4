#include "effects/stages/torque/torque.h"

#include <algorithm>
#include <cmath>

#include "effects/stages/torque/series.h"
#include "sim_core/base/maths.h"

namespace seam::effects {
namespace {

// Enough for a row of most servos; of those with fast motors kMostOrder makes longer pieces.
constexpr int kOrder = 9;
constexpr double kTolerance_rad = 1e-12;  // Of the last two terms.
// Slower Stribeck speeds than this are a step at rest.
constexpr double kLeastStribeck_radps = 1e-6;
// Pieces of one call: more stand for an equation that no servo has.
constexpr int kMostPieces = 600;

// Which side of each clamp and sign the motion is on: there the equation is analytic.
struct Region {
  int duty = 0;   // -1, +1: clamped.
  int drive = 0;  // Likewise.
  int net = 1;    // Sign.
  int gear = 1;   // Sign.
  int way = 1;    // Of the motion.
};

int side_of(double value, double most) {
  return value > most ? 1 : value < -most ? -1 : 0;
}

double wanted_duty(const TorqueModel& m, const MotorInput& in, const MotorState& s) {
  return m.gain * in.kp * (in.command_rad - s.q_rad) - m.damping_s * s.w_radps;
}

double free_drive(const TorqueModel& m, const MotorInput& in, const MotorState& s) {
  if (!in.enabled) return 0;
  return in.strength * (drive_at_rest(m, in, s) - m.back_emf_per_s * s.w_radps);
}

// What at this angle is to be multiplied with gravity and cogging; 0 where there is none.
struct Pull {
  double gravity = 0, cogging = 0;
};

double wave_rad(const TorqueModel& m, double q_rad) {
  return m.cogging_per_turn * q_rad + m.cogging_rad;
}

Pull pull_at(const TorqueModel& m, double q_rad) {
  return {m.gravity_rad_per_s2 == 0 ? 0 : maths::cos(q_rad - m.level_rad),
          m.cogging_rad_per_s2 == 0 ? 0 : maths::sin(wave_rad(m, q_rad))};
}

double load_at(const TorqueModel& m, const Pull& pull) {
  const double load = m.gravity_rad_per_s2 * pull.gravity + m.asymmetry_rad_per_s2;
  return m.cogging_rad_per_s2 == 0 ? load : load - m.cogging_rad_per_s2 * pull.cogging;
}

// What pushes and what dry friction depends on.
struct Forces {
  double net = 0;   // Drive less load: what is left to accelerate the joint.
  double gear = 0;  // Drive and load: what the gears carry between them.
};

Forces forces_of(const TorqueModel& m, double drive, double load) {
  return {drive - load, m.carried_fraction > 0 ? drive + load : 0};
}

Forces forces_of(const TorqueModel& m, const MotorInput& in, const MotorState& s, double load) {
  return forces_of(m, drive_of(m, in, s), load);
}

// By how much the forces exceed what friction holds at rest.
double beyond_rest(const TorqueModel& m, const Forces& forces) {
  const double holds = m.coulomb_rad_per_s2 + m.stribeck_rad_per_s2;
  return std::abs(forces.net) * (1 - m.load_fraction) - m.carried_fraction * std::abs(forces.gear) -
         holds * (1 + 1e-12);
}

// The motion from one state while the region holds.
class Stretch {
 public:
  Stretch(const TorqueModel& motor, const MotorInput& input, const MotorState& state,
          const Pull& pull, const Region& region)
      : m_(motor), in_(input), region_(region) {
    q_[0] = state.q_rad, w_[0] = state.w_radps, cos_[0] = pull.gravity;
    wave_[0] = pull.cogging;
    start();
    for (; order_ < kOrder; ++order_) extend(order_);
  }

  // At most `dt_s`, as long as the series is good, to which powers are added where it is not good
  // for all of it.
  double reach(double dt_s) {
    if (is_good(dt_s)) return dt_s;
    for (; order_ < kMostOrder; ++order_) extend(order_);
    double h = dt_s;
    for (int halving = 0; halving < 80; ++halving) {
      if (is_good(h)) return h;
      h *= last_terms(q_, h) < 1e4 * kTolerance_rad ? 0.8 : 0.5;
    }
    return kInfinity;
  }

  // When within `h` the region ends, and the one that follows; infinite: it does not. Where the
  // motion itself ends, `stops` is set.
  double end(double h, Region& next, bool& stops) const {
    double first = kInfinity;
    const auto offer = [&](const Series& f, double sign, double offset, int order, auto&& change) {
      Series g;
      for (int k = 0; k <= order; ++k) g[k] = sign * f[k];
      g[0] += offset;
      const double t = first_fall(g, std::min(h, first), order);
      if (!(t < first)) return;
      first = t, next = region_, stops = false;
      change();
    };
    offer(w_, region_.way, 0, order_ - 1, [&] { stops = true; });
    if (m_.load_fraction > 0)
      offer(net_, region_.net, 0, order_ - 2, [&] { next.net = -region_.net; });
    if (m_.carried_fraction > 0)
      offer(gear_, region_.gear, 0, order_ - 2, [&] { next.gear = -region_.gear; });
    const auto offer_clamp = [&](const Series& f, double most, int side, int Region::*which) {
      if (side != 0) return offer(f, side, -most, order_ - 2, [&] { next.*which = 0; });
      offer(f, -1, most, order_ - 2, [&] { next.*which = 1; });
      offer(f, 1, most, order_ - 2, [&] { next.*which = -1; });
    };
    if (in_.enabled) {
      offer_clamp(duty_, m_.max_duty, region_.duty, &Region::duty);
      if (std::isfinite(m_.limit_rad_per_s2))
        offer_clamp(drive_, m_.limit_rad_per_s2, region_.drive, &Region::drive);
    }
    return first;
  }

  MotorState at(double t) const { return {value_of(q_, t, order_), value_of(w_, t, order_ - 1)}; }

 private:
  void start() {
    if (m_.gravity_rad_per_s2 != 0) sin_[0] = maths::sin(q_[0] - m_.level_rad);
    if (m_.cogging_rad_per_s2 != 0) across_[0] = maths::cos(wave_rad(m_, q_[0]));
    has_stribeck_ = m_.stribeck_rad_per_s2 != 0 && m_.stribeck_rad_per_s >= kLeastStribeck_radps;
    if (has_stribeck_) {
      // Kept above 0, so that a share of it says something.
      const double rates = std::min(std::abs(w_[0]) / m_.stribeck_rad_per_s, 600.0);
      near_rest_[0] = maths::exp(-rates);
    }
  }

  // Drive, net and gear of power k from what is known of angle and rate.
  void drive(int k) {
    const double ahead = (k == 0 ? in_.command_rad : k == 1 ? in_.command_radps : 0) - q_[k];
    duty_[k] = m_.gain * in_.kp * ahead - m_.damping_s * w_[k];
    drive_[k] = 0;
    if (in_.enabled) {
      const double clamped = k == 0 ? region_.duty * m_.max_duty : 0;
      const double duty = region_.duty == 0 ? duty_[k] : clamped;
      drive_[k] =
          in_.strength * (m_.stall_rad_per_s2 * in_.voltage * duty - m_.back_emf_per_s * w_[k]);
    }
    const double limit = k == 0 && region_.drive != 0 ? region_.drive * m_.limit_rad_per_s2 : 0;
    const double drive = region_.drive == 0 ? drive_[k] : limit;
    double load = m_.gravity_rad_per_s2 * cos_[k] + (k == 0 ? m_.asymmetry_rad_per_s2 : 0);
    if (m_.cogging_rad_per_s2 != 0) load -= m_.cogging_rad_per_s2 * wave_[k];
    net_[k] = drive - load, gear_[k] = drive + load;
  }

  // From power k of everything to power k + 1 of angle and rate.
  void extend(int k) {
    drive(k);
    double dry =
        m_.load_fraction * region_.net * net_[k] + m_.carried_fraction * region_.gear * gear_[k];
    if (k == 0) dry += m_.coulomb_rad_per_s2;
    if (has_stribeck_) dry += m_.stribeck_rad_per_s2 * near_rest_[k];
    const double over = 1.0 / (k + 1);
    q_[k + 1] = w_[k] * over;
    w_[k + 1] = (net_[k] - m_.viscous_per_s * w_[k] - region_.way * dry) * over;
    if (m_.gravity_rad_per_s2 != 0) {
      double sine = 0, cosine = 0;
      for (int j = 0; j <= k; ++j) {
        const double turn = w_[j];
        sine += turn * cos_[k - j], cosine -= turn * sin_[k - j];
      }
      sin_[k + 1] = sine * over, cos_[k + 1] = cosine * over;
    }
    if (m_.cogging_rad_per_s2 != 0) {
      double wave = 0, across = 0;
      for (int j = 0; j <= k; ++j) {
        const double turn = m_.cogging_per_turn * w_[j];
        wave += turn * across_[k - j], across -= turn * wave_[k - j];
      }
      wave_[k + 1] = wave * over, across_[k + 1] = across * over;
    }
    if (has_stribeck_) {
      double sum = 0;
      for (int j = 0; j <= k; ++j) sum += (j + 1) * w_[j + 1] * near_rest_[k - j];
      near_rest_[k + 1] = -region_.way * sum * over / m_.stribeck_rad_per_s;
    }
  }

  bool is_good(double h) const { return last_terms(q_, h) < kTolerance_rad && friction_is_good(h); }

  double last_terms(const Series& f, double h) const {
    double power = 1;
    for (int k = 0; k < order_ - 1; ++k) power *= h;
    return std::abs(f[order_ - 1]) * power + std::abs(f[order_]) * power * h;
  }

  // A fast joint does not see yet what grows by powers of ten while it comes to rest: the series
  // of this friction must converge by itself, unless the joint stays fast.
  bool friction_is_good(double h) const {
    if (!has_stribeck_) return true;
    constexpr double kShare = 1e-3, kGone = 40;
    double change = 0;
    for (int k = order_ - 1; k >= 1; --k) change = (change + std::abs(w_[k])) * h;
    if (change < std::abs(w_[0]) - kGone * m_.stribeck_rad_per_s) return true;
    return last_terms(near_rest_, h) < kShare * near_rest_[0];
  }

  const TorqueModel& m_;
  const MotorInput& in_;
  const Region region_;
  int order_ = 0;
  bool has_stribeck_ = false;
  Series q_, w_, duty_, drive_, net_, gear_;
  Series sin_{}, cos_{}, near_rest_{};
  Series wave_, across_;  // Sine and cosine of the cogging's wave.
};

// The drive nearest `drive` in this direction at which friction lets the joint go; infinite: none.
// What friction holds is linear in the drive between the signs of net and gear.
double drive_that_breaks(const TorqueModel& m, double drive, int way, double load) {
  const double first = way > 0 ? -std::abs(load) : std::abs(load);
  for (const double next : {first, -first, way * kInfinity}) {
    if (way * (next - drive) <= 0) continue;
    const double inside = std::isfinite(next) ? 0.5 * (drive + next) : drive + way;
    const double net_side = inside < load ? -1 : 1, gear_side = inside < -load ? -1 : 1;
    const double slope = way * ((1 - m.load_fraction) * net_side - m.carried_fraction * gear_side);
    const double short_of = -beyond_rest(m, forces_of(m, drive, load));
    if (slope > 0 && way * (next - drive) * slope >= short_of)
      return drive + way * short_of / slope;
    drive = next;
  }
  return way * kInfinity;
}

// How long friction holds a joint at rest, at most `dt_s`; sets the way it breaks away.
double rest_for(const TorqueModel& m, const MotorInput& in, const MotorState& state, double load,
                double dt_s, int& way) {
  const Forces forces = forces_of(m, in, state, load);
  way = forces.net < 0 ? -1 : 1;
  if (beyond_rest(m, forces) > 0) return 0;
  if (in.command_radps == 0 || !in.enabled) return dt_s;
  // The command moves on until the net acceleration is more than friction holds.
  const double duty_per_rad = m.gain * in.kp;
  const double drive_per_duty = in.strength * m.stall_rad_per_s2 * in.voltage;
  way = duty_per_rad * drive_per_duty * in.command_radps < 0 ? -1 : 1;
  const double needed = drive_that_breaks(m, forces.net + load, way, load);
  const double duty = needed / drive_per_duty;
  way = needed < load ? -1 : 1;
  if (!(std::abs(needed) < m.limit_rad_per_s2) || !(std::abs(duty) < m.max_duty)) return dt_s;
  const double command_rad = state.q_rad + duty / duty_per_rad;
  const double t = (command_rad - in.command_rad) / in.command_radps;
  return std::isfinite(t) ? std::clamp(t, 0.0, dt_s) : dt_s;
}

Region region_of(const TorqueModel& m, const MotorInput& in, const MotorState& state, double load,
                 int way) {
  const Forces forces = forces_of(m, in, state, load);
  return {.duty = side_of(wanted_duty(m, in, state), m.max_duty),
          .drive = side_of(free_drive(m, in, state), m.limit_rad_per_s2),
          .net = forces.net < 0 ? -1 : 1,
          .gear = forces.gear < 0 ? -1 : 1,
          .way = way};
}

}  // namespace

double advance_motor(const TorqueModel& motor, const MotorInput& input, double dt_s,
                     MotorState& state) {
  MotorInput in = input;
  double done_s = 0;
  const auto pass = [&](double t) {
    done_s += t;
    in.command_rad = input.command_rad + input.command_radps * done_s;
  };
  int way = state.w_radps < 0 ? -1 : 1;
  const bool rested = state.w_radps == 0;
  const Pull pull = pull_at(motor, state.q_rad);
  const double load = load_at(motor, pull);
  if (rested) {
    pass(rest_for(motor, in, state, load, dt_s, way));
    if (done_s >= dt_s) return dt_s;
  }
  Region region = region_of(motor, in, state, load, way);
  for (int pieces = 0; done_s < dt_s; ++pieces) {
    const Pull pulls = pieces == 0 ? pull : pull_at(motor, state.q_rad);
    Stretch stretch(motor, in, state, pulls, region);
    const double h = stretch.reach(dt_s - done_s);
    if (pieces >= kMostPieces || !std::isfinite(h)) {
      state = {NAN, NAN};
      return dt_s;
    }
    bool stops = false;
    Region next = region;
    const double ends = stretch.end(h, next, stops);
    const bool whole = !(ends < kInfinity) && h >= dt_s - done_s;
    const double t = std::min(ends, h);
    state = stretch.at(t);
    if (whole)
      done_s = dt_s;
    else
      pass(t);
    if (stops) {
      state.w_radps = 0;
      // What breaks away by rounding alone stays.
      return rested && t == 0 && pieces == 0 ? dt_s : done_s;
    }
    region = next;
  }
  return dt_s;
}

double cogging_at(const TorqueModel& motor, double q_rad) {
  return motor.cogging_rad_per_s2 == 0
             ? 0
             : motor.cogging_rad_per_s2 * maths::sin(wave_rad(motor, q_rad));
}

HangingLoad::HangingLoad(const TorqueModel& motor)
    : motor_(motor),
      along_cos_(motor.gravity_rad_per_s2 * maths::cos(motor.level_rad)),
      along_sin_(motor.gravity_rad_per_s2 * maths::sin(motor.level_rad)),
      constant_(motor.asymmetry_rad_per_s2) {}

double drive_at_rest(const TorqueModel& motor, const MotorInput& input, const MotorState& state) {
  if (!input.enabled) return 0;
  const double duty = std::clamp(wanted_duty(motor, input, state), -motor.max_duty, motor.max_duty);
  return motor.stall_rad_per_s2 * input.voltage * duty;
}

double drive_of(const TorqueModel& motor, const MotorInput& input, const MotorState& state) {
  return std::clamp(free_drive(motor, input, state), -motor.limit_rad_per_s2,
                    motor.limit_rad_per_s2);
}

bool has_dry_friction(const TorqueModel& motor) {
  return motor.coulomb_rad_per_s2 > 0 || motor.stribeck_rad_per_s2 > 0 || motor.load_fraction > 0 ||
         motor.carried_fraction > 0;
}

double motor_acceleration(const TorqueModel& motor, const MotorInput& input,
                          const MotorState& state, double load_rad_per_s2, double rest_radps) {
  const Forces forces = forces_of(motor, input, state, load_rad_per_s2);
  const double rate = std::abs(state.w_radps);
  double dry = motor.coulomb_rad_per_s2 + motor.load_fraction * std::abs(forces.net) +
               motor.carried_fraction * std::abs(forces.gear);
  if (motor.stribeck_rad_per_s2 != 0 && motor.stribeck_rad_per_s >= kLeastStribeck_radps)
    dry += motor.stribeck_rad_per_s2 * maths::exp(-rate / motor.stribeck_rad_per_s);
  const double moving = forces.net - motor.viscous_per_s * state.w_radps;
  if (rate > rest_radps) return moving - std::copysign(dry, state.w_radps);
  return std::copysign(std::max(0.0, std::abs(moving) - dry), moving);
}

}  // namespace seam::effects
