// Stands still, turns its head from side to side and localises on what its camera shows: the
// experiment of section 5.2 of the founding paper. Logs the estimate with every frame.
// `localizer [--seed N] [--swing-period-s T] [--amplitude RAD] [--tilt RAD] [--particles N]
//            [--sensor-width W] [--row-times 0|1] [--ranges 0|1]`
#include <cmath>
#include <cstdlib>
#include <string>

#include "robot_sdk/robot.h"
#include "robot_sdk/team/perception.h"

using namespace seam::sdk;

// Turns the head along amplitude * sin(2 pi t / period), straight between the joint frames of 8 ms
// that the robot takes, until the next decision.
void swing(Robot& robot, double time_s, double amplitude_rad, double period_s, double tilt_rad) {
  constexpr int kJointFrames = 4;
  constexpr double kJointFrame_s = 0.008;
  const auto pan_rad = [&](double t_s) {
    // In single precision the sine has the same bits on every machine.
    return amplitude_rad * std::sin(static_cast<float>(2 * 3.14159265358979 * t_s / period_s));
  };
  for (int i = 0; i < kJointFrames; ++i) {
    const double from = pan_rad(time_s + i * kJointFrame_s),
                 to = pan_rad(time_s + (i + 1) * kJointFrame_s);
    robot.joints(
        {{.joint = kTilt, .angle_rad = tilt_rad},
         {.joint = kPan, .angle_rad = to, .max_speed_rad_s = std::abs(to - from) / kJointFrame_s}},
        i * 8'000'000);
  }
}

int main(int argc, char** argv) {
  uint64_t seed = 1;
  double period_s = 4, amplitude_rad = 1.5, tilt_rad = 0, sensor_width = 1;
  int particles = 1000;
  bool ranges = true;  // Else bearings alone are used.
  PerceptionOptions options;
  for (int i = 1; i + 1 < argc; ++i) {
    const std::string option = argv[i];
    const char* value = argv[i + 1];
    if (option == "--seed") seed = std::strtoull(value, nullptr, 10);
    if (option == "--swing-period-s") period_s = std::atof(value);
    if (option == "--amplitude") amplitude_rad = std::atof(value);
    if (option == "--tilt") tilt_rad = std::atof(value);
    if (option == "--particles") particles = std::atoi(value);
    if (option == "--sensor-width") sensor_width = std::atof(value);
    if (option == "--ranges") ranges = std::atoi(value) != 0;
    if (option == "--row-times") options.row_times = std::atoi(value) != 0;
  }
  ParticleFilterOptions filter_options{.particles = particles, .seed = seed};
  filter_options.bearing_floor_rad *= static_cast<float>(sensor_width);
  filter_options.range_floor_fraction *= static_cast<float>(sensor_width);
  ParticleFilter filter(filter_options, standard_landmarks());
  Perception perception(options);
  Robot robot(argc, argv);

  robot.request_all_frames();
  robot.on_observation([&](const Observation& seen) {
    const Percepts percepts = perception.look(seen);
    if (percepts.has_frame) {
      filter.move(0, 0, 0);
      std::vector<LandmarkSighting> used = percepts.landmarks;
      if (!ranges) {
        for (LandmarkSighting& sighting : used) sighting.range_m = 0;
      }
      filter.observe(used);
      for (const LandmarkSighting& sighting : percepts.landmarks) {
        const std::string name = "landmark" + std::to_string(static_cast<int>(sighting.kind));
        robot.log_value(name + ".bearing_rad", sighting.bearing_rad);
        robot.log_value(name + ".range_m", sighting.range_m);
        const int64_t time_ns = perception.row_time_ns(seen.frames.back(), sighting.row);
        robot.log_value(name + ".row", sighting.row);
        robot.log_value(name + ".row_time_s", 1e-9 * static_cast<double>(time_ns));
        robot.log_value(name + ".pan_rad", perception.head_at(time_ns).pan_rad);
      }
      const PoseEstimate estimate = filter.estimate();
      robot.log_value("x_m", estimate.mean.x_m);
      robot.log_value("y_m", estimate.mean.y_m);
      robot.log_value("theta_rad", estimate.mean.theta_rad);
      robot.log_value("low.x_m", estimate.low.x_m);
      robot.log_value("low.y_m", estimate.low.y_m);
      robot.log_value("low.theta_rad", estimate.low.theta_rad);
      robot.log_value("high.x_m", estimate.high.x_m);
      robot.log_value("high.y_m", estimate.high.y_m);
      robot.log_value("high.theta_rad", estimate.high.theta_rad);
    }
    swing(robot, seen.time_s(), amplitude_rad, period_s, tilt_rad);
  });
  return robot.run();
}
