#include "measurement/kinds/imu/camera_turns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"
#include "sim_core/body/turn.h"

namespace seam::measurement {
namespace {

// Views farther apart are not compared: a gyroscope's bias adds up, and a turn may pass half of
// one.
constexpr double kMostApart_s = 1;
constexpr double kMostTurn_rad = 2.5;
// No attitude is known better, and none worse says anything of a turn.
constexpr double kLeastSigma_rad = 1e-9, kMostSigma_rad = 1;
constexpr double kMostExposure_s = 100;

std::vector<Vec3> variances_of(const CsvTable& table) {
  std::vector<Vec3> variances(table.rows());
  if (!table.has("sigma_rad") && !table.has("sigma_x_rad"))
    throw InputError(fmt::format(
        "{}: found no standard errors of the attitudes, expected a column sigma_rad, or "
        "sigma_x_rad, sigma_y_rad, sigma_z_rad about the camera's axes",
        table.file()));
  for (int axis = 0; axis < 3; ++axis) {
    const std::string name =
        table.has("sigma_rad") ? "sigma_rad" : fmt::format("sigma_{}_rad", "xyz"[axis]);
    const std::vector<double> sigma = table.numbers(name);
    for (size_t row = 0; row < sigma.size(); ++row) {
      if (!(sigma[row] >= kLeastSigma_rad && sigma[row] <= kMostSigma_rad))
        table.fail(
            row, name, table.cell(row, name),
            fmt::format("a standard error of {:g} to {:g} rad", kLeastSigma_rad, kMostSigma_rad));
      variances[row][axis] = sigma[row] * sigma[row];
    }
  }
  return variances;
}

void read_views(const CsvTable& table, int64_t first_ns, CameraData& data) {
  const std::vector<int64_t> time_ns = table.times_ns("time_s");
  const std::vector<double> w = table.numbers("qw"), x = table.numbers("qx"),
                            y = table.numbers("qy"), z = table.numbers("qz");
  const std::vector<Vec3> variances = variances_of(table);
  std::vector<double> exposure_s(table.rows(), 0);
  if (table.has("exposure_s")) exposure_s = table.numbers("exposure_s");
  for (size_t row = 0; row < table.rows(); ++row) {
    expect_later(table, time_ns, row);
    constexpr double kOff = 0.01;  // More than digits that were cut.
    const double size = w[row] * w[row] + x[row] * x[row] + y[row] * y[row] + z[row] * z[row];
    if (!(exposure_s[row] >= 0 && exposure_s[row] <= kMostExposure_s))
      table.fail(row, "exposure_s", table.cell(row, "exposure_s"),
                 fmt::format("an exposure of 0 to {:g} s", kMostExposure_s));
    if (std::abs(size - 1) > kOff)
      table.fail(row, "qw", table.cell(row, "qw"), "qw, qx, qy, qz of length 1");
    data.views.push_back({.line = table.line(row),
                          .at_s = 1e-9 * static_cast<double>(time_ns[row] - first_ns),
                          .R_WC = rotation_from_quaternion(w[row], x[row], y[row], z[row]),
                          .variance = variances[row],
                          .exposure_s = exposure_s[row]});
  }
  const auto [least, most] = std::minmax_element(exposure_s.begin(), exposure_s.end());
  data.knows_exposure = !exposure_s.empty() && *least != *most;
}

// Whether the gyroscope reads without a gap around both views, whatever the offset.
bool covers(const CameraData& data, double usual_s, double from_s, double to_s) {
  return reads_all(data, usual_s, from_s - kMostOffset_s, to_s + kMostOffset_s);
}

// The inverse of the right Jacobian of a turn's vector.
Eigen::Matrix3d added_by_turns_behind(const Vec3& turn) {
  const double angle = glm::length(turn);
  Eigen::Matrix3d across;
  across << 0, -turn.z, turn.y, turn.z, 0, -turn.x, -turn.y, turn.x, 0;
  constexpr double kSmall = 1e-3;  // There the series says it to 1e-9 and better.
  const double twice = angle < kSmall ? 1.0 / 12
                                      : 1 / (angle * angle) - (1 + maths::cos(angle)) /
                                                                  (2 * angle * maths::sin(angle));
  return Eigen::Matrix3d::Identity() + 0.5 * across + twice * across * across;
}

}  // namespace

CameraData read_camera(const MeasurementSet& set) {
  CameraData data;
  int64_t first_ns = 0;
  static_cast<Gyroscope&>(data) = read_gyroscope(set, first_ns);
  read_views(set.table("attitudes"), first_ns, data);
  const double usual_s = usual_step_s(data);
  std::vector<char> met(data.views.size(), 0);
  for (size_t i = 1; i < data.views.size(); ++i) {
    const AttitudeView &from = data.views[i - 1], &to = data.views[i];
    const Vec3 turn = turn_of(glm::transpose(from.R_WC) * to.R_WC);
    if (to.at_s - from.at_s > kMostApart_s || glm::length(turn) > kMostTurn_rad ||
        !covers(data, usual_s, from.at_s, to.at_s))
      continue;
    // A turn by a small vector behind a turn adds this to its vector; before it, the transposed.
    const Eigen::Matrix3d behind = added_by_turns_behind(turn);
    data.turns.push_back({i - 1, i, turn, behind, behind.transpose()});
    met[i - 1] = met[i] = 1;
  }
  data.left = static_cast<size_t>(std::count(met.begin(), met.end(), 0));
  constexpr size_t kLeastTurns = 30;  // Ten parts of three.
  if (data.turns.size() < kLeastTurns)
    throw InputError(fmt::format(
        "{}: found {} pairs of views less than {} s apart, with readings of the gyroscope from {} "
        "s "
        "before to {} s after them, expected {} or more: bring both to one clock within {} s",
        set.file("attitudes").string(), data.turns.size(), kMostApart_s, kMostOffset_s,
        kMostOffset_s, kLeastTurns, kMostOffset_s));
  return data;
}

}  // namespace seam::measurement
