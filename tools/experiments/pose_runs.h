// Runs of the SDK's `localizer` at the paper's poses: how frames are clocked, with which camera.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/experiments/runs.h"

namespace seam::tools {

// The head swings as amplitude * sin(2 pi t / period). The period is no multiple of the camera's
// 40 ms, nor of a simple fraction of it, so that frames on the camera's own clock drift through the
// swing; a locked camera takes a whole number of frames in each swing.
inline constexpr double kSwingPeriod_s = 4.0373;
inline constexpr double kSwingAmplitude_rad = 1.5;

struct PoseMode {
  std::string model_yaml;      // Empty: the scenario's own.
  bool locked = false;         // Frames locked to the swing; else the camera's own clock.
  int frames_per_swing = 0;    // 0: as many as come nearest to the camera's 25 frames/s.
  bool row_times = true;       // Whether the client takes the head's angle at each row's own time.
  int particles = 1000;
  double sensor_width = 1;     // Scales the sensor model's widths.
  double duration_s = 30;
};

// The first `count` of 9 positions (x = 0, 1000, 1750; y = 0, 500, 1000 mm) x 4 headings (+-45,
// +-135 deg), taken across positions first when there are fewer than 36.
std::vector<Pose2> paper_poses(int count);

PlannedRun pose_run(const std::string& mode_name, const PoseMode& mode, const Pose2& pose, int seed);

struct PoseResult {
  Pose2 truth;
  Pose2 mean, low, high;  // The estimate after the whole run; low and high bound the division.
  // Means of the estimates of the second half of the run, once localisation has settled, and their
  // spread.
  Pose2 settled;
  double settled_spread_m = 0;
};
PoseResult read_pose_run(const std::filesystem::path& folder, const std::string& mode_name, const Pose2& pose, int seed);

}  // namespace seam::tools
