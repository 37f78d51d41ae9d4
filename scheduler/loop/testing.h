// What tests and benchmarks of the loop share: scenarios in memory, a renderer without images.
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <string>
#include <thread>

#include "scheduler/loop/frame_renderer.h"
#include "scheduler/loop/simulation.h"
#include "sim_core/base/hash.h"

namespace seam::scheduler::testing {

// `robots` robots on the field; each camera and behaviour with a phase of its own.
inline std::string scenario_text(const std::string& source_dir, int robots, double duration_s,
                                 int behaviour_ms = 32, const std::string& behaviour_extra = "") {
  std::string yaml = fmt::format(
      "format: seam-scenario/1\nname: test\nduration_s: {}\nseed: 7\n"
      "field: {}/models/field_2002.yaml\nball: {{x_m: 0.3, y_m: 0.1, vx_mps: 0.5}}\nrobots:\n",
      duration_s, source_dir);
  for (int i = 0; i < robots; ++i)
    yaml += fmt::format(
        "  - id: r{0}\n    team: {1}\n    pose: {{x_m: {2}, y_m: {3}, theta_rad: 0.3}}\n"
        "    body: {4}/models/robot_ers210.yaml\n"
        "    camera: {{width_px: 8, height_px: 8, clock: {{period_s: 0.04, phase_s: {5}}}}}\n"
        "    behaviour: {{clock: {{period_s: {6}}}{7}}}\n",
        i, i % 2 == 0 ? "red" : "blue", -1.8 + 0.5 * (i % 8), 0.8 - 0.6 * (i / 8), source_dir,
        0.003 * i, 0.001 * behaviour_ms, behaviour_extra);
  return yaml;
}

// Its "image" is a hash of the job: it changes whenever anything that a renderer gets changes.
class HashRenderer final : public FrameRenderer {
 public:
  explicit HashRenderer(const Scenario& scenario, int workers = 1, bool dawdle = false)
      : scenario_(scenario), workers_(workers), dawdle_(dawdle) {}

  int workers() const override { return workers_; }
  Pose mount(int) const override { return rotation(link_to_camera_axes()); }
  RowSchedule schedule(int robot, uint64_t, SimTime stamp) override {
    RowSchedule schedule;
    const int64_t rows = scenario_.robots[robot].camera.height_px;
    for (int64_t r = 0; r < rows; ++r) {
      const SimTime start = stamp + SimDuration::from_ns(r * 4'000'000);
      schedule.rows.push_back({start, start + SimDuration::from_ns(5'000'000)});
      schedule.instants.push_back(start + SimDuration::from_ns(2'500'000));
      schedule.first_instant.push_back(static_cast<int>(r));
      schedule.weights.push_back({1.0});
    }
    return schedule;
  }
  Frame render(int, const FrameJob& job, int) override {
    if (dawdle_)  // Frames then end in another order than they began.
      std::this_thread::sleep_for(std::chrono::microseconds(300 * (job.frame_index % 3)));
    Hasher hasher;
    for (const SceneInstant& instant : job.instants) {
      hasher.add(instant.time.ns());
      for (int k = 0; k < 3; ++k) hasher.add(instant.X_WC.p[k]);
      for (const Primitive& primitive : all_primitives(job, instant))
        for (int k = 0; k < 3; ++k) hasher.add(primitive.X_WO.p[k]);
    }
    Frame frame{.robot = job.robot,
                .frame_index = job.frame_index,
                .stamp = job.stamp,
                .width_px = 1,
                .height_px = 1,
                .rows = job.schedule.rows};
    frame.fingerprint = hasher.digest();
    frame.rgb = {1, 2, 3};
    return frame;
  }

 private:
  const Scenario& scenario_;
  int workers_;
  bool dawdle_;
};

}  // namespace seam::scheduler::testing
