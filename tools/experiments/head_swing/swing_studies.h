// The parts of `seam experiment head-swing-bias`: how the bias depends on the ratio of frame period
// to swing period, on phase, on drift, on the shutter, and what is left without any lock.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "sim_core/base/maths.h"
#include "tools/experiments/head_swing/swing_runs.h"

namespace seam::tools {

inline constexpr double kHalfView_rad =
    0.5 * 57.6 * maths::kPi / 180;  // The paper's angle of view.
// At the camera's rate: studies that look at the same runs share them.
inline constexpr int kFramesASwing = 25;

// How much is done: the quick form shows that it works, the short one has 3 seeds, the full one 20.
struct StudySize {
  std::vector<Pose2> poses;
  int seeds = 1;
  double duration_s = 30;
  bool quick = false;
};

// A study plans its runs, then, once all are made, writes tables and plots and prints its results.
class SwingStudy {
 public:
  virtual ~SwingStudy() = default;
  virtual void plan(SwingRuns& runs) const = 0;
  virtual nlohmann::json report(const SwingRuns& runs,
                                const std::filesystem::path& folder) const = 0;
};

// Frames at 25 a second, locked to the swing or on the camera's own clock.
SwingMode camera_rate(const StudySize& size, bool locked);

// A protocol of the swing for `seam measure`, and a model of each mode's camera, to use with it.
void write_swing_protocol(const std::filesystem::path& folder);

std::unique_ptr<SwingStudy> ratio_study(const StudySize& size);
std::unique_ptr<SwingStudy> phase_and_drift_study(const StudySize& size);
std::unique_ptr<SwingStudy> shutter_study(const StudySize& size);
std::unique_ptr<SwingStudy> remainder_study(const StudySize& size);

}  // namespace seam::tools
