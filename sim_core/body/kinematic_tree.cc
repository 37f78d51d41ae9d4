#include "sim_core/body/kinematic_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim_core/input/shown_text.h"

namespace seam {
namespace {

constexpr Range kTurn{-7, 7};
constexpr Range kFactor{-100, 100};

// Names are shown, and are keys in logs.
bool is_plain(std::string_view name) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./";
  return name.size() <= 100 && name.find_first_not_of(kPlain) == std::string_view::npos;
}

}  // namespace

std::optional<std::string> KinematicTree::connect() {
  connections_.assign(links.size(), {});
  driven_.clear();
  if (!present()) return std::nullopt;
  for (size_t place = 0; place < links.size(); ++place) {
    if (auto wrong = hang(place)) return wrong;
    const TreeLink& link = links[place];
    const bool drives = link.motion != JointMotion::fixed && link.mimics.empty() && place > 0;
    if (!drives) continue;
    if (auto wrong = drive(place)) return wrong;
  }
  for (size_t place = 1; place < links.size(); ++place) {
    const TreeLink& link = links[place];
    if (link.motion == JointMotion::fixed || link.mimics.empty()) continue;
    const auto leader = joint_called(link.mimics);
    if (!leader)
      return fmt::format("joint '{}' mimics '{}', expected a joint that moves by itself",
                         link.joint, link.mimics);
    connections_[place].joint = *leader;
  }
  camera_place_ = 0;
  X_LinkCamera_ = {rotation_zyx(camera_rotate_rad.x, camera_rotate_rad.y, camera_rotate_rad.z),
                   camera_translate_m};
  if (camera_link.empty()) return std::nullopt;
  const auto found = std::find_if(links.begin(), links.end(),
                                  [&](const TreeLink& link) { return link.name == camera_link; });
  if (found == links.end())
    return fmt::format("the camera's link '{}' is none of the robot's links", camera_link);
  camera_place_ = static_cast<size_t>(found - links.begin());
  return std::nullopt;
}

std::optional<std::string> KinematicTree::hang(size_t place) {
  const TreeLink& link = links[place];
  Connection& at = connections_[place];
  const auto before = links.begin() + static_cast<std::ptrdiff_t>(place);
  const auto find = [&](const std::string& name) {
    return std::find_if(links.begin(), before,
                        [&](const TreeLink& other) { return other.name == name; });
  };
  for (const std::string& name : {link.name, link.joint}) {
    if (!is_plain(name))
      return fmt::format(
          "found the name '{}', expected at most 100 letters, digits, '_', '-', '.' or '/'",
          shown(name));
  }
  if (link.name.empty()) return "a link without a name";
  if (find(link.name) != before) return fmt::format("two links are called '{}'", link.name);
  if (place == 0) {
    if (link.parent.empty()) return std::nullopt;
    return fmt::format("the first link '{}' has the parent '{}', expected none", link.name,
                       link.parent);
  }
  const auto parent = find(link.parent);
  if (parent == before)
    return fmt::format("link '{}' hangs on '{}', expected a link that stands before it", link.name,
                       link.parent);
  at.parent = static_cast<size_t>(parent - links.begin());
  at.X_PJ = {rotation_zyx(link.rotate_rad.x, link.rotate_rad.y, link.rotate_rad.z),
             link.translate_m};
  if (link.motion == JointMotion::fixed) return std::nullopt;
  const double length = glm::length(link.axis);
  if (!(length > 1e-9)) return fmt::format("joint '{}': its axis has no length", link.joint);
  at.axis = link.axis / length;
  return std::nullopt;
}

std::optional<std::string> KinematicTree::drive(size_t place) {
  const TreeLink& link = links[place];
  if (link.joint.empty())
    return fmt::format("the joint of link '{}' moves and has no name", link.name);
  if (joint_called(link.joint)) return fmt::format("two joints are called '{}'", link.joint);
  if (driven_.size() == kMostJoints)
    return fmt::format("more than {} joints that move, of which '{}' is one", kMostJoints,
                       link.joint);
  connections_[place].joint = driven_.size();
  driven_.push_back(place);
  return std::nullopt;
}

std::optional<size_t> KinematicTree::joint_called(std::string_view name) const {
  for (size_t number = 0; number < driven_.size(); ++number)
    if (joint(number).joint == name) return number;
  return std::nullopt;
}

