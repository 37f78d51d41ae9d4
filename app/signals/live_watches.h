// Expressions over the signals of a run that goes on, for the scripts that drive its robots.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "scheduler/loop/observer.h"
#include "scheduler/server/watch.h"
#include "sim_core/world/world.h"

namespace seam::app {

class LiveWatch;

class LiveWatches final : public scheduler::SimulationObserver, public scheduler::WatchSource {
 public:
  // `is_driven`: whose turns may be watched. The clock waits for such robots as long as they like,
  // so nothing moves while values are read.
  LiveWatches(const World& world, std::function<bool(const std::string& robot)> is_driven)
      : world_(world), is_driven_(std::move(is_driven)) {}

  std::shared_ptr<scheduler::Watch> watch(const std::string& robot,
                                          const std::vector<std::string>& expressions) override;

  void on_turn(SimTime time, const scheduler::Turn& turn) override;
  void on_frame(SimTime time, const FrameJob& job, const Frame& frame) override;
  void on_event(const scheduler::SimulationEvent& event) override;

 private:
  template <class Action>
  void for_each(Action action);

  const World& world_;
  const std::function<bool(const std::string& robot)> is_driven_;
  std::mutex mutex_;
  std::vector<std::weak_ptr<LiveWatch>> watches_;
};

}  // namespace seam::app
