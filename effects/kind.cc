#include "effects/kind.h"

#include <algorithm>

#include "sim_core/base/error.h"

namespace seam::effects {

const std::vector<KindFacts>& kinds() {
  static const std::vector<KindFacts> all = {
      {kPoints, "points", "frame", {Stage::geometry, Stage::target, Stage::joint}},
      {kPhotometry, "photometry", "frame", {Stage::light}},
      {kJoints, "joints", "run", {Stage::joint}},
      {kOdometry, "odometry", "run", {Stage::locomotion}},
      {kLandmarks, "landmarks", "run", {Stage::detector}},
      {kRanges, "ranges", "trial", {}},
      {kFrames, "frames", "frame", {}},
      {kOutcomes, "outcomes", "scenario", {}},
      {Kind{256}, "imu", "run", {}},  // kImu of stages/inertial/inertial.h.
  };
  return all;
}

const KindFacts& kind_facts(Kind bit) {
  const auto found = std::find_if(kinds().begin(), kinds().end(),
                                  [bit](const KindFacts& kind) { return kind.bit == bit; });
  SEAM_CHECK(found != kinds().end(), "no kind has the bit {}", static_cast<unsigned>(bit));
  return *found;
}

std::vector<std::string> kind_names() {
  std::vector<std::string> names;
  for (const KindFacts& kind : kinds()) names.emplace_back(kind.name);
  return names;
}

std::string to_string(Stage stage) {
  static const char* const kNames[] = {
      "timing",   "joint",      "mount",  "geometry",        "radiometry", "light",   "sensor",
      "detector", "locomotion", "target", "corner_detector", "scenario",   "inertial"};
  return kNames[static_cast<int>(stage)];
}

}  // namespace seam::effects
