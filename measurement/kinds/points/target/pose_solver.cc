#include "measurement/kinds/points/target/pose_solver.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "measurement/numerics/damped_step.h"
#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {
namespace {

Mat3 as_rotation(const Eigen::Matrix3d& approximate) {
  const Eigen::Matrix3d r = nearest_rotation(approximate);
  Mat3 out;
  for (int c = 0; c < 3; ++c) {
    for (int row = 0; row < 3; ++row) out[c][row] = r(row, c);
  }
  return out;
}

struct Ray {
  double x, y;
  Eigen::Vector3d point;
};

// Homography from plane coordinates (a, b) to (x, y) by the direct linear transform.
Eigen::Matrix3d homography(const std::vector<Eigen::Vector2d>& plane,
                           const std::vector<Ray>& rays) {
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  for (size_t i = 0; i < rays.size(); ++i) {
    const double a = plane[i][0], b = plane[i][1], x = rays[i].x, y = rays[i].y;
    // Rays far from the axis count less: their coordinates stretch without limit.
    const double weight = 1 / (1 + x * x + y * y);
    Eigen::Matrix<double, 9, 1> first, second;
    first << a, b, 1, 0, 0, 0, -x * a, -x * b, -x;
    second << 0, 0, 0, a, b, 1, -y * a, -y * b, -y;
    normal += weight * (first * first.transpose() + second * second.transpose());
  }
  const SymmetricEigen eigen = symmetric_eigen(normal);
  const Eigen::Matrix<double, 9, 1> h = eigen.vectors.col(0);
  Eigen::Matrix3d H;
  H << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8];
  return H;
}

Pose from_columns(const Eigen::Matrix3d& R_CP, const Eigen::Vector3d& t,
                  const Eigen::Matrix3d& basis, const Eigen::Vector3d& centre) {
  // X_CW = X_CP * X_PW, the plane's frame P having the basis' columns and the centre as origin.
  const Mat3 R = as_rotation(R_CP * basis.transpose());
  const Vec3 c(centre[0], centre[1], centre[2]);
  return {R, Vec3(t[0], t[1], t[2]) - R * c};
}

struct Rays {
  std::vector<Ray> all;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d basis;   // Along the longest extent, across it, and the height.
  Eigen::Vector3d extent;  // Root mean squares in this order.
};

// False where they tell no pose: too few, or all in a line.
bool rays_of(const effects::Projection& projection, const std::vector<Sighting>& seen, Rays& rays) {
  for (const Sighting& s : seen) {
    const auto ray = projection.unproject(s.u_px, s.v_px, s.t_s);
    if (!ray || !(ray->z > 0.15)) continue;
    rays.all.push_back({ray->x / ray->z, ray->y / ray->z, {s.p_W.x, s.p_W.y, s.p_W.z}});
    rays.centre += rays.all.back().point;
  }
  if (rays.all.size() < 4) return false;
  const auto count = static_cast<double>(rays.all.size());
  rays.centre /= count;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Ray& ray : rays.all)
    scatter += (ray.point - rays.centre) * (ray.point - rays.centre).transpose() / count;
  const SymmetricEigen eigen = symmetric_eigen(scatter);
  if (!(eigen.values[1] > 1e-9 * eigen.values[2])) return false;
  for (int k = 0; k < 3; ++k) rays.extent[k] = std::sqrt(std::max(0.0, eigen.values[2 - k]));
  rays.basis.col(0) = eigen.vectors.col(2);
  rays.basis.col(1) = eigen.vectors.col(1);
  rays.basis.col(2) = rays.basis.col(0).cross(rays.basis.col(1));
  return true;
}

// Points projected on their plane.
Pose pose_of_plane(const Rays& rays) {
  const double size = rays.extent[0];
  std::vector<Eigen::Vector2d> plane;
  for (const Ray& ray : rays.all)
    plane.push_back((rays.basis.leftCols<2>().transpose() * (ray.point - rays.centre)) / size);
  Eigen::Matrix3d H = homography(plane, rays.all);
  H.leftCols<2>() /= size;
  const double scale = 2 / (H.col(0).norm() + H.col(1).norm());
  H *= H(2, 2) < 0 ? -scale : scale;  // The board lies before the camera.
  Eigen::Matrix3d R;
  R.col(0) = H.col(0);
  R.col(1) = H.col(1);
  R.col(2) = H.col(0).cross(H.col(1));
  return from_columns(R, H.col(2), rays.basis, rays.centre);
}

