// `--frames DIR`: each frame as ROBOT_NNNNNN.png, and frames.csv with stamp, row times and the
// camera's pose at each row.
#pragma once

#include <condition_variable>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <thread>

#include "scheduler/loop/observer.h"
#include "sim_core/base/output.h"

namespace seam::app {

class FrameFiles final : public scheduler::SimulationObserver {
 public:
  // Makes the folder; throws InputError where that or a file in it cannot be written, and where it
  // holds the frames of another run, which `overwrite` removes.
  FrameFiles(const std::filesystem::path& folder, bool overwrite);
  ~FrameFiles() override;

  void on_frame(SimTime time, const FrameJob& job, const Frame& frame) override;
  void on_end(SimTime time, scheduler::EndReason reason, uint64_t fingerprint) override;

  uint64_t written() const { return written_; }

 private:
  struct Picture {
    std::filesystem::path file;
    int width_px, height_px;
    std::vector<uint8_t> rgb;
  };
  void write_pictures();
  void stop_writing();
  void write_rows(const std::string& name, const FrameJob& job, const Frame& frame);

  std::filesystem::path folder_;
  OutputFile csv_;
  uint64_t written_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Picture> pictures_;
  bool ending_ = false;
  std::string error_;
  std::jthread thread_;
};

}  // namespace seam::app
