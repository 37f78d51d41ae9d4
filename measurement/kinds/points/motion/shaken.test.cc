// Views of a board by a camera that shakes, beside a gyroscope: sets are made here by formulas of
// their own, the row of each corner by iteration of its own instant, and rates by differences.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>

#include "effects/registry.h"
#include "measurement/kinds/kinds.h"
#include "measurement/search/models/add_effects.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {
namespace shaken {

using testing::HasSubstr;
using Triple = std::array<double, 3>;

constexpr double kPeriod_s = 0.04, kFocal_px = 520, kNoise_px = 0.2, kApart_s = 0.5;
constexpr double kLineDelay_s = 5e-5;  // 24 ms over 480 rows.
constexpr double kOffset_s = 0.03;
constexpr Triple kMount = {0.4, -1.1, 0.7}, kBias = {0.02, -0.01, 0.015};

struct Shaken {
  std::string name;
  uint64_t seed = 1;
  int views = 16;
  std::string rig = "imu", files = "{points: points.csv, imu: imu.csv}";
  double from_s = -0.5, to_s = 8.5;  // What the gyroscope covers, by the camera's clock.
};

// p turned by a vector.
Triple turned(const Triple& w, const Triple& p) {
  const double angle = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
  const double s = angle > 0 ? std::sin(angle) / angle : 1;
  const double c = angle > 0 ? (1 - std::cos(angle)) / (angle * angle) : 0.5;
  const auto cross = [&](const Triple& b) {
    return Triple{w[1] * b[2] - w[2] * b[1], w[2] * b[0] - w[0] * b[2], w[0] * b[1] - w[1] * b[0]};
  };
  const Triple once = cross(p), twice = cross(once);
  Triple out;
  for (size_t i = 0; i < 3; ++i) out[i] = p[i] + s * once[i] + c * twice[i];
  return out;
}

// Waves of 1 to 5 Hz about slow ones, in each of six coordinates.
class Shaking {
 public:
  explicit Shaking(uint64_t seed) : seed_(seed) {}

  // A point of the board, which leans by 0.35 rad half a metre before the camera.
  Triple seen(double t_s, const Triple& p) const {
    const Triple leaning = {std::cos(0.35) * p[0] + std::sin(0.35) * p[2], p[1],
                            -std::sin(0.35) * p[0] + std::cos(0.35) * p[2] + 0.5};
    Triple out = turned(turn(t_s), leaning);
    for (uint64_t i = 0; i < 3; ++i) out[i] += at(3 + i, 0.1, t_s);
    return out;
  }
  // The camera's own rate, about its own axes.
  Triple rate(double t_s) const {
    constexpr double kStep_s = 1e-5;
    Triple rate = {};
    for (size_t k = 0; k < 3; ++k) {
      // How a direction that stands still moves in the camera's axes: -rate x direction.
      Triple axis = {}, back = turn(t_s);
      axis[k] = 1;
      for (double& b : back) b = -b;
      const Triple still = turned(back, axis);
      const Triple before = turned(turn(t_s - kStep_s), still),
                   after = turned(turn(t_s + kStep_s), still);
      const auto moved = [&](size_t i) { return (after[i] - before[i]) / (2 * kStep_s); };
      rate[(k + 2) % 3] -= 0.5 * moved((k + 1) % 3);
      rate[(k + 1) % 3] += 0.5 * moved((k + 2) % 3);
    }
    return rate;
  }

 private:
  double at(uint64_t coordinate, double speed, double t_s) const {
    double sum = 0;
    for (uint64_t k = 0; k < 4; ++k) {
      const uint64_t number = 4 * coordinate + k;
      const double rate = 2 * M_PI * (k == 0 ? 0.1 : 1 + 4 * uniform({seed_, 2}, number));
      sum += 0.6 * (k == 0 ? 0.2 : 1) * speed * normal({seed_, 1}, number) / rate *
             std::sin(rate * t_s + 2 * M_PI * uniform({seed_, 3}, number));
    }
    return sum;
  }
  Triple turn(double t_s) const { return {at(0, 1.5, t_s), at(1, 1.5, t_s), at(2, 1.5, t_s)}; }