bool pose_of_space(const Rays& rays, Pose& X_CW) {
  if (rays.all.size() < 6) return false;
  const double size = rays.extent[0];
  Eigen::Matrix<double, 12, 12> normal = Eigen::Matrix<double, 12, 12>::Zero();
  for (const Ray& ray : rays.all) {
    Eigen::Vector4d p;
    p << (ray.point - rays.centre) / size, 1;
    Eigen::Matrix<double, 12, 1> first = Eigen::Matrix<double, 12, 1>::Zero(), second = first;
    first << p, Eigen::Vector4d::Zero(), -ray.x * p;
    second << Eigen::Vector4d::Zero(), p, -ray.y * p;
    normal += first * first.transpose() + second * second.transpose();
  }
  const SymmetricEigen dlt = symmetric_eigen(normal);
  const Eigen::Matrix<double, 12, 1> h = dlt.vectors.col(0);
  Eigen::Matrix<double, 3, 4> P;
  P << h.segment<4>(0).transpose(), h.segment<4>(4).transpose(), h.segment<4>(8).transpose();
  P.leftCols<3>() /= size;
  double scale = std::cbrt(std::abs(P.col(0).cross(P.col(1)).dot(P.col(2))));
  if (!(scale > 0)) return false;
  if (P(2, 3) < 0) scale = -scale;
  P /= scale;
  X_CW = from_columns(P.leftCols<3>(), P.col(3), Eigen::Matrix3d::Identity(), rays.centre);
  return true;
}

// The board tilted as far to the other side of the line of sight, its middle staying.
Pose tilted_other_way(const Pose& X_CW, const Rays& rays) {
  const Vec3 middle_W(rays.centre[0], rays.centre[1], rays.centre[2]);
  const Vec3 normal_W(rays.basis(0, 2), rays.basis(1, 2), rays.basis(2, 2));
  const Vec3 middle_C = X_CW * middle_W, sight = glm::normalize(middle_C);
  const Vec3 normal = X_CW.R * normal_W, other = 2 * glm::dot(normal, sight) * sight - normal;
  const Vec3 axis = glm::cross(normal, other);
  const double sine = glm::length(axis);
  if (sine < 1e-6) return X_CW;
  const Mat3 R = rotation_about(axis / sine, std::atan2(sine, glm::dot(normal, other))) * X_CW.R;
  return {R, middle_C - R * middle_W};
}

double cost_of(const std::vector<double>& residuals) {
  double sum = 0;
  for (const double x : residuals) sum += x * x;
  return 0.5 * sum;
}

// Heights against the smaller extent: up to the first the homography of a plane is a start, above
// the second the direct linear transform is determined.
constexpr double kNearlyFlat = 0.3, kDeep = 0.03;

}  // namespace

namespace {

bool initial_pose_of_one(const Cameras& camera, const std::vector<Sighting>& all, Pose& X_CW) {
  // Some of many points are enough to start from, evenly chosen.
  constexpr size_t kEnough = 60;
  std::vector<Sighting> seen;
  for (size_t i = 0; i < std::min(kEnough, all.size()); ++i)
    seen.push_back(all[i * all.size() / std::min(kEnough, all.size())]);
  Rays rays;
  if (!rays_of(camera.lens(0), seen, rays)) return false;
  const double height = rays.extent[2] / rays.extent[1];
  std::vector<Pose> starts;
  if (height < kNearlyFlat) {
    starts.push_back(pose_of_plane(rays));
    starts.push_back(tilted_other_way(starts.front(), rays));
  }
  Pose deep;
  if (height > kDeep && pose_of_space(rays, deep)) starts.push_back(deep);
  double least = std::numeric_limits<double>::infinity();
  std::vector<double> residuals;
  for (Pose& start : starts) {
    if (!refine_pose(camera, seen, start) ||
        !pose_residuals(camera, seen, start, residuals, nullptr))
      continue;
    const double cost = cost_of(residuals);
    if (cost < least) least = cost, X_CW = start;
  }
  return std::isfinite(least);
}

}  // namespace

