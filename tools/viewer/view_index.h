// One pass over a log: what the viewer's page asks for again and again.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scheduler/log/printed_line.h"

namespace seam::tools {

struct Series {
  std::vector<double> t;
  std::vector<double> values;
};

// A decision, and the newest frame that the robot had been sent when it decided.
struct DecisionEntry {
  double t = 0;
  std::optional<uint64_t> frame_index;
};

struct DebugEntry {
  double t = 0;
  scheduler::DebugItem item;
  std::optional<uint64_t> frame_index;  // The item's own, else its decision's.
};

// Where a camera is and where it looks, as a map shows it.
struct CameraPlace {
  float x_m, y_m;
  float heading_rad;    // Of the optical axis, seen from above.
  float elevation_rad;  // Over the level.
};

struct RobotIndex {
  std::vector<scheduler::FrameRecord> frames;
  std::vector<DecisionEntry> decisions;
  std::vector<DebugEntry> debug;
  std::map<std::string, Series> series;  // Poses, commands, debug values.
  std::vector<CameraPlace> cameras;      // At pose_t, of a robot without an ERS-210's head.
};

struct ViewIndex {
  std::vector<double> pose_t;
  std::vector<std::vector<float>> poses;  // As StepRecord::poses, one a time of pose_t.
  std::vector<SimTime> step_times;
  std::vector<uint64_t> step_fingerprints;
  std::vector<scheduler::SimulationEvent> events;
  std::vector<scheduler::PrintedLine> printed;
  std::vector<RobotIndex> robots;
};

ViewIndex index_log(const scheduler::Log& log);

// At most `points` rows or so: of each bucket of time the first, least, greatest and last value.
Series thinned(const Series& series, double from_s, double to_s, size_t points);

}  // namespace seam::tools
