// A target drawn to another scale than its plan is told from known poses, and only that.
#include "measurement/kinds/points/target/spacing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "measurement/kinds/kinds.h"
#include "sim_core/base/output.h"
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

// The same board as a set, whose rig says where the camera was.
std::vector<std::string> remarks_on(double real_m) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "spacing";
  std::filesystem::create_directories(folder);
  const Seen seen = board(real_m);
  std::string points = "frame,time_s,point,x_m,y_m,z_m,u_px,v_px\n";
  std::string poses = "time_s,x_m,y_m,z_m,qw,qx,qy,qz\n";
  for (size_t i = 0; i < seen.places.size(); ++i) {
    const Vec3& p = seen.places[i];
    points += fmt::format("{0},{0},{1},{2},{3},0,{4:.4f},{5:.4f}\n", i / 30, i % 30, p.x, p.y,
                          seen.seen[i][0], seen.seen[i][1]);
    if (i % 30 != 0) continue;
    const Pose X_WC = seen.cameras[i].inverse();
    const double half = 0.5 * std::atan2(X_WC.R[2].x, X_WC.R[2].z);  // All turn about y.
    poses += fmt::format("{},{:.9f},{:.9f},{:.9f},{:.12f},0,{:.12f},0\n", i / 30, X_WC.p.x,
                         X_WC.p.y, X_WC.p.z, std::cos(half), std::sin(half));
  }
  write_file_atomically(folder / "points.csv", points);
  write_file_atomically(folder / "poses.csv", poses);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: points\ncamera: {width_px: 640, "
                        "height_px: 480}\nnoise: {u_px: 0.1, v_px: 0.1}\nfiles: {points: "
                        "points.csv}\nrig: {poses: poses.csv}\n");
  const auto problem = open_problem(folder);
  const auto model = Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects:\n  pinhole: {fx_px: 500, fy_px: 500, cx_px: 320, cy_px: "
      "240}\n",
      "model"));
  problem->prepare(model);
  return problem->remarks(model);
}

TEST(WrongSpacing, OfASetIsAdvice) {
  EXPECT_THAT(remarks_on(0.030), testing::ElementsAre(testing::HasSubstr(
                                     "is the spacing of the target 0.03 m, not 0.025 m?")));
  EXPECT_THAT(remarks_on(0.025), testing::IsEmpty());
}

}  // namespace
}  // namespace seam::measurement
