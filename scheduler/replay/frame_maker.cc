#include "scheduler/replay/frame_maker.h"

#include <algorithm>

namespace seam::scheduler {

Clock camera_clock(const Scenario& scenario, int robot) {
  const RobotSpec& spec = scenario.robots[static_cast<size_t>(robot)];
  return Clock(clock_settings(spec.camera), camera_stream(scenario, spec).child("clock"));
}

void make_frames(Rewinder& rewinder, FrameRenderer& renderer, int robot, SimTime from, SimTime to,
                 const std::function<void(const FinishedFrame&)>& visit) {
  const Clock clock = camera_clock(rewinder.world().scenario(), robot);
  const int64_t first = clock.first_at_or_after(from);
  const int64_t past_last = clock.first_at_or_after(to + SimDuration::from_ns(1));
  if (past_last <= first) return;
  // A frame whose lower rows are exposed first begins before its stamp.
  const int64_t before = std::max<int64_t>(0, first - 2);
  const SimTime start = std::max(SimTime(), clock.tick(before));

  EventQueue queue;
  FramePipeline pipeline(rewinder.world(), renderer, queue, true,
                         [&](const FinishedFrame& frame) { visit(frame); });
  FrameRequest request;
  request.after = clock.tick(first);
  request.count = static_cast<uint32_t>(past_last - first);
  rewinder.to(start);
  pipeline.request(robot, request, start);
  while (!queue.empty()) {
    const EventKey key = queue.pop();
    if (rewinder.to(key.time) < key.time) break;  // The log ends before the frame does.
    if (key.phase == Phase::sample_light) {
      pipeline.sample(robot, key);
    } else {
      pipeline.finish(robot, key);
    }
  }
  pipeline.collect_all();
}

}  // namespace seam::scheduler