  uint64_t seed_;
};

std::filesystem::path made(const Shaken& set) {
  const auto folder = std::filesystem::path(testing::TempDir()) / ("shaken-" + set.name);
  std::filesystem::create_directories(folder);
  const Shaking hand(set.seed);
  std::string rows = "frame,time_s,point,x_m,y_m,z_m,u_px,v_px\n";
  for (int view = 0; view < set.views; ++view) {
    for (int point = 0; point < 63; ++point) {
      const Triple p = {0.035 * (point % 9 - 4), 0.035 * (point / 9 - 3), 0};
      double u = 0, v = 240;
      for (int round = 0; round < 40; ++round) {
        const Triple q = hand.seen(kApart_s * view + kLineDelay_s * v, p);
        u = kFocal_px * q[0] / q[2] + 319.5, v = kFocal_px * q[1] / q[2] + 239.5;
      }
      const auto draw = static_cast<uint64_t>(2 * (view * 1000 + point));
      u += kNoise_px * normal({set.seed, 4}, draw),
          v += kNoise_px * normal({set.seed, 4}, draw + 1);
      if (u < 0 || v < 0 || u > 639 || v > 479) continue;
      rows += fmt::format("{},{:.3f},{},{:.6f},{:.6f},0,{:.5f},{:.5f}\n", view, kApart_s * view,
                          point, p[0], p[1], u, v);
    }
  }
  write_file_atomically(folder / "points.csv", rows);
  std::string readings = "time_s,wx_radps,wy_radps,wz_radps\n";
  for (double t_s = set.from_s; t_s < set.to_s; t_s += 0.005) {
    const Triple r = turned(kMount, hand.rate(t_s));
    readings += fmt::format("{:.6f},{:.7f},{:.7f},{:.7f}\n", t_s + kOffset_s, r[0] + kBias[0],
                            r[1] + kBias[1], r[2] + kBias[2]);
  }
  write_file_atomically(folder / "imu.csv", readings);
  write_file_atomically(
      folder / "measurement.yaml",
      fmt::format("format: seam-measurement/1\nkind: points\n"
                  "camera: {{width_px: 640, height_px: 480, frame_period_s: {}}}\n"
                  "noise: {{u_px: {}, v_px: {}}}\ngroup: frame\nfiles: {}\nrig: {}\n",
                  kPeriod_s, kNoise_px, kNoise_px, set.files, set.rig));
  return folder;
}

// What stands at the sensor is known, or free and begun a little off.
Model camera(double line_delay_s, bool is_free = false) {
  const auto value = [&](double truth, double off) {
    return is_free ? fmt::format("{{value: {}, free: true}}", truth + off)
                   : fmt::format("{}", truth);
  };
  std::string text =
      "format: seam-model/1\neffects: {pinhole: {fx_px: {value: 500, free: true}, fy_px: {value: "
      "500, free: true}, cx_px: {value: 319.5, free: true}, cy_px: {value: 239.5, free: true}}";
  text += fmt::format(
      ", camera_imu_offset: {{offset_s: {}}}, camera_imu_rotation: {{x_rad: {}, y_rad: {}, z_rad: "
      "{}}}, gyro_bias: {{x_radps: {}, y_radps: {}, z_radps: {}}}",
      value(kOffset_s, 0.004), value(kMount[0], 0.05), value(kMount[1], -0.05),
      value(kMount[2], 0.05), kBias[0], kBias[1], kBias[2]);
  if (line_delay_s != 0)
    text +=
        fmt::format(", rolling_shutter: {{line_delay_s: {{value: {}, free: true}}}}", line_delay_s);
  return Model::from_config(ConfigNode::from_text(text + "}\n", "test.yaml"));
}

TEST(Shaken, TheReadOutTimeLiesWithinItsError) {
  double sum2 = 0;
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    const auto problem = open_problem(made({.name = "error", .seed = seed}));
    const auto added = add_effects(*problem, camera(0), {effects::find_effect("rolling_shutter")});
    const effects::ModelEffect* effect = added.model.find("rolling_shutter");
    ASSERT_NE(effect, nullptr) << seed;
    const effects::ParameterValue& delay = effect->parameters[0];
    EXPECT_LT(delay.sigma.value_or(1), 0.06 * kLineDelay_s) << seed;
    EXPECT_NEAR(added.error_after, 1, 0.08) << seed;
    sum2 += std::pow((delay.value - kLineDelay_s) / delay.sigma.value_or(0), 2);
  }
  // Chi-square of four: between these in 99 %.
  EXPECT_GT(sum2, 0.2);
  EXPECT_LT(sum2, 14.9);
}

