// Where the camera was in each view, of sets whose poses are estimated.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "measurement/kinds/points/points_predictor.h"
#include "measurement/kinds/points/points_problem.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

// Standard errors of a pose's turn about the camera's axes: of least squares, with the shift
// estimated beside it. Nothing where the points do not fix it.
std::optional<Vec3> turn_errors(const Cameras& cameras, const std::vector<Sighting>& seen,
                                const Pose& X_CW) {
  std::vector<double> residuals, derivatives;
  if (!pose_residuals(cameras, seen, X_CW, residuals, &derivatives)) return std::nullopt;
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>;
  const Eigen::Map<const Rows> slopes(derivatives.data(),
                                      static_cast<Eigen::Index>(residuals.size()), 6);
  const Eigen::LLT<Eigen::Matrix<double, 6, 6>> factor(slopes.transpose() * slopes);
  if (factor.info() != Eigen::Success) return std::nullopt;
  const Eigen::Matrix<double, 6, 6> covariance =
      factor.solve(Eigen::Matrix<double, 6, 6>::Identity());
  return Vec3(std::sqrt(covariance(0, 0)), std::sqrt(covariance(1, 1)),
              std::sqrt(covariance(2, 2)));
}

}  // namespace

std::vector<PlacedView> PointsProblem::placed_views(const Model& model) const {
  if (data_.rig.type() != Rig::Type::unknown)
    throw InputError(fmt::format(
        "{}: the set knows its poses, expected one whose poses are estimated (rig: {{pose: "
        "unknown}})",
        facts_.file));
  const Evaluation evaluation = evaluate(model, all_groups(), nullptr);
  const Cameras cameras(model, data_.cameras);
  const RowCamera camera(model, data_.cameras, data_.gyroscope.get());
  const std::vector<Vec3> places_W = places_of_rows(data_, effects::target_of(model));
  const double middle_s = 0.5 * camera.clocks.front().line_delay_s * data_.camera.height_px;
  std::vector<PlacedView> views;
  for (size_t frame = 0; frame < data_.rows_of_frame.size(); ++frame) {
    std::vector<int> rows;
    const std::vector<Sighting> seen = sightings(static_cast<int>(frame), places_W, rows);
    Pose X_CW;
    if (seen.empty() || !stored_pose(evaluation.nuisance_values, frame, X_CW)) continue;
    const auto sigma_rad = turn_errors(cameras, seen, X_CW);
    if (!sigma_rad) continue;
    const auto row = static_cast<size_t>(rows.front());
    const double since_s = data_.stamp_s[row] + middle_s;
    views.push_back({.name = data_.frames[frame],
                     .time_ns = data_.rig.reference_ns() + std::llround(1e9 * since_s),
                     .X_WC = X_CW.inverse(),
                     .sigma_rad = *sigma_rad,
                     .exposure_s = data_.exposure_s.empty() ? 0 : data_.exposure_s[row]});
  }
  std::stable_sort(views.begin(), views.end(),
                   [](const PlacedView& a, const PlacedView& b) { return a.time_ns < b.time_ns; });
  return views;
}

}  // namespace seam::measurement
