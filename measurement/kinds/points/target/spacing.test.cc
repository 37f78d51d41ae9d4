// A target drawn to another scale than its plan is told from known poses, and only that.
#include "measurement/kinds/points/target/spacing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

// A robot's camera of 500 px before a board of 6 x 5 points, 25 mm apart by its plan, from places
// around it.
struct Seen {
  std::vector<Vec3> places;
  std::vector<ImagePlace> seen;
  std::vector<Pose> cameras;  // X_CW, by observation.

  static std::optional<ImagePlace> image_by(const Pose& X_CW, const Vec3& p_W, double focal_px) {
    const Vec3 p = X_CW * p_W;
    if (!(p.z > 0)) return std::nullopt;
    return ImagePlace{320 + focal_px * p.x / p.z, 240 + focal_px * p.y / p.z};
  }
  std::optional<WrongSpacing> told() const {
    return wrong_spacing(places, seen,
                         [&](size_t row, const Vec3& p) { return image_by(cameras[row], p, 500); });
  }
};

// `real_m`: how far apart the points are in truth, from the first corner on.
Seen board(double real_m, double focal_px = 500, Vec3 shift = Vec3(0.0), bool moves = true) {
  constexpr RandomStream kNoise{.seed = 4, .stream = 2};
  Seen board;
  for (int view = 0; view < 8; ++view) {
    const double turn = 0.15 * (view - 3.5);
    const Vec3 eye = moves ? Vec3(0.4 * std::sin(turn), 0.05 * (view % 3), -0.4 * std::cos(turn))
                           : Vec3(0, 0, -0.4);
    const Pose X_CW = Pose{rotation_about({0, 1, 0}, moves ? -turn : 0.03 * view), eye}.inverse();
    for (int i = 0; i < 30; ++i) {
      const Vec3 corner(i % 6, i / 6, 0.0);
      const Vec3 truth = real_m * corner + shift;
      const auto at = Seen::image_by(X_CW, truth, focal_px);
      const auto noise = [&](uint64_t axis) {
        return 0.1 * normal(kNoise.child(axis), static_cast<uint64_t>(30 * view + i));
      };
      board.places.push_back(0.025 * corner);
      board.seen.push_back({(*at)[0] + noise(0), (*at)[1] + noise(1)});
      board.cameras.push_back(X_CW);
    }
  }
  return board;
}

TEST(WrongSpacing, IsToldWithItsFactor) {
  const auto told = board(0.030).told();
  ASSERT_TRUE(told.has_value());
  EXPECT_NEAR(told->factor, 1.2, 0.002);
  EXPECT_NEAR(told->neighbour_m, 0.025, 1e-9);
  EXPECT_LT(told->after_px, 0.12);
  EXPECT_GT(told->before_px, 3);
  const auto half = board(0.0125).told();
  ASSERT_TRUE(half.has_value());
  EXPECT_NEAR(half->factor, 0.5, 0.002);
}

TEST(WrongSpacing, IsNotToldWhereAnotherCauseExplains) {
  EXPECT_FALSE(board(0.025).told().has_value());
  EXPECT_FALSE(board(0.025, 500, {0.02, 0.01, 0.03}).told().has_value()) << "elsewhere";
  EXPECT_FALSE(board(0.025, 530).told().has_value()) << "another focal length";
  EXPECT_FALSE(board(0.030, 500, Vec3(0.0), false).told().has_value())
      << "a camera that only turns sees no distances";
}

}  // namespace
}  // namespace seam::measurement
