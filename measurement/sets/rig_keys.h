// The keys of `rig:`, described once for the reader and the schema.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "sim_core/input/config_table.h"

namespace seam::measurement {

inline constexpr Vec3 kNotGiven{std::numeric_limits<double>::quiet_NaN()};

// One entry of a chain: a fixed shift, a fixed turn, or a joint about its axis.
struct RigLink {
  Vec3 translate_m = kNotGiven;
  Vec3 rotate_rad = kNotGiven;
  std::string joint;
  Vec3 axis = kNotGiven;
};

// How unknown poses follow each other.
inline const std::vector<std::string> kMotions = {"still", "constant_velocity", "spline", "imu"};
// `rig: imu` is short for `rig: {pose: unknown, motion: imu}`.
inline constexpr const char* kRigBesideGyroscope = "imu";

struct RigKeys {
  std::vector<RigLink> chain;
  std::string poses;
  bool has_chain = false;
  size_t motion = 0;  // In order of kMotions.
  double knot_s = 0;  // 0: not given.
};

void describe_rig(ConfigTable& table, RigKeys& rig);
// Reads `rig:` of a set, which is a map or a word.
RigKeys rig_keys_of(const ConfigNode& rig);
// Whether each frame's pose is estimated.
bool has_unknown_poses(const ConfigNode& set);
// For who needs the keys alone.
void describe_rig_keys(ConfigTable& table);

}  // namespace seam::measurement
