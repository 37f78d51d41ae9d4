#include "tools/experiments/head_swing/swing_explained.h"

#include <Eigen/Dense>
#include <cmath>

namespace seam::tools {
namespace {

// The sensor model of the SDK's particle filter.
constexpr double kBearingSigma_rad =
    0.03 + 0.7 / 80.95;               // Its floor and an edge's in the colour layer.
constexpr double kRangeSigma = 0.10;  // Relative.

}  // namespace

PositionOffset explained_offset(const std::vector<Sighting>& sightings, const Pose2& truth,
                                bool bearings, bool ranges) {
  // Seen minus true = J * (x, y, theta), for each sighting's bearing and relative range.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const auto add = [&](const Eigen::Vector3d& J, double error, double sigma) {
    information += J * J.transpose() / (sigma * sigma);
    sum += J * error / (sigma * sigma);
  };
  for (const Sighting& s : sightings) {
    const double dx = kBeaconPlaces[s.landmark].x_m - truth.x_m,
                 dy = kBeaconPlaces[s.landmark].y_m - truth.y_m;
    const double square = dx * dx + dy * dy;
    add({dy / square, -dx / square, -1}, bearings ? s.bearing_error_rad : 0, kBearingSigma_rad);
    if (std::isfinite(s.range_error))
      add({-dx / square, -dy / square, 0}, ranges ? s.range_error : 0, kRangeSigma);
  }
  const Eigen::LDLT<Eigen::Matrix3d> solver(information);
  if (solver.info() != Eigen::Success || solver.rcond() < 1e-12) return {};
  const Eigen::Vector3d offset = solver.solve(sum);
  return {1e3 * offset.x(), 1e3 * offset.y()};
}

}  // namespace seam::tools
