// A recorded run given to another program: it gets what its robot got and is asked what it
// would do, while the log decides for all. Nothing that it decides has an effect, so the world goes
// on while the program thinks, up to the robot's next observation.
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "app/camera_renderer.h"
#include "scheduler/log/log.h"
#include "scheduler/loop/decision_source.h"
#include "scheduler/replay/player.h"

namespace seam::app {

// One instant at which the robot decided, in the log and in the program's place.
struct FedDecision {
  const scheduler::Observation& seen;
  const scheduler::Answer& logged;
  const scheduler::Answer& fed;
};

class OpenLoop final : public scheduler::DecisionSource {
 public:
  using OnDecision = std::function<void(const FedDecision&)>;

  // All must outlive it. `live` is asked for this robot alone. `stopped` is set where the run was
  // stopped before the log's end.
  OpenLoop(const scheduler::Log& log, scheduler::LiveSource& live, int robot,
           OnDecision on_decision, bool& stopped)
      : turns_(log),
        live_(live),
        robot_(robot),
        on_decision_(std::move(on_decision)),
        stopped_(stopped) {}

  // Throws InputError where the program ended or fell silent before the log did.
  std::optional<scheduler::Turn> decide(
      SimTime now,
      std::span<const std::shared_ptr<const scheduler::Observation>> observations) override;
  void finish(SimTime now, const std::string& reason) override;

 private:
  // What the program was asked last and did not answer yet.
  struct Asked {
    SimTime time;
    std::shared_ptr<const scheduler::Observation> seen;
    scheduler::Answer logged;
  };
  // Waits for the answer; false where the run is to stop.
  bool settle();

  scheduler::TurnReader turns_;
  scheduler::LiveSource& live_;
  const int robot_;
  OnDecision on_decision_;
  bool& stopped_;
  std::optional<Asked> asked_;
};

// Frames for one robot alone: those that the log holds as pictures from it, others drawn again.
// Other robots' frames, which nobody looks at, have no pixels.
class OneRobotsFrames final : public scheduler::FrameRenderer {
 public:
  // Both must outlive it.
  OneRobotsFrames(const scheduler::Log& log, CameraRenderer& renderer, int robot);

  int workers() const override { return renderer_.workers(); }
  RowSchedule schedule(int robot, uint64_t frame_index, SimTime stamp) override {
    return renderer_.schedule(robot, frame_index, stamp);
  }
  Pose mount(int robot) const override { return renderer_.mount(robot); }
  Frame render(int robot, const FrameJob& job, int worker) override;

  uint64_t from_log() const { return from_log_; }
  uint64_t drawn() const { return drawn_; }

 private:
  std::optional<std::string> picture(const FrameJob& job);

  const scheduler::Log& log_;
  CameraRenderer& renderer_;
  const int robot_;
  std::mutex reading_;
  std::map<uint64_t, scheduler::FrameRecord> frames_;  // With a picture in the log, by index.
  std::atomic<uint64_t> from_log_ = 0, drawn_ = 0;
};

}  // namespace seam::app
