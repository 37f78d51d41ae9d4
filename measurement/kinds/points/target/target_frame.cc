#include "measurement/kinds/points/target/target_frame.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <set>

#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {
namespace {

// The axes of a plane with this normal: a board whose plane is the world's x and y has the world's
// axes, and others likewise in turn (y and z, z and x).
Mat3 axes_with_normal(Vec3 normal) {
  int along = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (std::abs(normal[axis]) > std::abs(normal[along]) + 1e-12) along = axis;
  }
  if (normal[along] < 0) normal = -normal;
  Vec3 first(0.0);
  first[(along + 1) % 3] = 1;
  first = glm::normalize(first - glm::dot(first, normal) * normal);
  return {first, glm::cross(normal, first), normal};
}

}  // namespace

Plane plane_through(const std::vector<Vec3>& points) {
  Plane plane;
  if (points.size() < 3) return plane;
  for (const Vec3& p : points) plane.middle += p / static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Vec3& p : points) {
    const Vec3 d = p - plane.middle;
    const Eigen::Vector3d e(d.x, d.y, d.z);
    scatter += e * e.transpose();
  }
  const SymmetricEigen eigen = symmetric_eigen(scatter);
  if (!(eigen.values[1] > 1e-9 * eigen.values[2])) return plane;
  plane.exists = true;
  plane.height_share = std::sqrt(std::max(0.0, eigen.values[0]) / eigen.values[1]);
  const auto column = eigen.vectors.col(0);
  // A plan drawn along the world's axes keeps them: heights of some of its points are no tilt.
  constexpr double kNoTilt_rad = 0.05;
  Vec3 normal(column[0], column[1], column[2]);
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(normal[axis]) > std::cos(kNoTilt_rad)) {
      normal = Vec3(0.0);
      normal[axis] = 1;
    }
  }
  plane.axes = axes_with_normal(glm::normalize(normal));
  return plane;
}

Vec3 Target::in_axes(size_t point) const {
  return (plan_W[point] - middle_W) * axes_W;  // v * R is R' v.
}

Vec3 Target::placed_W(size_t point, const effects::TargetShape& shape) const {
  if (shape.is_plan()) return plan_W[point];
  const Vec3 p_B = in_axes(point);
  return middle_W + axes_W * shape.placed(p_B, p_B.x / half_x_m, p_B.y / half_y_m);
}

double Target::bending(size_t point, const effects::TargetShape& shape) const {
  const Vec3 p_B = in_axes(point);
  return shape.bending(p_B.x / half_x_m, p_B.y / half_y_m);
}

Target target_of_rows(const std::vector<std::string>& names, const std::vector<int>& point_of_row,
                      const std::vector<Vec3>& p_W, const std::vector<int>& frame_of_row) {
  Target target{.names = names};
  target.plan_W.resize(names.size());
  target.views.resize(names.size());
  std::vector<char> known(names.size(), 0);
  std::vector<int> last_frame(names.size(), -1);
  for (size_t row = 0; row < p_W.size(); ++row) {
    const auto point = static_cast<size_t>(point_of_row[row]);
    if (!known[point]) target.plan_W[point] = p_W[row], known[point] = 1;
    if (last_frame[point] != frame_of_row[row]) ++target.views[point];
    last_frame[point] = frame_of_row[row];
  }
  const Plane plane = plane_through(target.plan_W);
  target.flat = plane.exists && plane.height_share < kBoardHeight;
  if (!target.flat) return target;
  // A plan that is flat but for heights of its own has the axes of its plane; one that lies in the
  // world's plane has the world's.
  target.axes_W = plane.axes;
  target.middle_W = plane.middle;
  Vec3 low(1e300), high(-1e300);
  for (size_t i = 0; i < names.size(); ++i) {
    const Vec3 p = target.in_axes(i);
    low = glm::min(low, p), high = glm::max(high, p);
  }
  const Vec3 shift(0.5 * (low.x + high.x), 0.5 * (low.y + high.y), 0);
  target.middle_W += target.axes_W * shift;
  target.half_x_m = 0.5 * (high.x - low.x), target.half_y_m = 0.5 * (high.y - low.y);
  return target;
}

}  // namespace seam::measurement
