// What a formula of stage `joint` (an expression effect) reads: one instant of one joint.
#pragma once

#include <span>
#include <string_view>

namespace seam::effects {

struct JointSample {
  double q_rad = 0;        // The angle after the catalogue's effects.
  double rate_radps = 0;   // Its rate of change.
  double command_rad = 0;  // The command in force; the logged angle where there is no command.
  double t_s = 0;          // Since the start of the run (servo logs) or of the encoder log.
  // The values of the definition's `columns` (load_nm, voltage_v, ...), in that order.
  std::span<const double> columns;
};

}  // namespace seam::effects