TEST(Shaken, TimeAndAxesOfTheSensorAreFitted) {
  const auto problem = open_problem(made({.name = "free", .seed = 5}));
  const auto added =
      add_effects(*problem, camera(0, /*is_free=*/true), {effects::find_effect("rolling_shutter")});
  const auto expect_found = [&](const char* name, size_t parameter, double truth, double most) {
    const auto& found = added.model.find(name)->parameters[parameter];
    EXPECT_LT(found.sigma.value_or(1), most) << name << parameter;
    EXPECT_NEAR(found.value, truth, 3.5 * found.sigma.value_or(0)) << name << parameter;
  };
  expect_found("rolling_shutter", 0, kLineDelay_s, 0.06 * kLineDelay_s);
  expect_found("camera_imu_offset", 0, kOffset_s, 4e-3);
  for (size_t axis = 0; axis < 3; ++axis)
    expect_found("camera_imu_rotation", axis, kMount[axis], 0.15);
  EXPECT_NEAR(added.error_after, 1, 0.08);
}

TEST(Shaken, WhatTheGyroscopeDoesNotCoverIsRefused) {
  const auto refused = [](const Shaken& set, const std::string& why) {
    EXPECT_THAT([&] { open_problem(made(set)); },
                testing::ThrowsMessage<InputError>(HasSubstr(why)))
        << set.name;
  };
  refused({.name = "early", .to_s = 6.2}, "points.csv:");
  refused({.name = "early", .to_s = 6.2}, "imu.csv reads without a gap");
  refused({.name = "late", .from_s = 0.5}, "imu.csv reads without a gap");
  refused({.name = "none", .files = "{points: points.csv}"}, "no table imu");
  refused({.name = "word", .rig = "gyroscope"}, "the word imu");
  refused({.name = "knots", .rig = "{pose: unknown, motion: imu, knot_s: 0.1}"}, "knot_s");
  const auto problem = open_problem(made({.name = "offset", .from_s = -0.1, .to_s = 7.6}));
  Model away = camera(kLineDelay_s);
  away.set_value("camera_imu_offset", 0, -0.2);
  EXPECT_THAT([&] { problem->check_model(away); },
              testing::ThrowsMessage<InputError>(HasSubstr("camera_imu_offset")));
}

TEST(Shaken, RowsReadAtOnceShowNoTurn) {
  const auto problem = open_problem(made({.name = "once", .rig = "{pose: unknown, motion: imu}"}));
  const effects::EffectDefinition& rotation = *effects::find_effect("camera_imu_rotation");
  EXPECT_TRUE(problem->acts(rotation));
  EXPECT_FALSE(problem->acts(*effects::find_effect("gyro_white_noise")));
  EXPECT_THAT(problem->not_testable(camera(0), rotation, 0), HasSubstr("rolling_shutter"));
  EXPECT_EQ(problem->not_testable(camera(kLineDelay_s), rotation, 0), "");
  EXPECT_THAT(problem->remarks(camera(kLineDelay_s)),
              testing::Contains(HasSubstr("as the gyroscope says")));
}

}  // namespace shaken
}  // namespace
}  // namespace seam::measurement
