// A run of a body that walks or drives.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "effects/row_columns.h"
#include "measurement/kinds/odometry/rolled_way.h"
#include "sim_core/body/locomotion.h"

namespace seam::measurement {

inline constexpr std::array<const char*, 3> kPoseColumns = {"x_m", "y_m", "theta_rad"};
inline constexpr std::array<const char*, 3> kCommandColumns = {"vx_cmd_mps", "vy_cmd_mps",
                                                               "omega_cmd_radps"};
inline constexpr std::array<const char*, 2> kTickColumns = {"left_ticks", "right_ticks"};

using WalkPose = std::array<double, 3>;  // x_m, y_m, theta_rad.

struct WalkRun {
  std::string name;
  std::vector<size_t> rows;    // In the file.
  std::vector<double> time_s;  // Since the run's first row.
  // Until the next row; empty where ticks were counted.
  std::vector<BodyVelocity> command;
  // Of the left and the right wheel since the row before.
  std::vector<std::array<double, 2>> ticks;
  // Of the left and the right wheel, as they may have rolled that counted so; empty where ticks are
  // no counts.
  std::vector<RolledWay> ways;
  // The same as ticks in the mean of these ways.
  std::vector<std::array<double, 2>> rolled_ticks;
  // By whose turning wheels slip.
  std::vector<std::array<double, 2>> slip_ticks;
  std::vector<WalkPose> pose;  // Measured; NaN where blank.
  // By row of the file: they hold until the next one. Of all runs alike; null: none.
  std::shared_ptr<const effects::FurtherColumns> further;
};

}  // namespace seam::measurement
