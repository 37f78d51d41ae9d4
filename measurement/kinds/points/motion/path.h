// The path of a camera before a target in a video: cubic B-splines over rotation and place, one for
// each stretch of frames without a gap. Docs: docs/design/engine.md, "Paths".
#pragma once

#include <Eigen/Core>
#include <vector>

#include "measurement/gyro/read_turns.h"
#include "sim_core/base/pose.h"

namespace seam::measurement {

// A stretch of frames: so many controls from this one on, the first of which acts from `from_s`.
struct Stretch {
  double from_s = 0, step_s = 1;  // Seconds since the reference; from knot to knot.
  int degree = 3;                 // Fewer frames than a cubic needs have a lower degree.
  size_t first = 0, controls = 0;
  double exposure_s = 0;  // Of a frame by itself, where it is known.
};

// Which frames make a stretch, and how many controls each has. Frames further apart than the
// longest gap begin a new one.
class PathLayout {
 public:
  // Stamps of the frames that take part, in seconds; frames by number.
  PathLayout(const std::vector<double>& stamp_s, const std::vector<char>& takes_part,
             double knot_s);
  // Each frame by itself with a velocity of its own. Exposures by frame, or none.
  static PathLayout alone(const std::vector<double>& stamp_s, const std::vector<char>& takes_part,
                          double step_s, const std::vector<double>& exposure_s = {});

  size_t controls() const { return controls_; }
  const std::vector<Stretch>& stretches() const { return stretches_; }
  const Stretch& of_frame(size_t frame) const { return stretches_[stretch_of(frame)]; }
  size_t stretch_of(size_t frame) const { return static_cast<size_t>(stretch_of_frame_[frame]); }
  bool takes_part(size_t frame) const { return stretch_of_frame_[frame] >= 0; }

 private:
  PathLayout() = default;

  std::vector<Stretch> stretches_;
  std::vector<int> stretch_of_frame_;
  size_t controls_ = 0;
};

// Weights of the controls that act at an instant, and their derivatives by time.
struct ControlWeights {
  size_t first = 0;
  int count = 1;
  double weight[4] = {1, 0, 0, 0}, rate[4] = {0, 0, 0, 0};
};
ControlWeights weights_at(const Stretch& stretch, double t_s);

struct Control {
  Eigen::Vector4d q{1, 0, 0, 0};  // w, x, y, z of the rotation from target to camera.
  Vec3 middle_C{0.0};             // The target's middle.
};

// Where the camera is at an instant, and how that follows from the controls.
struct PathPoint {
  ControlWeights weights;
  Mat3 R{1.0};
  Vec3 middle_C{0.0};
  Vec3 turning{0.0}, moving{0.0};  // Per second, in the camera's axes.
  Eigen::Matrix3d turn_by_control[4];
  Eigen::Matrix3d shift_by_shift = Eigen::Matrix3d::Identity();  // Over the control's weight.
};
PathPoint path_at(const Stretch& stretch, const std::vector<Control>& controls, double t_s,
                  bool with_slopes);

// The same of a frame by itself, which turns as a gyroscope says: the first control has the
// rotation, and both have a place, in the camera's axes when the stretch begins.
PathPoint turning_path_at(const ReadTurns& turns, const Stretch& stretch,
                          const std::vector<Control>& controls, double t_s, bool with_slopes);

// Controls among the nuisances of an evaluation: they are the last of these, each so many numbers.
constexpr size_t kControlNumbers = 7;
void store_controls(const std::vector<Control>& controls, std::vector<double>& values);
// As many as the given ones.
void stored_controls(const std::vector<double>& values, std::vector<Control>& controls);

// A control turned about the camera's axes by the first three numbers and shifted by the others.
Control moved_control(const Control& control, const Eigen::Matrix<double, 6, 1>& by);

// The path nearest to poses of each frame (`X_CW` by frame, those not found have `known` 0).
std::vector<Control> path_through(const PathLayout& layout, const std::vector<double>& stamp_s,
                                  const std::vector<Pose>& X_CW, const std::vector<char>& known,
                                  const Vec3& middle_W);

}  // namespace seam::measurement