bool initial_pose(const Cameras& cameras, const std::vector<Sighting>& all, Pose& X_CW) {
  std::vector<size_t> counts;
  for (const Sighting& s : all) {
    counts.resize(std::max(counts.size(), static_cast<size_t>(s.camera) + 1));
    ++counts[static_cast<size_t>(s.camera)];
  }
  if (counts.size() <= 1) return initial_pose_of_one(cameras, all, X_CW);
  const auto most =
      static_cast<int>(std::max_element(counts.begin(), counts.end()) - counts.begin());
  std::vector<Sighting> seen;
  std::copy_if(all.begin(), all.end(), std::back_inserter(seen),
               [&](const Sighting& s) { return s.camera == most; });
  for (Sighting& s : seen) s.camera = 0;
  Pose X_KW;
  if (!initial_pose_of_one(cameras.lens(most), seen, X_KW)) return false;
  X_CW = cameras.X_KC(most).inverse() * X_KW;
  return true;
}

Pose moved_pose(const Pose& X_CW, const Eigen::Matrix<double, 6, 1>& step) {
  const Vec3 turn(step[0], step[1], step[2]);
  const double angle = glm::length(turn);
  const Mat3 R = angle > 0 ? rotation_about(turn / angle, angle) : Mat3(1.0);
  return {R * X_CW.R, R * X_CW.p + Vec3(step[3], step[4], step[5])};
}

bool stored_pose(const std::vector<double>& values, size_t frame, Pose& X_CW) {
  if (values.size() < 12 * (frame + 1)) return false;
  const double* stored = &values[12 * frame];
  for (int c = 0; c < 3; ++c) X_CW.R[c] = Vec3(stored[3 * c], stored[3 * c + 1], stored[3 * c + 2]);
  X_CW.p = Vec3(stored[9], stored[10], stored[11]);
  return stored[0] != 0 || stored[1] != 0 || stored[2] != 0;
}

void store_pose(const Pose& X_CW, size_t frame, std::vector<double>& values) {
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) values[12 * frame + 3 * c + r] = X_CW.R[c][r];
    values[12 * frame + 9 + c] = X_CW.p[c];
  }
}

namespace {

// Of the image by the pose, over the sightings' noise, where the image is this.
bool pose_slopes(const Cameras& cameras, const std::vector<Sighting>& seen, const Pose& X_CW,
                 const std::vector<Eigen::Vector2d>& image, std::vector<double>& derivatives) {
  derivatives.resize(12 * seen.size());
  for (size_t i = 0; i < seen.size(); ++i) {
    const Sighting& s = seen[i];
    const Vec3 p_C = X_CW * s.p_W;
    const double h = 1e-6 * glm::length(p_C);
    Vec3 du, dv;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 moved_C = p_C;
      moved_C[axis] += h;
      const effects::ImagePoint there =
          cameras.project(moved_C, s.t_s, s.v_px, s.camera, s.columns);
      if (!there.has_place()) return false;
      du[axis] = (there.u - image[i][0]) / h;
      dv[axis] = (there.v - image[i][1]) / h;
    }
    // d p_C = turn x p_C + shift, and du . (turn x p_C) = turn . (p_C x du).
    const Vec3 turned_u = glm::cross(p_C, du), turned_v = glm::cross(p_C, dv);
    for (int axis = 0; axis < 3; ++axis) {
      derivatives[12 * i + axis] = -turned_u[axis] / s.sigma_u;
      derivatives[12 * i + 3 + axis] = -du[axis] / s.sigma_u;
      derivatives[12 * i + 6 + axis] = -turned_v[axis] / s.sigma_v;
      derivatives[12 * i + 9 + axis] = -dv[axis] / s.sigma_v;
    }
  }
  return true;
}

