#include "sim_core/base/maths.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>

#include "sim_core/base/hash.h"
#include "sim_core/base/pose.h"
#include "sim_core/base/random.h"
#include "sim_core/base/sines.h"

namespace seam {
namespace {

double ulps(double a, double b) {
  return std::abs(a - b) / std::abs(std::nextafter(b, INFINITY) - b);
}

TEST(Maths, AgreesWithTheSystemLibraryWithinTwoUlps) {
  for (int i = -2000; i <= 2000; ++i) {
    const double x = i * 0.00713 + 1e-5;
    EXPECT_LE(ulps(maths::sin(x), std::sin(x)), 2) << x;
    EXPECT_LE(ulps(maths::cos(x), std::cos(x)), 2) << x;
    EXPECT_LE(ulps(maths::tan(x), std::tan(x)), 2) << x;
    EXPECT_LE(ulps(maths::atan2(x, 0.37), std::atan2(x, 0.37)), 2) << x;
    EXPECT_LE(ulps(maths::exp(x), std::exp(x)), 2) << x;
    if (x > 0) {
      EXPECT_LE(ulps(maths::log(x), std::log(x)), 2) << x;
      EXPECT_LE(ulps(maths::pow(x, 1.7), std::pow(x, 1.7)), 2) << x;
    }
  }
}

TEST(Maths, BitsAreTheSameEverywhere) {
  // A golden fingerprint: the slow matrix runs this program under other CPU models and compilers.
  Hasher hasher;
  for (int i = 1; i < 5000; ++i) {
    const double x = i * 0.00313;
    for (double y : {maths::sin(x), maths::cos(x), maths::tan(x), maths::exp(-x), maths::log(x),
                     maths::pow(x, 0.3), maths::atan2(x, 1 - x), maths::asin(1 / (1 + x)),
                     maths::acos(1 / (1 + x))}) {
      hasher.add(y);
    }
  }
  EXPECT_EQ(to_hex(hasher.digest()), "14b9c09c537b1efe");
}

TEST(Maths, WrapAngleKeepsTheAngleAndTheHalfOpenInterval) {
  EXPECT_DOUBLE_EQ(maths::wrap_angle(maths::kPi), maths::kPi);
  EXPECT_DOUBLE_EQ(maths::wrap_angle(-maths::kPi), maths::kPi);
  for (int i = -100; i <= 100; ++i) {
    const double angle = i * 0.37;
    const double wrapped = maths::wrap_angle(angle);
    EXPECT_GT(wrapped, -maths::kPi);
    EXPECT_LE(wrapped, maths::kPi);
    EXPECT_NEAR(std::remainder(wrapped - angle, 2 * maths::kPi), 0, 1e-12);
  }
}

TEST(Pose, CameraAxesAndRotationSigns) {
  // The camera looks along +x of the link, image right is -y, image down is -z.
  const Mat3 R_LC = link_to_camera_axes();
  EXPECT_EQ(R_LC * Vec3(0, 0, 1), Vec3(1, 0, 0));
  EXPECT_EQ(R_LC * Vec3(1, 0, 0), Vec3(0, -1, 0));
  EXPECT_EQ(R_LC * Vec3(0, 1, 0), Vec3(0, 0, -1));
  // Positive yaw turns left, positive rotation about +y turns down.
  EXPECT_GT((rotation_about({0, 0, 1}, 0.1) * Vec3(1, 0, 0)).y, 0);
  EXPECT_LT((rotation_about({0, 1, 0}, 0.1) * Vec3(1, 0, 0)).z, 0);
}

TEST(Pose, InverseAndComposition) {
  const Pose X_AB{rotation_zyx(0.3, -0.2, 1.1), {1, 2, 3}};
  const Pose X_BC{rotation_about({0, 0.6, 0.8}, 0.7), {-1, 0.5, 0}};
  const Vec3 p_C{0.1, 0.2, 0.3};
  const Vec3 there = (X_AB * X_BC) * p_C;
  const Vec3 step_by_step = X_AB * (X_BC * p_C);
  const Vec3 back = (X_AB * X_BC).inverse() * there;
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(there[i], step_by_step[i], 1e-15);
    EXPECT_NEAR(back[i], p_C[i], 1e-15);
  }
  const Mat3 R =
      rotation_from_quaternion(std::cos(0.35), 0, 0.6 * std::sin(0.35), 0.8 * std::sin(0.35));
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) EXPECT_NEAR(R[c][r], X_BC.R[c][r], 1e-15);
  }
}

// Joint angles, tiny and huge ones, zeros of both signs.
TEST(Maths, SinesOfPairsHaveTheBitsOfSingleOnes) {
  const auto bits = [](double value) { return std::bit_cast<uint64_t>(value); };
  uint64_t other = 0;
  const auto check = [&](double a, double b) {
    const auto pair = maths::sines_and_cosines(a, b);
    other += bits(pair[0].sin) != bits(maths::sin(a)) || bits(pair[0].cos) != bits(maths::cos(a));
    other += bits(pair[1].sin) != bits(maths::sin(b)) || bits(pair[1].cos) != bits(maths::cos(b));
  };
  for (uint64_t i = 0; i < 200'000; ++i) {
    constexpr double kSpans[] = {4, 0.01, 1e-9, 300, 1e7, 1e17};
    const auto draw = [&](uint64_t k) {
      return kSpans[(i + k) % 6] * (2 * uniform({.seed = 9, .stream = i}, k) - 1);
    };
    check(draw(0), draw(1));
  }
  check(0.0, -0.0), check(-0.0, 1.5), check(2.0, 0.0);
  EXPECT_EQ(other, 0u);
  const auto three = maths::sines_and_cosines(0.1, -0.7, 2.9);
  EXPECT_EQ(bits(three[1].cos), bits(maths::cos(-0.7)));
  EXPECT_EQ(bits(three[2].sin), bits(maths::sin(2.9)));
}

}  // namespace
}  // namespace seam
