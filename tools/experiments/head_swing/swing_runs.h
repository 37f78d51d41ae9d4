// Runs of the localizer under many clocks, planned together, made once, and read back.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "effects/stages/timing.h"
#include "tools/experiments/experiments.h"
#include "tools/experiments/head_swing/swing_theory.h"
#include "tools/experiments/pose_runs.h"

namespace seam::tools {

inline constexpr Swing kSwing{.amplitude_rad = kSwingAmplitude_rad, .period_s = kSwingPeriod_s};

struct SwingMode {
  std::string name;  // Part of each run's name.
  PoseMode mode;
};

// One beacon seen in one frame, beside the truth.
struct Sighting {
  double time_s = 0;  // When the row of the sighting was exposed.
  int landmark = 0;
  double bearing_error_rad = 0;
  double range_error = 0;     // Relative; NaN where the range is unknown.
  double pan_rad = 0;         // Of the head then, as its encoder said.
  double pan_rate_radps = 0;  // Of the swing as it was commanded.
  double row_middle_s = 0;    // From the frame's stamp to that row's middle of exposure.
};

struct SwingRun {
  double dx_mm = 0, dy_mm = 0;  // Mean of the settled estimates minus the truth.
  double bias_mm = 0;           // Its length.
  double spread_mm = 0;         // Of the settled estimates about their mean.
  double width_mm = 0;          // Of the division at the end, mean of x and y.
  bool truth_inside = false;    // In x and in y.
  std::vector<Sighting> sightings;
};

struct Landmark {
  double x_m, y_m;
};
inline constexpr int kBeacons = 6;
// The field's beacons, in the order of the SDK's LandmarkKind.
inline constexpr Landmark kBeaconPlaces[kBeacons] = {{-2.2, 1.45}, {-2.2, -1.45}, {2.2, 1.45},
                                                     {2.2, -1.45}, {0, 1.45},     {0, -1.45}};

class SwingRuns {
 public:
  explicit SwingRuns(const ExperimentOptions& options);

  // Plans the mode's runs at each pose, for seeds 1 to `seeds`; a run planned twice is made once.
  // Runs are made seed by seed, so that an interrupted study has whole pairs.
  void plan(const SwingMode& mode, const std::vector<Pose2>& poses, int seeds);
  void make() const;

  SwingRun read(const SwingMode& mode, const Pose2& pose, int seed) const;
  // All of them, seed by seed.
  std::vector<SwingRun> read_all(const SwingMode& mode, const std::vector<Pose2>& poses,
                                 int seeds) const;

 private:
  const ExperimentOptions& options_;
  std::map<int, std::vector<PlannedRun>> planned_;  // By seed.
  std::map<std::string, bool> names_;
};

}  // namespace seam::tools