bool image_of(const Cameras& cameras, const std::vector<Sighting>& seen, const Pose& X_CW,
              std::vector<Eigen::Vector2d>& image) {
  image.resize(seen.size());
  for (size_t i = 0; i < seen.size(); ++i) {
    const Sighting& s = seen[i];
    const effects::ImagePoint point =
        cameras.project(X_CW * s.p_W, s.t_s, s.v_px, s.camera, s.columns);
    if (!point.has_place()) return false;
    image[i] = {point.u, point.v};
  }
  return true;
}

std::vector<double> residuals_of(const std::vector<Sighting>& seen,
                                 const std::vector<Eigen::Vector2d>& image) {
  std::vector<double> residuals(2 * seen.size());
  for (size_t i = 0; i < seen.size(); ++i) {
    residuals[2 * i] = (seen[i].u_px - image[i][0]) / seen[i].sigma_u;
    residuals[2 * i + 1] = (seen[i].v_px - image[i][1]) / seen[i].sigma_v;
  }
  return residuals;
}

}  // namespace

bool pose_residuals(const Cameras& cameras, const std::vector<Sighting>& seen, const Pose& X_CW,
                    std::vector<double>& residuals, std::vector<double>* derivatives) {
  std::vector<Eigen::Vector2d> image;
  if (!image_of(cameras, seen, X_CW, image)) return false;
  residuals = residuals_of(seen, image);
  return !derivatives || pose_slopes(cameras, seen, X_CW, image, *derivatives);
}

bool refine_pose(const Cameras& cameras, const std::vector<Sighting>& seen, Pose& X_CW) {
  std::vector<Eigen::Vector2d> image, next;
  std::vector<double> residuals, derivatives;
  if (!image_of(cameras, seen, X_CW, image) ||
      !pose_slopes(cameras, seen, X_CW, image, derivatives))
    return false;
  residuals = residuals_of(seen, image);
  double cost = cost_of(residuals), gained = 0;
  bool looked = true;  // Derivatives are those of this pose.
  const auto look = [&] {
    if (!looked) pose_slopes(cameras, seen, X_CW, image, derivatives);
    looked = true;
    Parabola here{Eigen::MatrixXd::Zero(6, 6), Eigen::VectorXd::Zero(6), {}, {}};
    for (size_t i = 0; i < residuals.size(); ++i) {
      const Eigen::Map<const Eigen::Matrix<double, 6, 1>> row(&derivatives[6 * i]);
      here.curvature += row * row.transpose();
      here.gradient += row * residuals[i];
    }
    return here;
  };
  const auto move = [&](const Eigen::VectorXd& by) {
    const Pose there = moved_pose(X_CW, by);
    if (!image_of(cameras, seen, there, next)) return false;
    std::vector<double> left = residuals_of(seen, next);
    const double lower = cost_of(left);
    if (!(lower < cost)) return false;
    gained = cost - lower;
    X_CW = there, cost = lower, looked = false;
    residuals.swap(left), image.swap(next);
    return true;
  };
  // Each step gains at most as much less than the one before as that one did: where two together
  // say that the next gains far less than matters, it is not looked for.
  const auto worth = [&] {
    constexpr double kFarLess = 1e-3;
    // Where a model misses by many times the noise, less of what is left is worth a step.
    constexpr double kFarOff = 10, kMost = 1e3;
    const double misfit2 = 2 * cost / static_cast<double>(residuals.size());
    const double share = 1e-11 * std::clamp(misfit2 / (kFarOff * kFarOff), 1.0, kMost);
    const double nothing = 1e-9 + share * cost;
    return Worth{.promise = 1e-11 + share * cost,
                 .gain = std::max(nothing, std::sqrt(kFarLess * nothing * gained))};
  };
  const DescentEnd end =
      descend({.look = look, .move = move, .height = [&] { return cost; }, .worth = worth},
              {.start = 1e-8}, 60);
  return std::isfinite(end.promised);
}

}  // namespace seam::measurement
