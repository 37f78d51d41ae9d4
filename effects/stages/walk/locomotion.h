// Stage `locomotion`: from commanded to true motion of the body. The command holds between its
// changes; the velocity follows it with a lag, is scaled, and turns the body a little for each
// metre of path. A body on wheels takes it through their speeds. Constant velocities are integrated
// as exact arcs.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "effects/model.h"
#include "effects/row_columns.h"
#include "effects/stages/walk/fading_velocity.h"
#include "sim_core/body/locomotion.h"

namespace seam::effects {

// What a locomotion formula (an expression effect) reads and changes.
struct VelocitySample {
  BodyVelocity velocity;
  // Where the body is and faces, on the floor's own axes as far as these are known, and how far it
  // has gone.
  double x_m = 0, y_m = 0;
  double theta_rad = 0;
  double path_m = 0;
  double t_s = 0;  // Since the start of the run.
  RowColumns columns;
};

// A body on two wheels: what their speeds make of it, and what is wrong with them.
struct Wheels {
  bool driven = false;  // Else velocities move the body whatever its legs or wheels do.
  double metres_per_tick = 0;
  double base_m = 1;
  double left_scale = 0;
  double right_scale = 0;
  double base_scale = 0;
  double slip_s = 0;  // Share of the speed that is lost for each rad/s.
  // Shares by which wheels roll farther: for each m/s of their speed; for each m/s^2 of
  // acceleration to the side the inner one, which the outer one loses.
  double growth_s_per_m = 0;
  double inner_s2_per_m = 0;
  // The motion by which they slip, where coarse counts make another of each interval than it was.
  std::optional<BodyVelocity> slips_in;

  // What the ticks of an interval say by themselves: a velocity that holds over it.
  BodyVelocity velocity_of_ticks(double left, double right, double dt_s) const {
    return {0.5 * metres_per_tick * (left + right) / dt_s, 0,
            metres_per_tick * (right - left) / base_m / dt_s};
  }
  // Whether speeds of the body are no sums of what the parts of a command make by themselves.
  bool bend_commands() const {
    return driven && (slip_s != 0 || growth_s_per_m != 0 || inner_s2_per_m != 0);
  }
};

// Ticks since the row before, read `late_s` after the times of their rows, as they would have been
// at these times: between two readings a wheel rolls evenly. It rests before the first reading and
// goes on after the last.
std::vector<double> read_in_time(const std::vector<double>& ticks,
                                 const std::vector<double>& time_s, double late_s);

// What measurements alone know of: the point of the body that a measured pose is of, from where the
// body turns about, forward and to the left; how far to the left of the body's forward the
// tracker's own axis points; and how long after its row's time the right wheel's count is read.
struct Tracker {
  double x_m = 0, y_m = 0;
  double yaw_rad = 0;
  double right_late_s = 0;

  bool is_axle() const { return x_m == 0 && y_m == 0 && yaw_rad == 0; }
  // Where the point is, from where it was at the start of the way, on the tracker's axes there.
  Place seen(const Place& body) const;
  // How far a turn by a small angle moves it where the tracker heads so, a radian.
  std::array<double, 2> by_turn(double cosine, double sine) const {
    const auto [ahead, left] = on_own_axes(x_m, y_m);
    return {-sine * ahead - cosine * left, cosine * ahead - sine * left};
  }
  // The body's forward where the tracker heads so.
  std::array<double, 2> forward(double cosine, double sine) const;
  std::array<double, 2> on_own_axes(double ahead, double left) const;
};

// What the locomotion effects of a model add up to.
struct Locomotion {
  Wheels wheels;
  double vx_scale = 0;
  double vy_scale = 0;
  double omega_scale = 0;
  double heading_rad_per_m = 0;
  double left_excess = 0;  // By this share turns to the left are longer than those to the right.
  double tau_s = 0;
  // Random walk: independent steps in body x, y and theta, variance sigma^2 a metre of path.
  double xy_sigma = 0;
  double theta_sigma = 0;
  std::vector<ModelEffect> formulas;  // Expression effects, in order.
  Tracker tracker;
};

Locomotion locomotion_of(const Model& model);

// What a formula made of a velocity where it made no speed of it.
struct BrokenWalk {
  const EffectDefinition* formula = nullptr;  // None: all is well.
  const char* output = "";
  double value = 0;
  double t_s = 0;  // Since the start of the run.
};

struct WalkState : Place {
  BodyVelocity followed;   // The lagged command, before scales.
  double t_s = 0;          // Since the start of the run.
  BrokenWalk broken = {};  // The first that came.
  // Where the body stood and faced at the start, on the floor's own axes, and how far it had gone:
  // for formulas.
  Place from = {};
  RowColumns columns;  // For formulas, too.
};

// Walks for `dt_s` under a command that holds, without noise. Exact arcs where the velocity is
// constant, quadrature where it lags (effects/stages/walk/fading_velocity.h); with formulas, or
// where lagging wheels slip, Runge-Kutta steps whose error is below 10 micrometres.
void advance_walk(const Locomotion& walk, const BodyVelocity& command, double dt_s,
                  WalkState& state);

// Moves along the arc of a constant body velocity.
void move_along_arc(const BodyVelocity& velocity, double dt_s, double& x_m, double& y_m,
                    double& theta_rad);

}  // namespace seam::effects
