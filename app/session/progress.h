// One line on a terminal, renewed a few times a second: simulated time, real-time factor, and which
// client the clock waits for.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "scheduler/clients/client_hub.h"
#include "scheduler/loop/run_control.h"

namespace seam::app {

class Progress {
 public:
  // Shows nothing when stderr is no terminal, but for a client that is waited for over 5 s.
  Progress(const scheduler::ClientHub& hub, const scheduler::RunControl& control,
           SimDuration total);
  ~Progress();

 private:
  void show();
  void warn_of_silence();

  const scheduler::ClientHub& hub_;
  const scheduler::RunControl& control_;
  SimDuration total_;
  bool terminal_;
  bool warned_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ending_ = false;
  std::jthread thread_;
};

}  // namespace seam::app
