// Frames of a run that repeats a log, without the pixels that nobody looks at.
#pragma once

#include <map>
#include <set>
#include <utility>

#include "scheduler/log/log.h"
#include "scheduler/loop/frame_renderer.h"
#include "scheduler/replay/player.h"

namespace seam::app {

// Which frames are drawn though no client sees them.
enum class UnseenFrames : uint8_t {
  // Those of which the log's fingerprint may be another: the run's log can be verified.
  when_changed,
  // None: a frame that the log does not have has the fingerprint 0.
  never,
};

class FramesOfLog final : public scheduler::FrameRenderer {
 public:
  // `seen`: robots whose clients get their frames. `report` is the run's; all outlive it.
  FramesOfLog(scheduler::FrameRenderer& renderer, const scheduler::Log& log, std::set<int> seen,
              UnseenFrames unseen, const scheduler::MixedReport& report);

  int workers() const override { return renderer_.workers(); }
  RowSchedule schedule(int robot, uint64_t frame_index, SimTime stamp) override {
    return renderer_.schedule(robot, frame_index, stamp);
  }
  Pose mount(int robot) const override { return renderer_.mount(robot); }
  Frame render(int robot, const FrameJob& job, int worker) override;

 private:
  scheduler::FrameRenderer& renderer_;
  const std::set<int> seen_;
  const UnseenFrames unseen_;
  const scheduler::MixedReport& report_;
  std::map<std::pair<int, uint64_t>, uint64_t> fingerprints_;  // Of the log, by robot and frame.
};

}  // namespace seam::app
