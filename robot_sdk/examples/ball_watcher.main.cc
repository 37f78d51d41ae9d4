// Keeps the ball centred: the founding paper's "active sensing" in its simplest form.
#include <cmath>

#include "robot_sdk/robot.h"

namespace {

struct Spot {
  double u_px = 0, v_px = 0, area_px = 0;
};

// The centre of the orange pixels: much red, some green, little blue.
Spot find_orange(const seam::sdk::Frame& frame) {
  Spot spot;
  for (int v = 0; v < frame.height_px; ++v)
    for (int u = 0; u < frame.width_px; ++u) {
      const int red = frame.red(u, v), green = frame.green(u, v), blue = frame.blue(u, v);
      if (red < 80 || 10 * green > 7 * red || 2 * green < red / 2 || 3 * blue > red) continue;
      spot.u_px += u;
      spot.v_px += v;
      spot.area_px += 1;
    }
  if (spot.area_px > 0) {
    spot.u_px /= spot.area_px;
    spot.v_px /= spot.area_px;
  }
  return spot;
}

}  // namespace

int main(int argc, char** argv) {
  constexpr double kFocal_px = 162, kGain = 0.5;
  seam::sdk::Robot robot(argc, argv);
  double tilt_rad = 0, pan_rad = 0, last_seen_s = 0;
  robot.request_all_frames();
  robot.on_observation([&](const seam::sdk::Observation& seen) {
    for (const auto& frame : seen.frames) {
      const Spot ball = find_orange(frame);
      if (ball.area_px < 6) continue;
      pan_rad -= kGain * std::atan((ball.u_px - 0.5 * frame.width_px) / kFocal_px);
      tilt_rad -= kGain * std::atan((ball.v_px - 0.5 * frame.height_px) / kFocal_px);
      last_seen_s = seen.time_s();
      robot.log_value("ball_area_px", ball.area_px);
    }
    if (seen.time_s() - last_seen_s > 0.5) {  // Lost: look around.
      pan_rad = std::sin(2 * seen.time_s());
      tilt_rad = -0.3 + 0.2 * std::sin(0.7 * seen.time_s());
    }
    pan_rad = std::fmin(1.5, std::fmax(-1.5, pan_rad));
    tilt_rad = std::fmin(0.7, std::fmax(-1.3, tilt_rad));
    robot.head({.tilt_rad = tilt_rad, .pan_rad = pan_rad});
  });
  return robot.run();
}
