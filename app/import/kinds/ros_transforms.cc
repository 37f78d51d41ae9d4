#include "app/import/kinds/ros_transforms.h"

#include <algorithm>
#include <cmath>

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr size_t kMostFrames = 4096;
constexpr size_t kMostDepth = 64;

// ROS 1 had names with a slash before them.
std::string plain_name(std::string name) {
  return name.starts_with('/') ? name.substr(1) : name;
}

std::array<double, 4> product(const std::array<double, 4>& a, const std::array<double, 4>& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
          a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
          a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}

}  // namespace

StampedPose pose_in(RosMessage& message, int64_t stamp_ns, const std::string& topic) {
  StampedPose pose{.ns = stamp_ns, .p = message.vec3(), .q = message.quaternion()};
  const double length = std::sqrt(pose.q[0] * pose.q[0] + pose.q[1] * pose.q[1] +
                                  pose.q[2] * pose.q[2] + pose.q[3] * pose.q[3]);
  if (!std::isfinite(pose.p.x + pose.p.y + pose.p.z) || !(std::abs(length - 1) < 0.05))
    throw InputError(
        fmt::format("{}: at {} s: found a pose that is none (NaN, or a quaternion of "
                    "length {:.3g})",
                    topic, seconds_text(stamp_ns), length));
  for (double& q : pose.q) q /= length;
  return pose;
}

void RosTransforms::take(RosMessage& message, int64_t log_ns, const std::string& topic) {
  // A stamp, two names, seven numbers.
  for (uint32_t left = message.count(72); left > 0; --left) take_one(message, log_ns, topic);
}

void RosTransforms::take_one(RosMessage& message, int64_t log_ns, const std::string& topic) {
  const auto header = message.header();
  const std::string parent = plain_name(header.frame), child = plain_name(message.text());
  const StampedPose pose = pose_in(message, header.stamp_ns != 0 ? header.stamp_ns : log_ns, topic);
  if (frames_.size() >= kMostFrames && !frames_.contains(child)) return;
  Frame& frame = frames_[child];
  if (frame.rows.empty()) frame.parent = parent;
  if (frame.parent != parent)
    throw InputError(
        fmt::format("{}: at {} s: frame '{}' stands in '{}' and in '{}', expected one parent",
                    topic, seconds_text(pose.ns), child, frame.parent, parent));
  frame.rows.push_back({log_ns, pose});
}

bool RosTransforms::moves(const Frame& frame) {
  constexpr size_t kFewest = 4;
  if (frame.rows.size() < kFewest) return false;
  const StampedPose& first = frame.rows.front().pose;
  return std::any_of(frame.rows.begin(), frame.rows.end(), [&](const PoseRow& row) {
    return row.pose.p != first.p || row.pose.q != first.q;
  });
}

std::vector<std::string> RosTransforms::moving() const {
  std::vector<std::string> names;
  for (const auto& [child, frame] : frames_) {
    if (moves(frame)) names.push_back(frame.parent + ":" + child);
  }
  return names;
}

std::string RosTransforms::body() const {
  std::string child;
  for (const char* usual : {"base_footprint", "base_link", "base"}) {
    // Either stands fixed in the other at times.
    const auto found = frames_.find(usual);
    if (child.empty() && found != frames_.end() && moves(found->second)) child = usual;
  }
  if (child.empty()) {
    const auto names = moving();
    if (names.size() != 1) return "";
    child = names[0].substr(names[0].find(':') + 1);
  }
  std::string root = frames_.at(child).parent;
  for (size_t depth = 0; depth < kMostDepth; ++depth) {
    const auto above = frames_.find(root);
    if (above == frames_.end()) return root + ":" + child;
    root = above->second.parent;
  }
  return "";
}

std::optional<std::vector<PoseRow>> RosTransforms::poses(const std::string& names) const {
  const size_t colon = names.find(':');
  if (colon == std::string::npos) return std::nullopt;
  const std::string parent = names.substr(0, colon), child = names.substr(colon + 1);
  std::vector<const Frame*> way;
  for (std::string at = child; at != parent;) {
    const auto found = frames_.find(at);
    if (found == frames_.end() || way.size() == kMostDepth) return std::nullopt;
    way.push_back(&found->second);
    at = found->second.parent;
  }
  if (way.empty()) return std::nullopt;
  const auto sooner = [](const PoseRow& a, const PoseRow& b) { return a.pose.ns < b.pose.ns; };
  std::vector<PoseRow> rows = way[0]->rows;
  std::stable_sort(rows.begin(), rows.end(), sooner);
  for (size_t step = 1; step < way.size(); ++step) {
    std::vector<PoseRow> above = way[step]->rows;
    std::stable_sort(above.begin(), above.end(), sooner);
    std::vector<PoseRow> raised;
    size_t next = 0;
    for (const PoseRow& row : rows) {
      while (next < above.size() && above[next].pose.ns <= row.pose.ns) ++next;
      // A static transform holds for all times.
      if (next == 0 && above.size() > 1) continue;
      const StampedPose& up = above[next == 0 ? 0 : next - 1].pose;
      raised.push_back({row.log_ns,
                        {.ns = row.pose.ns,
                         .p = rotation_of(up.q) * row.pose.p + up.p,
                         .q = product(up.q, row.pose.q)}});
    }
    rows = std::move(raised);
  }
  return rows;
}

}  // namespace seam::app
