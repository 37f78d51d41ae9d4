// Frame jobs of a match for the benchmarks: a robot swings its head before four others that walk.
#pragma once

#include <fmt/format.h>

#include <string>
#include <vector>

#include "effects/model.h"
#include "effects/stages/geometry.h"
#include "effects/stages/row_schedule.h"
#include "sim_core/scene/frame.h"
#include "sim_core/world/world.h"

namespace seam::bench {

inline Scenario match_scenario() {
  const std::string models = std::string(SEAM_SOURCE_DIR) + "/models/";
  std::string yaml =
      "format: seam-scenario/1\nname: bench\nduration_s: 100\nfield: '" + models +
      "field_2002.yaml'\nball: {x_m: 0.2, y_m: 0.1, vx_mps: 0.4, vy_mps: 0.6}\nrobots:\n";
  const auto robot = [&](const char* id, const char* team, double x, double y, double theta) {
    yaml += fmt::format(
        "  - {{id: {}, team: {}, pose: {{x_m: {}, y_m: {}, theta_rad: {}}}, body: "
        "'{}robot_ers210.yaml'}}\n",
        id, team, x, y, theta, models);
  };
  robot("viewer", "red", -0.9, 0.0, 0.1);
  robot("a", "blue", 0.1, 0.35, 2.0);
  robot("b", "blue", 0.5, -0.3, 3.0);
  robot("c", "red", 0.0, -0.2, 0.5);
  robot("d", "blue", 1.2, 0.2, 2.5);
  return Scenario::from_text(yaml, "bench match");
}

// Frames, 40 ms apart, of the viewer's camera, and the world whose robots they show.
struct MatchJobs {
  World world{match_scenario()};
  std::vector<FrameJob> jobs;
};

inline MatchJobs match_jobs(const effects::Model& model, int height_px, int instants_per_row,
                            int count) {
  MatchJobs match;
  World& world = match.world;
  for (size_t robot = 1; robot < 5; ++robot) {
    RobotCommand walk;
    walk.walk = BodyVelocity{0.2, robot % 2 ? 0.05 : -0.05, robot % 2 ? 0.4 : -0.3};
    world.apply(robot, walk, SimTime());
  }
  const Pose X_LC = effects::mount_of(model);
  std::vector<FrameJob>& jobs = match.jobs;
  jobs.resize(count);
  struct Sample {
    SimTime time;
    FrameJob* job;
  };
  std::vector<Sample> samples;
  for (int i = 0; i < count; ++i) {
    FrameJob& job = jobs[i];
    job.robot = "viewer";
    job.frame_index = static_cast<uint64_t>(i);
    job.stamp = SimTime::from_ns(500'000'000 + i * 40'000'000LL);
    job.schedule = effects::make_row_schedule(effects::timing_of(model), job.stamp, height_px,
                                              {.instants_per_row = instants_per_row});
    job.scenery = world.scenery();
    job.background = world.background();
    job.lighting = world.lighting();
    job.camera_noise = {.seed = 1, .stream = 2};
    job.frame_noise = job.camera_noise.child("frame").child(job.frame_index);
    for (const SimTime time : job.schedule.instants) samples.push_back({time, &job});
  }
  std::stable_sort(samples.begin(), samples.end(),
                   [](const Sample& a, const Sample& b) { return a.time < b.time; });
  int swing = 0;
  for (const Sample& sample : samples) {
    while (world.end() < sample.time) {
      if (++swing % 60 == 1) {
        RobotCommand look;
        look.joints.push_back(
            {.targets = {{.joint = kPan, .angle_rad = swing % 120 == 1 ? 0.6 : -0.6},
                         {.joint = kTilt, .angle_rad = -0.15}}});
        world.apply(0, look, world.end());
      }
      world.step();
    }
    sample.job->instants.push_back(world.view_of(0, sample.time, X_LC));
  }
  return match;
}

}  // namespace seam::bench
