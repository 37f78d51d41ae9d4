// A recorded run as one robot lived it, for learning: at each of its turns what it sensed and what
// it then ordered. The log is run again for it, since a log holds decisions and no readings.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "scheduler/log/log.h"

namespace seam::app {

// What the numbers of a row are.
struct EpisodeField {
  std::string name, unit;
  friend bool operator==(const EpisodeField&, const EpisodeField&) = default;
};

// What all episodes of a data set have in common.
struct EpisodeKind {
  std::string robot, robot_type;
  double turns_per_s = 0;
  std::vector<EpisodeField> state, action;
  size_t height_px = 0, width_px = 0;  // Of frames; 0: there are none.
  friend bool operator==(const EpisodeKind&, const EpisodeKind&) = default;
};

// Row by row; as many rows as there are times.
struct Episode {
  EpisodeKind kind;
  int64_t seed = 0;
  std::vector<int64_t> time_ns;
  std::vector<double> state, action;
  std::vector<int64_t> frame_index;  // Of the newest frame at each turn; -1 before the first.
  std::vector<uint8_t> rgb;          // Its pixels; 0 before the first.
};

// `robot`: empty for the only one of the log. Throws InputError, UsageError.
Episode episode_of(const scheduler::Log& log, const std::string& robot, bool with_frames);

// One file an episode, and schema.json, in names of LeRobot's data sets.
class EpisodeFolder {
 public:
  explicit EpisodeFolder(const std::filesystem::path& folder);
  // Throws InputError where it is no episode of the same kind as those before.
  void add(const Episode& episode, const std::string& log);
  // The schema, by which a folder is known to be whole.
  void finish();
  size_t episodes() const { return logs_.size(); }
  size_t rows() const { return rows_; }

 private:
  std::filesystem::path folder_;
  EpisodeKind kind_;
  std::vector<std::string> logs_;
  std::vector<int64_t> seeds_, lengths_;
  size_t rows_ = 0;
};

}  // namespace seam::app
