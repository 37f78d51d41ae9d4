#include "measurement/kinds/points/pose_solver.h"

#include <Eigen/Geometry>
#include <cmath>

#include "measurement/numerics/damped_step.h"
#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {
namespace {

Pose moved(const Pose& X_CW, const Eigen::Matrix<double, 6, 1>& step) {
  const Vec3 turn(step[0], step[1], step[2]);
  const double angle = glm::length(turn);
  const Mat3 R = angle > 0 ? rotation_about(turn / angle, angle) : Mat3(1.0);
  return {R * X_CW.R, R * X_CW.p + Vec3(step[3], step[4], step[5])};
}

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

}  // namespace

bool initial_pose(const effects::Projection& projection, const std::vector<Sighting>& seen,
                  Pose& X_CW) {
  std::vector<Ray> rays;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Sighting& s : seen) {
    const auto ray = projection.unproject(s.u_px, s.v_px, s.t_s);
    if (!ray || !(ray->z > 0.15)) continue;
    rays.push_back({ray->x / ray->z, ray->y / ray->z, {s.p_W.x, s.p_W.y, s.p_W.z}});
    centre += rays.back().point;
  }
  if (rays.size() < 4) return false;
  centre /= static_cast<double>(rays.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Ray& ray : rays) scatter += (ray.point - centre) * (ray.point - centre).transpose();
  const SymmetricEigen eigen = symmetric_eigen(scatter);
  const double size = std::sqrt(eigen.values[2] / static_cast<double>(rays.size()));
  if (!(eigen.values[1] > 1e-9 * eigen.values[2])) return false;  // In a line.
  Eigen::Matrix3d basis;
  basis.col(0) = eigen.vectors.col(2);
  basis.col(1) = eigen.vectors.col(1);
  basis.col(2) = basis.col(0).cross(basis.col(1));
  if (eigen.values[0] < 1e-8 * eigen.values[2]) {
    std::vector<Eigen::Vector2d> plane;
    for (const Ray& ray : rays)
      plane.push_back((basis.leftCols<2>().transpose() * (ray.point - centre)) / size);
    Eigen::Matrix3d H = homography(plane, rays);
    H.leftCols<2>() /= size;
    const double scale = 2 / (H.col(0).norm() + H.col(1).norm());
    H *= H(2, 2) < 0 ? -scale : scale;  // The board lies before the camera.
    Eigen::Matrix3d R;
    R.col(0) = H.col(0);
    R.col(1) = H.col(1);
    R.col(2) = H.col(0).cross(H.col(1));
    X_CW = from_columns(R, H.col(2), basis, centre);
    return true;
  }
  if (rays.size() < 6) return false;
  Eigen::Matrix<double, 12, 12> normal = Eigen::Matrix<double, 12, 12>::Zero();
  for (const Ray& ray : rays) {
    Eigen::Vector4d p;
    p << (ray.point - centre) / size, 1;
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
  X_CW = from_columns(P.leftCols<3>(), P.col(3), Eigen::Matrix3d::Identity(), centre);
  return true;
}

bool pose_residuals(const effects::Projection& projection, const std::vector<Sighting>& seen,
                    const Pose& X_CW, std::vector<double>& residuals,
                    std::vector<double>* derivatives) {
  residuals.resize(2 * seen.size());
  if (derivatives) derivatives->assign(12 * seen.size(), 0);
  for (size_t i = 0; i < seen.size(); ++i) {
    const Sighting& s = seen[i];
    const Vec3 p_C = X_CW * s.p_W;
    const effects::ImagePoint image = projection.project(p_C, s.t_s, s.v_px);
    if (!image.visible) return false;
    residuals[2 * i] = (s.u_px - image.u) / s.sigma_u;
    residuals[2 * i + 1] = (s.v_px - image.v) / s.sigma_v;
    if (!derivatives) continue;
    const double h = 1e-6 * glm::length(p_C);
    double du[3], dv[3];
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 moved_C = p_C;
      moved_C[axis] += h;
      const effects::ImagePoint there = projection.project(moved_C, s.t_s, s.v_px);
      if (!there.visible) return false;
      du[axis] = (there.u - image.u) / h;
      dv[axis] = (there.v - image.v) / h;
    }
    // d p_C = turn x p_C + shift.
    const Vec3 turned[3] = {{0, -p_C.z, p_C.y}, {p_C.z, 0, -p_C.x}, {-p_C.y, p_C.x, 0}};
    for (int k = 0; k < 6; ++k) {
      double u = 0, v = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const double motion = k < 3 ? turned[k][axis] : (axis == k - 3 ? 1.0 : 0.0);
        u += du[axis] * motion;
        v += dv[axis] * motion;
      }
      (*derivatives)[12 * i + k] = -u / s.sigma_u;
      (*derivatives)[12 * i + 6 + k] = -v / s.sigma_v;
    }
  }
  return true;
}

bool refine_pose(const effects::Projection& projection, const std::vector<Sighting>& seen,
                 Pose& X_CW) {
  std::vector<double> residuals, derivatives, next;
  if (!pose_residuals(projection, seen, X_CW, residuals, &derivatives)) return false;
  const auto cost_of = [](const std::vector<double>& r) {
    double sum = 0;
    for (double x : r) sum += x * x;
    return 0.5 * sum;
  };
  double cost = cost_of(residuals);
  bool looked = true;  // Residuals and derivatives are those of this pose.
  const auto look = [&] {
    if (!looked) pose_residuals(projection, seen, X_CW, residuals, &derivatives);
    looked = true;
    Parabola here{Eigen::MatrixXd::Zero(6, 6), Eigen::VectorXd::Zero(6), {}};
    for (size_t i = 0; i < residuals.size(); ++i) {
      const Eigen::Map<const Eigen::Matrix<double, 6, 1>> row(&derivatives[6 * i]);
      here.curvature += row * row.transpose();
      here.gradient += row * residuals[i];
    }
    return here;
  };
  const auto move = [&](const Eigen::VectorXd& by) {
    const Pose there = moved(X_CW, by);
    if (!pose_residuals(projection, seen, there, next, nullptr)) return false;
    const double lower = cost_of(next);
    if (!(lower < cost)) return false;
    X_CW = there, cost = lower, looked = false;
    return true;
  };
  const DescentEnd end = descend(
      {.look = look,
       .move = move,
       .height = [&] { return cost; },
       .worth = [&] { return Worth{.promise = 1e-11 * (1 + cost), .gain = 1e-12 * (1 + cost)}; }},
      {.start = 1e-8}, 60);
  return std::isfinite(end.promised);
}

}  // namespace seam::measurement
