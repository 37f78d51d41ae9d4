// Poses from exact projections of points whose place is known, and the covariance of noisy ones.
#include "measurement/kinds/points/target/pose_solver.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "effects/registry.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

using effects::Model;

Model lens(double distortion) {
  Model model;
  model.set(effects::find_effect("pinhole"),
            {{.value = 500}, {.value = 510}, {.value = 310}, {.value = 250}});
  if (distortion != 0) {
    model.add_neutral(effects::find_effect("radial_distortion"));
    model.set_value("radial_distortion", 0, distortion);
  }
  return model;
}

struct View {
  const char* name;
  Pose X_CW;
  bool flat;  // A board; else points all over a room.
};

std::vector<View> views() {
  std::vector<View> all;
  for (const double turn : {0.0, 0.3, -0.7}) {
    for (const double roll : {0.0, 2.5}) {
      const Mat3 R = rotation_about(glm::normalize(Vec3(1, -2, 0.3)), turn) *
                     rotation_about(Vec3(0, 0, 1), roll);
      for (const bool flat : {true, false})
        all.push_back({flat ? "board" : "room", {R, Vec3(0.1, -0.05, 2)}, flat});
    }
  }
  return all;
}

// Where a camera sees them: u = fx x / z + cx, the radius stretched to r with r = r0 (1 + k r^2)
// (a division model), which is solved here by iteration.
std::vector<Sighting> sightings(const View& view, double distortion, double noise_px,
                                uint64_t seed) {
  std::vector<Sighting> seen;
  const RandomStream stream{.seed = seed};
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 5; ++k) {
      const Vec3 p_W(0.12 * i - 0.3, 0.12 * k - 0.24,
                     view.flat ? 0 : 0.5 * std::sin(7.0 * i + 3.0 * k));
      const Vec3 p = view.X_CW * p_W;
      const double x = p.x / p.z, y = p.y / p.z, r2 = x * x + y * y;
      double factor = 1;
      for (int n = 0; n < 100; ++n) factor = 1 + distortion * factor * factor * r2;
      const auto at = static_cast<uint64_t>(10 * i + 2 * k);
      seen.push_back({.p_W = p_W,
                      .u_px = 500 * x * factor + 310 + noise_px * normal(stream, at),
                      .v_px = 510 * y * factor + 250 + noise_px * normal(stream, at + 1),
                      .sigma_u = noise_px > 0 ? noise_px : 1,
                      .sigma_v = noise_px > 0 ? noise_px : 1});
    }
  }
  return seen;
}

double angle_between(const Mat3& a, const Mat3& b) {
  const Mat3 d = glm::transpose(a) * b;
  return std::asin(0.5 *
                   glm::length(Vec3(d[1][2] - d[2][1], d[2][0] - d[0][2], d[0][1] - d[1][0])));
}

TEST(PoseSolver, ExactProjectionsGiveThePoseBack) {
  for (const double distortion : {0.0, -0.15}) {
    const effects::Projection projection(lens(distortion), 640, 480);
    for (const View& view : views()) {
      const auto seen = sightings(view, distortion, 0, 1);
      Pose X_CW;
      ASSERT_TRUE(initial_pose(projection, seen, X_CW)) << view.name;
      // The linear solution is exact already, without noise.
      EXPECT_LT(angle_between(X_CW.R, view.X_CW.R), 1e-6) << view.name;
      EXPECT_LT(glm::length(X_CW.p - view.X_CW.p), 1e-6) << view.name;
      ASSERT_TRUE(refine_pose(projection, seen, X_CW)) << view.name;
      EXPECT_LT(angle_between(X_CW.R, view.X_CW.R), 1e-9) << view.name;
      EXPECT_LT(glm::length(X_CW.p - view.X_CW.p), 1e-9) << view.name;
    }
  }
}

// A board whose corners stand a little out of their plane is neither flat nor deep.
TEST(PoseSolver, HeightsOfAnySizeGiveThePoseBack) {
  const effects::Projection projection(lens(0), 640, 480);
  for (const double height_m : {1e-6, 1e-4, 1e-3, 1e-2, 0.05, 0.2}) {
    for (const View& view : views()) {
      std::vector<Sighting> seen = sightings(view, 0, 0, 1);
      for (size_t i = 0; i < seen.size(); ++i) {
        Sighting& s = seen[i];
        s.p_W.z = height_m * std::sin(3.0 * static_cast<double>(i * i));
        const Vec3 p = view.X_CW * s.p_W;
        s.u_px = 500 * p.x / p.z + 310, s.v_px = 510 * p.y / p.z + 250;
      }
      Pose X_CW;
      ASSERT_TRUE(initial_pose(projection, seen, X_CW)) << height_m;
      EXPECT_LT(angle_between(X_CW.R, view.X_CW.R), 1e-8) << height_m;
      EXPECT_LT(glm::length(X_CW.p - view.X_CW.p), 1e-8) << height_m;
    }
  }
}

