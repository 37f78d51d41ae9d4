// `ball_ranger` as sets of kind `ranges` need it: the robot of the ball-distance experiment at
// rest, the colour table of its camera, and the very detector that the behaviour calls.
#include "app/predictors/range_detector.h"

#include <algorithm>
#include <cmath>

#include "app/data_file.h"
#include "effects/stages/robots/robot_parts.h"
#include "measurement/imaging/range_detector.h"
#include "render/colour/colour_detector.h"
#include "render/colour/colour_space.h"
#include "robot_sdk/vision/ball_detector.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"
#include "sim_core/body/kinematics.h"
#include "sim_core/scenario/scenario.h"
#include "sim_core/world/robot.h"

namespace seam::app {
namespace {

constexpr const char* kBallRanger = "ball_ranger";

using measurement::Gaze;
using measurement::PixelWindow;

constexpr double kSettled_s = 2;  // By then a head has come to rest.

render::ColourTable table_of(const RobotSpec& robot, const std::string& file) {
  if (!file.empty()) return render::ColourTable::from_file(file);
  return render::ColourTable::from_config(
      ConfigNode::from_text(robot.camera.colour_table_yaml, robot.camera.colour_table_name));
}

class BallRanger final : public measurement::RangeDetector {
 public:
  explicit BallRanger(const measurement::RangeDetectorSpec& spec)
      : robot_(Scenario::from_file(data_file("scenarios/ball_distance.yaml")).robots.front()),
        colours_(table_of(robot_, spec.colour_table)),
        width_px_(spec.width_px),
        height_px_(spec.height_px) {
    robot_.pose = {};
    // The size of the colour image, and where its first pixel lies.
    const render::Detections none = render::no_detections(width_px_, height_px_);
    colours_width_px_ = none.width_px, colours_height_px_ = none.height_px;
    left_px_ = (width_px_ - 2 * colours_width_px_) / 2,
    top_px_ = (height_px_ - 2 * colours_height_px_) / 2;
  }

  Gaze gaze(const effects::Model& model, double true_m) const override {
    const effects::ModelParts parts({{robot_.id, model}});
    Robot robot(robot_, parts, RandomStream{}, 1);
    const SimTime rest = SimTime::from_s(kSettled_s);
    RobotCommand command;
    command.joints.push_back(
        {.targets = {{.joint = kTilt, .angle_rad = tilt_to_ball_rad(true_m)}}});
    robot.apply(command, SimTime(), rest);
    robot.begin_interval(SimTime(), rest);
    const Pose X_BL = camera_link_pose(robot_.body, robot.camera_joint_angles(rest));
    return {.X_WL = robot.body_pose(robot_.pose, 1) * X_BL,
            .encoder_rad = {robot.encoder(kTilt, rest), robot.encoder(kPan, rest),
                            robot.encoder(kRoll, rest)}};
  }

  std::vector<uint8_t> colours(std::span<const uint8_t> rgb) const override {
    return detect(rgb, width_px_, height_px_).bits;
  }

  PixelWindow whole(const PixelWindow& window) const override {
    // The colour table takes widths of a multiple of 8 colour pixels.
    constexpr int kStep = 8;
    const auto first = [](int px, int offset, int count) {
      return std::clamp((px - offset) / 2, 0, count - 1);
    };
    int u0 = first(window.u, left_px_, colours_width_px_);
    int u1 = first(window.u + window.width_px - 1, left_px_, colours_width_px_);
    const int v0 = first(window.v, top_px_, colours_height_px_);
    const int v1 = first(window.v + window.height_px - 1, top_px_, colours_height_px_);
    u0 = u0 / kStep * kStep, u1 = u1 / kStep * kStep + kStep - 1;
    return {left_px_ + 2 * u0, top_px_ + 2 * v0, 2 * (u1 - u0 + 1), 2 * (v1 - v0 + 1)};
  }

  void recolour(const PixelWindow& window, std::span<const uint8_t> rgb,
                std::vector<uint8_t>& colours) const override {
    const render::Detections part = detect(rgb, window.width_px, window.height_px);
    const int u0 = (window.u - left_px_) / 2, v0 = (window.v - top_px_) / 2;
    for (int v = 0; v < part.height_px; ++v) {
      std::copy_n(part.bits.begin() + static_cast<std::ptrdiff_t>(v) * part.width_px, part.width_px,
                  colours.begin() + static_cast<std::ptrdiff_t>(v0 + v) * colours_width_px_ + u0);
    }
  }

  std::optional<measurement::RangeSighting> measure(std::span<const uint8_t> colours,
                                                    const Gaze& gaze) const override {
    const sdk::HeadAngles head{static_cast<float>(gaze.encoder_rad[0]),
                               static_cast<float>(gaze.encoder_rad[1]),
                               static_cast<float>(gaze.encoder_rad[2])};
    const auto ball =
        sdk::find_ball_in_frame({colours_width_px_, colours_height_px_, colours}, width_px_,
                                height_px_, [&](float) { return head; }, {}, {});
    if (!ball) return std::nullopt;
    return measurement::RangeSighting{ball->distance_m, ball->bearing_rad};
  }

 private:
  render::Detections detect(std::span<const uint8_t> rgb, int width_px, int height_px) const {
    std::vector<uint8_t> ycrcb(rgb.size());
    render::rgb_to_ycrcb(rgb, ycrcb);
    return colours_.detect(ycrcb, width_px, height_px);
  }

  RobotSpec robot_;
  render::ColourDetector colours_;
  int width_px_, height_px_;
  int colours_width_px_ = 0, colours_height_px_ = 0;
  int left_px_ = 0, top_px_ = 0;
};

}  // namespace

double tilt_to_ball_rad(double distance_m) {
  return std::round(-1e4 * maths::atan2(0.19, distance_m - 0.12)) * 1e-4;
}

measurement::MakeRangeDetector sdk_detectors() {
  return [](const measurement::RangeDetectorSpec& spec)
             -> std::unique_ptr<measurement::RangeDetector> {
    if (spec.name != kBallRanger) return nullptr;
    return std::make_unique<BallRanger>(spec);
  };
}

std::vector<std::string> sdk_detector_names() {
  return {kBallRanger};
}

}  // namespace seam::app
