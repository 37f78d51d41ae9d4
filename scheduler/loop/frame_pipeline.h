// From requests for frames to finished frames: which ticks of a camera's clock are captured, at
// which instants light is sampled for them, and the images, made on other threads meanwhile.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "scheduler/loop/clock.h"
#include "scheduler/loop/event_queue.h"
#include "scheduler/loop/exchange.h"
#include "scheduler/loop/render_pool.h"
#include "sim_core/world/world.h"

namespace seam::scheduler {

struct FinishedFrame {
  int robot = 0;
  SimTime time;  // When its last row had ended.
  std::unique_ptr<const FrameJob> job;
  std::shared_ptr<const Frame> frame;
};

class FramePipeline {
 public:
  // Frames come out in the order of their finish events through `on_finished`, on the loop's
  // thread, at moments that follow from simulated time alone.
  FramePipeline(const World& world, FrameRenderer& renderer, EventQueue& queue, bool camera_at_rows,
                std::function<void(FinishedFrame)> on_finished);

  void request(int robot, const FrameRequest& request, SimTime now);
  // The events of phase sample_light and finish_frames with source 1 + robot.
  void sample(int robot, const EventKey& key);
  void finish(int robot, const EventKey& key);
  // Hands over all frames up to and including the robot's last finished one.
  void collect(int robot);
  void collect_all();

 private:
  struct Sample {
    SimTime time;
    int instant = -1;  // Number of the light-sampling instant, or
    int row = -1;      // of the row whose middle this is.
  };
  struct InProgress {
    uint64_t event = 0;  // Sequence number of its next event.
    std::unique_ptr<FrameJob> job;
    std::vector<Sample> samples;
    size_t next = 0;
    SimTime end;  // Of its last row.
    bool begun = false;
  };
  struct Camera {
    Clock clock;
    RandomStream noise;
    Pose X_LC;
    bool all = false;
    std::vector<FrameRequest> requests;
    int64_t next_tick = 0;
    bool armed = false;  // The next frame is scheduled and its first event has not come.
    std::vector<InProgress> in_progress;
    uint64_t events = 0;
    size_t uncollected = 0;
  };
  struct Pending {
    int robot;
    SimTime time;
    std::unique_ptr<const FrameJob> job;
    std::future<Frame> frame;
  };

  bool wanted(const Camera& camera, SimTime stamp) const;
  void arm(int robot, SimTime now);
  InProgress begin(int robot, int64_t tick, SimTime stamp, RowSchedule schedule) const;
  void push_next(int robot, InProgress& frame);
  void record(int robot, InProgress& frame, const Sample& sample);
  void collect_first();

  const World& world_;
  FrameRenderer& renderer_;
  EventQueue& queue_;
  bool camera_at_rows_;
  std::function<void(FinishedFrame)> on_finished_;
  std::vector<Camera> cameras_;
  std::deque<Pending> pending_;
  RenderPool pool_;  // Last: its threads end before the jobs go.
};

}  // namespace seam::scheduler
