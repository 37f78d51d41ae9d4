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
  std::string model_yaml;    // Empty: the scenario's own.
  bool locked = false;       // Frames locked to the swing; else the camera's own clock.
  int frames_per_swing = 0;  // 0: as many as come nearest to the camera's 25 frames/s.
  // On the camera's own clock with a given number of frames a swing: what it takes beyond the whole
  // number, so that each swing shows other angles than the one before. By default the golden
  // section, which fills the gaps most evenly.
  double slip = 0.381966;
  double phase = -1;  // Of the first frame in a frame period; negative: drawn by pose and seed.
  bool use_ranges = true;  // Whether localisation uses ranges, or bearings alone.
  bool row_times = true;   // Whether the client takes the head's angle at each row's own time.
  int particles = 1000;
  double sensor_width = 1;  // Scales the sensor model's widths.
  double duration_s = 30;
};

inline constexpr double kFramePeriod_s = 0.04;  // Of the real camera.

// Frames in one swing of the head at the camera's own rate, to the nearest whole number.
int nearest_frames_per_swing();

// The first `count` of 9 positions (x = 0, 1000, 1750; y = 0, 500, 1000 mm) x 4 headings (+-45,
// +-135 deg), taken across positions first when there are fewer than 36.
std::vector<Pose2> paper_poses(int count);

PlannedRun pose_run(const std::string& mode_name, const PoseMode& mode, const Pose2& pose,
                    int seed);

struct PoseResult {
  Pose2 truth;
  Pose2 mean, low, high;  // The estimate after the whole run; low and high bound the division.
  // Means of the estimates of the second half of the run, once localisation has settled, and their
  // spread.
  Pose2 settled;
  double settled_spread_m = 0;
};
PoseResult pose_result(const LoggedValues& values, const std::string& run, const Pose2& truth);
PoseResult read_pose_run(const std::filesystem::path& folder, const std::string& mode_name,
                         const Pose2& pose, int seed);

}  // namespace seam::tools
