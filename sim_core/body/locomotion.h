// How a robot's body follows its walk command.
#pragma once

#include <memory>

#include "sim_core/base/time.h"
#include "sim_core/body/state.h"

namespace seam {

// In the body's frame: forward, left, counter-clockwise.
struct BodyVelocity {
  double vx_mps = 0;
  double vy_mps = 0;
  double omega_radps = 0;

  bool operator==(const BodyVelocity&) const = default;
  void visit(StateVisitor& visitor) {
    visitor.field("vx_mps", vx_mps);
    visitor.field("vy_mps", vy_mps);
    visitor.field("omega_radps", omega_radps);
  }
};

// Called once for each physics step, in order, without gaps; holds the state (lag) between calls.
class LocomotionModel {
 public:
  virtual ~LocomotionModel() = default;
  // The true mean velocity over [start, start + step] while the command holds. Random parts are
  // drawn at an index that follows from `start`, so that they do not depend on history.
  virtual BodyVelocity velocity(const BodyVelocity& command, SimTime start, SimDuration step) = 0;
  virtual void visit(StateVisitor& visitor) = 0;
};

// The body moves as commanded.
class IdealLocomotion final : public LocomotionModel {
 public:
  BodyVelocity velocity(const BodyVelocity& command, SimTime, SimDuration) override {
    return command;
  }
  void visit(StateVisitor&) override {}
};

}  // namespace seam
