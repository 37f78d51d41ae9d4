// Motion in the plane: ball and robots against each other and the field, by Box2D.
//
// Exact resuming: the Box2D world is built anew from the state at the start of each world step, in
// a fixed order, with warm starting off, so that nothing hidden in it outlives a step.
//
// Assumptions: the ball rolls on the ground with constant deceleration and bounces without
// friction; walls are vertical at the foot of their slope; robots stay upright (no falls).
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "sim_core/body/state.h"
#include "sim_core/scenario/scenario.h"

namespace seam {

struct PlanarBody {
  double x_m = 0, y_m = 0, theta_rad = 0;
  double vx_mps = 0, vy_mps = 0, omega_radps = 0;
  bool solid = true;  // False: collides with nothing.

  void visit(StateVisitor& visitor);
};

// A paw or head near the ball: a disc that moves as its robot moves it, and moves the ball only.
struct Limb {
  size_t robot = 0;
  double x_m = 0, y_m = 0;
  double vx_mps = 0, vy_mps = 0;
  double radius_m = 0;
};

struct PhysicsState {
  std::vector<PlanarBody> robots;  // At the body's origin.
  PlanarBody ball;
  std::vector<Limb> limbs;
};

// Who touched the ball: a robot's index.
struct BallContact {
  size_t robot = 0;
  double impulse_ns = 0;  // Newton seconds.
};

class Physics {
 public:
  explicit Physics(const Scenario& scenario);
  ~Physics();
  Physics(Physics&&) noexcept;

  struct Hooks {
    // Sets the velocities wanted for substep k, before it; bodies it leaves alone coast.
    std::function<void(int64_t k, PhysicsState& state)> before;
    // After substep k.
    std::function<void(int64_t k, const PhysicsState& state)> after;
  };
  // Substeps of `h_s` seconds; `limbs` are taken as they are at the start.
  void advance(PhysicsState& state, double h_s, int64_t substeps, const Hooks& hooks);
  // Contacts of robots with the ball during the last `advance`, in their order.
  const std::vector<BallContact>& ball_contacts() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace seam
