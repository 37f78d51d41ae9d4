// The match of a log, ready to be re-run: its scenario, world and renderer, made from what the log
// holds alone.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "app/camera_renderer.h"
#include "scheduler/log/log.h"
#include "scheduler/replay/rewinder.h"
#include "sim_core/world/world.h"

namespace seam::app {

struct ReplayOptions {
  // `[ROBOT=]MODEL` as given to --model: other models than the log's.
  std::vector<std::string> models;
  // As SimulatorOptions has them: other ones than the log's; "auto": the log's.
  std::string drawing = "auto", gl = "auto";
  int render_threads = 0;  // 0: as many as the machine has.
};

class ReplayMatch {
 public:
  // `log` must outlive the match. Throws InputError where the log's state version is another than
  // this program's.
  explicit ReplayMatch(const scheduler::Log& log, const ReplayOptions& options = {});
  ~ReplayMatch();

  const Scenario& scenario() const;
  World& world();
  CameraRenderer& renderer();
  // As the log's, with this program's sections.
  // Why its frames' pixels cannot be made again here, as for a log that another Mesa drew; empty
  // where they can.
  std::string why_other_pixels() const;
  const scheduler::RunHeader& header() const;
  // Made on first use.
  scheduler::Rewinder& rewinder();
  int robot(const std::string& id) const;  // As robot_number.

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Its place in the scenario; throws UsageError naming the known robots.
int robot_number(const Scenario& scenario, const std::string& id);

// "12.345 s", as text for people.
std::string seconds(SimTime time);

}  // namespace seam::app
