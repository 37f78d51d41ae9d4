#include "measurement/kinds/imu/imu_camera.h"

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "measurement/kinds/imu/imu_data.h"
#include "measurement/numerics/moments.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"
#include "sim_core/body/turn.h"

namespace seam::measurement {
namespace {

constexpr size_t kCameraParts = 10;  // Of the recording, that are held out in turn or together.

Eigen::Matrix3d spread_of(const AttitudeView& view) {
  return Eigen::Vector3d(view.variance.x, view.variance.y, view.variance.z).asDiagonal();
}

double sample_time_of(const AttitudeView& view, const effects::Inertial& inertial) {
  return view.at_s +
         std::clamp(offset_at(inertial, view.exposure_s), -kMostOffset_s, kMostOffset_s);
}

}  // namespace

ImuCameraProblem::ImuCameraProblem(const MeasurementSet& set) : data_(read_camera(set)) {
  add_facts(set);
}

void ImuCameraProblem::add_facts(const MeasurementSet& set) {
  facts_.set.kind = effects::kImu;
  facts_.title = set.title;
  facts_.fingerprint = set.fingerprint();
  facts_.file = set.file("attitudes").string();
  for (const char axis : {'x', 'y', 'z'})
    facts_.channels.push_back({.name = fmt::format("turn_{}_rad", axis)});
  for (size_t part = 0; part < kCameraParts; ++part)
    facts_.groups.push_back(fmt::format("part {}", part + 1));
  const GyroPath path(data_, {});
  const size_t n = data_.turns.size();
  std::vector<double> exposure;
  std::array<std::vector<double>, kAxes> rate, gain;
  for (size_t row = 0; row < n; ++row) {
    const AttitudeView &from = data_.views[data_.turns[row].from],
                       &to = data_.views[data_.turns[row].to];
    facts_.line_of_row.push_back(to.line);
    facts_.group_of_row.push_back(static_cast<int>(row * kCameraParts / n));
    facts_.time_of_row.push_back(to.at_s);
    exposure.push_back(to.exposure_s);
    const Vec3 at = path.rate(0.5 * (from.at_s + to.at_s)),
               more = path.rate(to.at_s) - path.rate(from.at_s);
    for (size_t axis = 0; axis < kAxes; ++axis) {
      rate[axis].push_back(at[static_cast<int>(axis)]);
      gain[axis].push_back(more[static_cast<int>(axis)]);
      facts_.row_of.push_back(static_cast<int>(row));
      facts_.channel_of.push_back(static_cast<int>(axis));
    }
  }
  for (size_t axis = 0; axis < kAxes; ++axis) {
    std::vector<double> sigmas;
    const auto at = static_cast<Eigen::Index>(axis);
    for (const CameraTurn& turn : data_.turns)
      sigmas.push_back(std::sqrt(covariance(turn)(at, at)));
    facts_.channels[axis].noise = median_of(sigmas);
  }
  auto& all = facts_.covariates;
  all.push_back({.name = "time", .values = facts_.time_of_row});
  if (data_.knows_exposure) all.push_back({.name = "exposure_s", .values = std::move(exposure)});
  for (size_t axis = 0; axis < kAxes; ++axis) {
    all.push_back({.name = kImuColumns[axis], .values = std::move(rate[axis])});
    all.push_back(
        {.name = fmt::format("gain_of_w{}_radps", "xyz"[axis]), .values = std::move(gain[axis])});
  }
  if (data_.left > 0)
    facts_.notes.push_back(
        fmt::format("{} views take no part: no view stands within a second of them, the camera "
                    "turned too far between, or the gyroscope does not cover them by {} s",
                    data_.left, kMostOffset_s));
}

Eigen::Matrix3d ImuCameraProblem::covariance(const CameraTurn& turn) const {
  return turn.by_to * spread_of(data_.views[turn.to]) * turn.by_to.transpose() +
         turn.by_from * spread_of(data_.views[turn.from]) * turn.by_from.transpose();
}

// Its three axes stay together.
bool ImuCameraProblem::takes_part(size_t row) const {
  return !left_out(kAxes * row) && !left_out(kAxes * row + 1) && !left_out(kAxes * row + 2);
}

Vec3 ImuCameraProblem::predicted(const GyroPath& path, const effects::Inertial& inertial,
                                 const Mat3& to_camera, const CameraTurn& turn) const {
  return to_camera * path.turn(sample_time_of(data_.views[turn.from], inertial),
                               sample_time_of(data_.views[turn.to], inertial));
}

// Turns that follow each other share the error of the view between, so that each one's is foreseen
// from the one before: a Cholesky factor of blocks.
std::vector<double> ImuCameraProblem::whitened(const std::vector<double>& by_scalar,
                                               const Groups& groups,
                                               std::vector<double>* log_det) const {
  std::vector<double> out(by_scalar.size(), 0);
  Eigen::LLT<Eigen::Matrix3d> factor;  // Of the turn before: its own part of the covariance,
  Eigen::Vector3d before;              // and of what stands there.
  size_t row_before = data_.turns.size();
  for (size_t row = 0; row < data_.turns.size(); ++row) {
    const auto group = static_cast<size_t>(facts_.group_of_row[row]);
    if (!groups[group] || !takes_part(row)) continue;
    const CameraTurn& turn = data_.turns[row];
    Eigen::Matrix3d own = covariance(turn);
    Eigen::Vector3d value(by_scalar[kAxes * row], by_scalar[kAxes * row + 1],
                          by_scalar[kAxes * row + 2]);
    if (row_before + 1 == row && facts_.group_of_row[row_before] == facts_.group_of_row[row] &&
        data_.turns[row_before].to == turn.from) {
      const Eigen::Matrix3d shared = -turn.by_from * spread_of(data_.views[turn.from]) *
                                     data_.turns[row_before].by_to.transpose();
      value -= shared * factor.solve(before);
      own -= shared * factor.solve(shared.transpose());
    }
    factor.compute(own);
    const Eigen::Vector3d free = factor.matrixL().solve(value);
    for (size_t axis = 0; axis < kAxes; ++axis) {
      const auto at = static_cast<Eigen::Index>(axis);
      out[kAxes * row + axis] = free[at];
      if (log_det) (*log_det)[group] += 2 * std::log(factor.matrixLLT()(at, at));
    }
    before = value, row_before = row;
  }
  return out;
}

Evaluation ImuCameraProblem::evaluate(const Model& model, const Groups& groups,
                                      const Evaluation*) const {
  const effects::Inertial inertial = effects::inertial_of(model);
  const GyroPath path(data_, inertial);
  const Mat3 to_camera = glm::transpose(effects::camera_axes(inertial));
  Evaluation evaluation;
  const size_t n = facts_.scalars();
  evaluation.used.assign(n, 0);
  evaluation.residual.assign(n, 0);
  evaluation.sigma.assign(n, 1);
  for (size_t row = 0; row < data_.turns.size(); ++row) {
    const CameraTurn& turn = data_.turns[row];
    const bool chosen = groups[static_cast<size_t>(facts_.group_of_row[row])];
    const Eigen::Matrix3d spread = covariance(turn);
    const Vec3 error =
        chosen ? turn.turn_rad - predicted(path, inertial, to_camera, turn) : Vec3(0.0);
    for (size_t axis = 0; axis < kAxes; ++axis) {
      const size_t scalar = kAxes * row + axis;
      const auto at = static_cast<Eigen::Index>(axis);
      evaluation.sigma[scalar] = std::sqrt(spread(at, at));
      if (!chosen) continue;
      evaluation.residual[scalar] = error[static_cast<int>(axis)];
      evaluation.used[scalar] = takes_part(row);
      evaluation.valid = evaluation.valid && std::isfinite(evaluation.residual[scalar]);
    }
  }
  evaluation.log_det.assign(facts_.groups.size(), 0);
  evaluation.whitened = whitened(evaluation.residual, groups, &evaluation.log_det);
  return evaluation;
}

std::vector<std::vector<double>> ImuCameraProblem::following(
    const Model&, const Groups& groups, const Evaluation& here,
    std::vector<std::vector<double>> columns) const {
  for (std::vector<double>& column : columns) {
    for (size_t scalar = 0; scalar < column.size(); ++scalar) column[scalar] *= here.sigma[scalar];
    column = whitened(column, groups, nullptr);
  }
  return columns;
}

void ImuCameraProblem::check_model(const Model& model) const {
  expect_inertial(*this, model);
}

std::string ImuCameraProblem::not_testable(const Model& model, const EffectDefinition& effect,
                                           size_t parameter) const {
  const effects::Inertial by = tried_alone(effect, parameter);
  if (by.camera_offset_of_exposure != 0 && !data_.knows_exposure)
    return "attitudes have no exposure_s that differs from view to view";
  if (by.gyro.per_k != effects::Triad{} && data_.temperature_c.empty())
    return "no temperature was logged";
  if (!is_of_camera(by) && !moves_rates(by.gyro))
    return "turns between views of a camera do not show it: take a set of readings alone";
  return Problem::not_testable(model, effect, parameter);
}

// Where the sizes of both turns agree best, whatever the axes.
std::vector<double> ImuCameraProblem::best_offset(const Model& model) const {
  effects::Inertial inertial = effects::inertial_of(model);
  const GyroPath path(data_, inertial);
  const double already_s = inertial.camera_offset_s;
  // Hours of views tell a start no better than so many of them.
  constexpr size_t kEnough = 5000;
  const size_t stride = (data_.turns.size() + kEnough - 1) / kEnough;
  double best_s = 0, least = HUGE_VAL;
  constexpr double kStep_s = 0.002;  // Of hands that swing twice a second, a fortieth of a radian.
  for (double offset_s = -kMostOffset_s; offset_s <= kMostOffset_s; offset_s += kStep_s) {
    inertial.camera_offset_s = offset_s;
    double sum = 0;
    for (size_t i = 0; i < data_.turns.size(); i += stride) {
      const CameraTurn& turn = data_.turns[i];
      const double apart =
          glm::length(turn.turn_rad) - glm::length(predicted(path, inertial, Mat3(1.0), turn));
      sum += apart * apart;
    }
    if (sum < least) least = sum, best_s = offset_s;
  }
  return {best_s - already_s};
}

// The turn that brings all of the gyroscope's turns nearest to the camera's (Wahba's problem).
std::vector<double> ImuCameraProblem::best_turn(const Model& model) const {
  effects::Inertial inertial = effects::inertial_of(model);
  const GyroPath path(data_, inertial);
  // Sizes agree whatever the axes: without its time the turn is sought at theirs.
  inertial.camera_offset_s += best_offset(model)[0];
  Eigen::Matrix3d together = Eigen::Matrix3d::Zero();
  for (const CameraTurn& turn : data_.turns) {
    const Vec3 sensor = predicted(path, inertial, Mat3(1.0), turn);
    const Vec3& camera = turn.turn_rad;
    together += Eigen::Vector3d(sensor.x, sensor.y, sensor.z) *
                Eigen::RowVector3d(camera.x, camera.y, camera.z);
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(together, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d upright = Eigen::Matrix3d::Identity();
  upright(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  const Eigen::Matrix3d R_IC = svd.matrixU() * upright * svd.matrixV().transpose();
  Mat3 R;
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) R[column][row] = R_IC(row, column);
  const Vec3 turn = turn_of(R);
  const effects::Triad& already = inertial.camera_turn_rad;
  return {turn.x - already[0], turn.y - already[1], turn.z - already[2]};
}

std::vector<std::vector<double>> ImuCameraProblem::starts(const Model& model,
                                                          const EffectDefinition& effect) const {
  const effects::Inertial by = tried_alone(effect, 0);
  std::vector<double> start;
  if (by.camera_offset_s != 0) start = best_offset(model);
  if (by.camera_turn_rad != effects::Triad{}) start = best_turn(model);
  if (start.empty()) return Problem::starts(model, effect);
  while (start.size() < effect.parameters.size())
    start.push_back(effect.parameters[start.size()].neutral);
  return {start};
}

std::vector<Finding> ImuCameraProblem::findings(const Model& model) const {
  const effects::Inertial inertial = effects::inertial_of(model);
  if (inertial.camera_offset_of_exposure == 0) return {};
  std::vector<double> exposures;
  for (const AttitudeView& view : data_.views) exposures.push_back(view.exposure_s);
  const double usual_s = median_of(exposures);
  const double offset_s = offset_at(inertial, usual_s);
  return {{.what = "offset",
           .name = "usual exposure",
           .values = {{"exposure_s", usual_s}, {"offset_s", offset_s}},
           .text = fmt::format("At the usual exposure of {:.4g} ms the sensor's time is the "
                               "camera's plus {:.4g} ms.",
                               1e3 * usual_s, 1e3 * offset_s)}};
}

}  // namespace seam::measurement
