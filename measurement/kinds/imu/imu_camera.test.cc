#include "measurement/kinds/imu/imu_camera.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "sim_core/base/output.h"
#include "sim_core/base/random.h"
#include "sim_core/body/turn.h"

namespace seam::measurement {
namespace {

// A body that turns about an axis that stays, at a rate that swings.
constexpr double kSwing_radps = 1.2, kFaster = 5.0;  // Once about in 2 pi / kFaster s.
const Vec3 kAxis(0.6, 0.0, 0.8);

double turned_rad(double at_s) {
  return kSwing_radps / kFaster * std::sin(kFaster * at_s);
}

CameraData swung() {
  CameraData data;
  for (int i = 0; i < 1000; ++i) {
    data.at_s.push_back(0.005 * i);
    data.rate_radps.push_back(kSwing_radps * std::cos(kFaster * 0.005 * i) * kAxis);
  }
  return data;
}

TEST(GyroPath, TurnsAsItsRatesAddUp) {
  const CameraData data = swung();
  const GyroPath path(data, {});
  for (const auto& [from, to] : {std::pair(0.5, 0.55), {1.2345, 1.2789}, {2.0, 2.9}}) {
    const Vec3 expected = (turned_rad(to) - turned_rad(from)) * kAxis;
    EXPECT_LT(glm::length(path.turn(from, to) - expected), 2e-5) << from;
  }
}

TEST(GyroPath, TakesOutWhatTheModelSays) {
  CameraData data = swung();
  effects::Inertial inertial;
  inertial.gyro.bias = {0.02, -0.01, 0.03};
  inertial.gyro.scale = {0.05, -0.03, 0.01};
  inertial.gyro.cross[0][2] = 0.04;
  const Vec3 expected = GyroPath(data, {}).turn(1.1, 1.4);
  for (Vec3& rate : data.rate_radps)
    rate = effects::measured_by(inertial, {.rate_radps = rate}, effects::kBiasAt_c).rate_radps;
  EXPECT_LT(glm::length(GyroPath(data, inertial).turn(1.1, 1.4) - expected), 1e-12);
}

std::string row_of(double at_s, const Mat3& R, double sigma_rad) {
  const double w = std::sqrt(std::max(0.0, 1 + R[0][0] + R[1][1] + R[2][2])) / 2;
  return fmt::format("{:.6f},{:.15g},{:.15g},{:.15g},{:.15g},{}\n", at_s, w,
                     (R[1][2] - R[2][1]) / (4 * w), (R[2][0] - R[0][2]) / (4 * w),
                     (R[0][1] - R[1][0]) / (4 * w), sigma_rad);
}

// A sensor at rest beside a camera whose attitudes alone err.
TEST(ImuCamera, ErrorsThatTurnsShareAreWhitened) {
  constexpr double kSigma_rad = 0.02;
  const RandomStream stream{.seed = 4};
  std::string imu = "time_s,wx_radps,wy_radps,wz_radps\n", views = "time_s,qw,qx,qy,qz,sigma_rad\n";
  for (int i = 0; i < 12000; ++i) imu += fmt::format("{:.2f},0.3,3.1,-0.7\n", 0.01 * i);
  uint64_t draw = 0;
  for (int i = 0; i < 1100; ++i) {
    const double at_s = 2 + 0.1 * i;  // Turns of 18 degrees, far from small.
    const Vec3 error(normal(stream, draw), normal(stream, draw + 1), normal(stream, draw + 2));
    draw += 3;
    views +=
        row_of(at_s, rotation_by(at_s * Vec3(0.3, 3.1, -0.7)) * rotation_by(kSigma_rad * error),
               kSigma_rad);
  }
  const std::filesystem::path folder = testing::TempDir() + "imu_camera";
  std::filesystem::create_directories(folder);
  write_file_atomically(folder / "imu.csv", imu);
  write_file_atomically(folder / "attitudes.csv", views);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: imu\n"
                        "files: {imu: imu.csv, attitudes: attitudes.csv}\n");
  const ImuCameraProblem problem(MeasurementSet::open(folder));
  const Evaluation seen = problem.evaluate(Model(), problem.all_groups());
  std::array<double, 5> products{};  // Of scalars that are so many turns apart.
  const size_t n = problem.facts().scalars();
  for (size_t apart = 0; apart < products.size(); ++apart)
    for (size_t i = 0; i + 3 * apart < n; ++i)
      products[apart] += seen.whitened[i] * seen.whitened[i + 3 * apart] / static_cast<double>(n);
  const double close = 5 / std::sqrt(static_cast<double>(n));
  EXPECT_NEAR(products[0], 1, std::sqrt(2.0) * close);
  for (size_t apart = 1; apart < products.size(); ++apart)
    EXPECT_NEAR(products[apart], 0, close) << apart;
  // Their sums within a part are those of two views: far less than of errors of their own.
  EXPECT_NEAR(seen.sigma[0], std::sqrt(2.0) * kSigma_rad, 0.02 * kSigma_rad);
}

}  // namespace
}  // namespace seam::measurement