double KinematicTree::angle_of(size_t place, const JointAngles& joints) const {
  const double angle = joints[connections_[place].joint];
  const TreeLink& link = links[place];
  return link.mimics.empty() ? angle : link.mimic_factor * angle + link.mimic_offset_rad;
}

Pose KinematicTree::moved(size_t place, const JointAngles& joints) const {
  const Connection& at = connections_[place];
  switch (links[place].motion) {
    case JointMotion::fixed:
      break;
    case JointMotion::turn:
      return {at.X_PJ.R * rotation_about(at.axis, angle_of(place, joints)), at.X_PJ.p};
    case JointMotion::slide:
      return {at.X_PJ.R, at.X_PJ * (angle_of(place, joints) * at.axis)};
  }
  return at.X_PJ;
}

std::vector<Pose> KinematicTree::link_poses(const JointAngles& joints) const {
  std::vector<Pose> X_BLinks(links.size());
  for (size_t place = 1; place < links.size(); ++place)
    X_BLinks[place] = X_BLinks[connections_[place].parent] * moved(place, joints);
  return X_BLinks;
}

Pose KinematicTree::camera_link_pose(const JointAngles& joints) const {
  Pose X = X_LinkCamera_;
  for (size_t place = camera_place_; place > 0; place = connections_[place].parent)
    X = moved(place, joints) * X;
  return X;
}

double KinematicTree::reach_m() const {
  double most = 0;
  std::vector<double> reaches(links.size(), 0.0);
  for (size_t place = 1; place < links.size(); ++place) {
    const TreeLink& link = links[place];
    double length = glm::length(link.translate_m);
    if (link.motion == JointMotion::slide)
      length += std::max(std::abs(link.limits.min_rad), std::abs(link.limits.max_rad));
    reaches[place] = reaches[connections_[place].parent] + length;
    most = std::max(most, reaches[place]);
  }
  return most;
}

double KinematicTree::motion_bound_m(const JointAngles& a, const JointAngles& b,
                                     double reach_m) const {
  double sum = 0;
  for (size_t place = 1; place < links.size(); ++place) {
    const JointMotion motion = links[place].motion;
    if (motion == JointMotion::fixed) continue;
    const double moved = std::abs(angle_of(place, b) - angle_of(place, a));
    sum += motion == JointMotion::turn ? reach_m * moved : moved;
  }
  return sum;
}

void describe(ConfigTable& table, TreeLink& link) {
  table.text({"name", "Its name.", true}, link.name);
  table.text({"parent", "The link that it hangs on, which stands before it; the first has none."},
             link.parent);
  table.text({"joint", "The name of the joint that holds it; a fixed one needs none."}, link.joint);
  table.choice_of({"motion", "What the joint does: fixed, turn about its axis, slide along it."},
                  link.motion, {"fixed", "turn", "slide"});
  table.vec3({"translate_m", "Where the joint is in the parent's frame, m."}, link.translate_m);
  table.vec3({"rotate_rad", "How it is turned there: Rz(z) Ry(y) Rx(x)."}, link.rotate_rad);
  table.vec3({"axis", "In the joint's frame."}, link.axis);
  table.number({"min_rad", "Lowest angle, rad; of a sliding joint m."}, link.limits.min_rad, kTurn);
  table.number({"max_rad", "Highest angle, rad; of a sliding joint m."}, link.limits.max_rad,
               kTurn);
  table.number({"speed_radps", "Top speed, rad/s; of a sliding joint m/s."},
               link.limits.speed_radps, {0, 1000});
  table.number({"start_rad", "Where it is at the start, rad; of a sliding joint m."},
               link.start_rad, kTurn);
  table.text({"mimics", "A joint that this one follows: factor * its angle + offset."},
             link.mimics);
  table.number({"mimic_factor", "See mimics."}, link.mimic_factor, kFactor);
  table.number({"mimic_offset_rad", "See mimics, rad."}, link.mimic_offset_rad, kTurn);
  if (link.motion == JointMotion::fixed || !link.mimics.empty()) return;
  table.require(link.limits.min_rad <= link.limits.max_rad, "max_rad", "expected at least min_rad");
  table.require(link.limits.speed_radps > 0, "speed_radps", "expected more than 0");
  table.require(link.start_rad >= link.limits.min_rad && link.start_rad <= link.limits.max_rad,
                "start_rad",
                fmt::format("found {}, expected from {} to {}", link.start_rad, link.limits.min_rad,
                            link.limits.max_rad));
}

}  // namespace seam
