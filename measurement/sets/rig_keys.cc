#include "measurement/sets/rig_keys.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace seam::measurement {
namespace {

constexpr size_t kMaxLinks = 1000;

bool is_given(const Vec3& value) {
  return !std::isnan(value.x);
}

void describe_link(ConfigTable& table, RigLink& link) {
  table.vec3({"translate_m", "A fixed shift, m."}, link.translate_m);
  table.vec3({"rotate_rad", "A fixed turn about x, y, z: Rz * Ry * Rx."}, link.rotate_rad);
  table.text({"joint", "A joint: its angle is column <joint>_rad of the table joints."},
             link.joint);
  table.vec3({"axis", "Of a joint; any length."}, link.axis);
  const int forms = is_given(link.translate_m) + is_given(link.rotate_rad) + !link.joint.empty();
  table.require(forms == 1, "joint", "expected one of translate_m, rotate_rad, joint with axis");
  table.require(link.joint.empty() || glm::length(link.axis) > 0, "axis",
                "found a zero axis, expected a direction");
}

}  // namespace

void describe_rig(ConfigTable& table, RigKeys& rig) {
  table.list(
      {"chain", "From world to camera, links in order."}, rig.chain.size(), kMaxLinks,
      [&](size_t count) {
        rig.has_chain = true;
        rig.chain.resize(count);
      },
      [&](ConfigTable& link, size_t i) { describe_link(link, rig.chain[i]); });
  table.text({"poses", "The table of the camera's measured poses, by name or file."}, rig.poses);
  size_t pose = 1;
  table.choice({"pose", "Each frame's pose is estimated."}, pose, {"unknown"});
  table.require(rig.has_chain + !rig.poses.empty() + (pose == 0) == 1, "pose",
                "expected one of chain, poses, pose: unknown");
  table.choice({"motion",
                "Of unknown poses: each view stands still, has a velocity of its own, all lie on "
                "one smooth path, or each turns as the gyroscope of the table imu says."},
               rig.motion, kMotions);
  table.number({"knot_s", "Of motion: spline: seconds from knot to knot; 0: 2.5 frame periods."},
               rig.knot_s, {.min = 0, .max = 3600});
  table.require(rig.motion == 0 || pose == 0, "motion", "expected only beside pose: unknown");
  table.require(rig.knot_s == 0 || rig.motion == 2, "knot_s",
                "expected only beside motion: spline");
}

RigKeys rig_keys_of(const ConfigNode& rig) {
  RigKeys keys;
  if (rig.is_scalar() && rig.text() == kRigBesideGyroscope) {
    keys.motion = kMotions.size() - 1;
    return keys;
  }
  if (!rig.is_map())
    rig.fail(fmt::format("expected a map of keys to values, or the word {}", kRigBesideGyroscope));
  read_config(rig, [&](ConfigTable& table) { describe_rig(table, keys); });
  return keys;
}

bool has_unknown_poses(const ConfigNode& set) {
  const auto rig = set.find("rig");
  return rig && (!rig->is_map() || rig->has("pose"));
}

void describe_rig_keys(ConfigTable& table) {
  RigKeys keys;
  describe_rig(table, keys);
}

}  // namespace seam::measurement
