// All direct lines of a run: takes them in, hears their hellos, notices who is gone, and writes
// what waits to be written, on a thread of its own.
#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "scheduler/listen/wake.h"
#include "scheduler/server/direct_line.h"

namespace seam::scheduler {

class DirectLines {
 public:
  // The parts outlive it.
  explicit DirectLines(const SessionParts& parts);
  // Lines that are still open get a second to take their Goodbye.
  ~DirectLines();
  DirectLines(const DirectLines&) = delete;
  DirectLines& operator=(const DirectLines&) = delete;

  // Takes over a connected socket.
  void add(int socket);

 private:
  using Clock = std::chrono::steady_clock;
  struct Watched {
    std::shared_ptr<DirectLine> line;
    Clock::time_point since;
  };

  void run();
  void take_new();
  void serve_those_that_want();
  void let_go();

  const SessionParts& parts_;
  Wake wake_;
  std::mutex mutex_;
  std::vector<int> new_sockets_;
  bool ending_ = false;
  std::vector<Watched> lines_;  // The thread's alone.
  std::jthread thread_;
};

}  // namespace seam::scheduler