// From afar a board tilted one way looks much as one tilted the other way: the better of both is
// taken, with noise, too.
TEST(PoseSolver, TiltsOfDistantBoardsAreNotMistaken) {
  const effects::Projection projection(lens(0), 640, 480);
  const Mat3 R = rotation_about(glm::normalize(Vec3(1, 0.4, 0)), 0.5);
  const View far{"far", {R, Vec3(0.4, 0.2, 3)}, true};
  int right = 0;
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    Pose X_CW;
    ASSERT_TRUE(initial_pose(projection, sightings(far, 0, 0.1, seed), X_CW));
    right += angle_between(X_CW.R, far.X_CW.R) < 0.1;
  }
  EXPECT_EQ(right, 40);
}

TEST(PoseSolver, RefinesFromFarOff) {
  const effects::Projection projection(lens(-0.15), 640, 480);
  for (const View& view : views()) {
    const auto seen = sightings(view, -0.15, 0, 1);
    Pose X_CW = {rotation_about(glm::normalize(Vec3(1, 1, 1)), 0.25) * view.X_CW.R,
                 view.X_CW.p + Vec3(0.1, -0.1, 0.4)};
    ASSERT_TRUE(refine_pose(projection, seen, X_CW)) << view.name;
    EXPECT_LT(angle_between(X_CW.R, view.X_CW.R), 1e-8) << view.name;
    EXPECT_LT(glm::length(X_CW.p - view.X_CW.p), 1e-8) << view.name;
  }
}

TEST(PoseSolver, DerivativesAreThoseOfTheResiduals) {
  const effects::Projection projection(lens(-0.15), 640, 480);
  const View view = views()[5];
  const auto seen = sightings(view, -0.15, 0.4, 2);
  std::vector<double> residuals, derivatives, above, below;
  ASSERT_TRUE(pose_residuals(projection, seen, view.X_CW, residuals, &derivatives));
  constexpr double kStep = 1e-5;
  for (int k = 0; k < 6; ++k) {
    const auto moved = [&](double by) {
      Vec3 axis(0.0);
      axis[k % 3] = 1;
      if (k >= 3) return Pose{view.X_CW.R, view.X_CW.p + by * axis};
      const Mat3 R = rotation_about(axis, by);
      return Pose{R * view.X_CW.R, R * view.X_CW.p};
    };
    ASSERT_TRUE(pose_residuals(projection, seen, moved(kStep), above, nullptr));
    ASSERT_TRUE(pose_residuals(projection, seen, moved(-kStep), below, nullptr));
    for (size_t i = 0; i < residuals.size(); ++i) {
      const double slope = (above[i] - below[i]) / (2 * kStep);
      EXPECT_NEAR(derivatives[6 * i + static_cast<size_t>(k)], slope, 1e-4 * (1 + std::abs(slope)));
    }
  }
}

// With noise: chi-square has 2 n - 6 degrees of freedom, and the error of the pose, weighed by the
// information J' J, has 6, whatever the view.
TEST(PoseSolver, NoisyPosesErrAsTheirInformationSays) {
  const effects::Projection projection(lens(0), 640, 480);
  double rest = 0, error = 0, freedom = 0, sets = 0;
  uint64_t seed = 0;
  for (const View& view : views()) {
    for (int set = 0; set < 25; ++set) {
      const auto seen = sightings(view, 0, 0.3, ++seed);
      Pose X_CW;
      ASSERT_TRUE(initial_pose(projection, seen, X_CW) && refine_pose(projection, seen, X_CW));
      std::vector<double> residuals, derivatives;
      ASSERT_TRUE(pose_residuals(projection, seen, X_CW, residuals, &derivatives));
      for (const double r : residuals) rest += r * r;
      freedom += static_cast<double>(residuals.size()) - 6;
      const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>> j(
          derivatives.data(), static_cast<Eigen::Index>(residuals.size()), 6);
      // The small motion from the estimate to the truth, in the solver's own six parameters.
      const Mat3 d = view.X_CW.R * glm::transpose(X_CW.R);
      const Vec3 turn = 0.5 * Vec3(d[1][2] - d[2][1], d[2][0] - d[0][2], d[0][1] - d[1][0]);
      const Vec3 shift = view.X_CW.p - d * X_CW.p;
      Eigen::Matrix<double, 6, 1> away;
      away << turn.x, turn.y, turn.z, shift.x, shift.y, shift.z;
      error += (j * away).squaredNorm();
      ++sets;
    }
  }
  // Means within four standard errors: of a chi-square sqrt(2 freedom).
  EXPECT_NEAR(rest, freedom, 4 * std::sqrt(2 * freedom));
  EXPECT_NEAR(error, 6 * sets, 4 * std::sqrt(12 * sets));
}

TEST(PoseSolver, RefusesWhatTellsNoPose) {
  const effects::Projection projection(lens(0), 640, 480);
  auto seen = sightings(views()[0], 0, 0, 1);
  Pose X_CW;
  seen.resize(3);
  EXPECT_FALSE(initial_pose(projection, seen, X_CW));
  seen.clear();
  for (const Sighting& s : sightings(views()[0], 0, 0, 1)) {
    if (std::abs(s.p_W.y) < 1e-9) seen.push_back(s);  // A row of the board: a line.
  }
  ASSERT_EQ(seen.size(), 6u);
  EXPECT_FALSE(initial_pose(projection, seen, X_CW));
}

}  // namespace
}  // namespace seam::measurement
