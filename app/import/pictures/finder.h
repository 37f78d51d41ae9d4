// Targets in pictures, as `seam-pictures` finds them: a program of its own, since pictures of
// strangers are decoded in it, of which one runs on each core.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/import/draft/target.h"

namespace seam::app {

struct FoundPoint {
  size_t point = 0;
  double u_px = 0, v_px = 0;
};

struct PictureAnswer {
  std::string without;  // Why nothing was found; empty where points were.
  int width_px = 0, height_px = 0;
  std::optional<int64_t> time_ns;  // Of its EXIF data.
  double edge_px = 0;              // How wide the target's edges are in it; 0 unknown.
  std::vector<FoundPoint> points;
};

// An answer a picture, the same for any number of processes. Throws InputError where the program is
// not there. `on_answer` is called with the number of answers so far.
std::vector<PictureAnswer> find_targets(const std::vector<std::filesystem::path>& pictures,
                                        const TargetSpec& target,
                                        const std::function<void(size_t)>& on_answer);

// The answer in what the program writes, up to its `end`. Whatever does not hold, points that the
// target has not among it, makes it one without points.
PictureAnswer answer_of(const std::string& text, size_t target_points);

}  // namespace seam::app
