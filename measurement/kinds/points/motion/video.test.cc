// Videos of a board by a camera that is moved by hand: their sets are made here by formulas of
// their own, the row of each corner by iteration of its own instant.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <functional>

#include "effects/registry.h"
#include "measurement/fitting/assess.h"
#include "measurement/kinds/kinds.h"
#include "measurement/search/models/add_effects.h"
#include "measurement/search/models/compare.h"
#include "measurement/search/search.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

using testing::HasSubstr;

constexpr double kPeriod_s = 0.04, kFocal_px = 520, kNoise_px = 0.2;
constexpr double kLineDelay_s = 5e-5;  // 24 ms over 480 rows.

struct Video {
  std::string name;
  double line_delay_s = 0;
  int frames = 24;
  int along = 8, across = 6;
  double turning_rad_per_s = 1;  // Root mean square.
  uint64_t seed = 1;
  std::string rig = "{pose: unknown, motion: spline}";
  std::function<bool(int)> is_kept = [](int) { return true; };  // By frame.
  // Right of the middle stands another board, turned out of the plane of the first; the first
  // frames do not see it, and the last see it alone.
  bool two_boards = false;
  double displaced_m = 0;  // Each coordinate of each point's displacement, one sigma.
};

using Triple = std::array<double, 3>;

// A hand: three waves of up to 1.6 Hz in each of six coordinates, scaled to a speed.
class Hand {
 public:
  explicit Hand(const Video& video) {
    for (int i = 0; i < 6; ++i) {
      double speed2 = 0;
      for (int k = 0; k < 3; ++k) {
        const auto at = static_cast<uint64_t>(3 * i + k);
        waves_[i][k] = {.size = normal({video.seed, 1}, at),
                        .rate = 2 * M_PI * (0.4 + 1.2 * uniform({video.seed, 2}, at)),
                        .phase = 2 * M_PI * uniform({video.seed, 3}, at)};
        speed2 += 0.5 * std::pow(waves_[i][k].size * waves_[i][k].rate, 2);
      }
      const double wanted = i < 3 ? video.turning_rad_per_s / std::sqrt(3.0) : 0.05;
      for (Wave& wave : waves_[i]) wave.size *= wanted / std::sqrt(speed2);
    }
  }

  // A point of the board, which leans by 0.35 rad half a metre before the camera, in its frame.
  Triple seen(double t_s, const Triple& p_m) const {
    const Triple leaning = {std::cos(0.35) * p_m[0] + std::sin(0.35) * p_m[2], p_m[1],
                            -std::sin(0.35) * p_m[0] + std::cos(0.35) * p_m[2] + 0.5};
    const Triple w = {at(0, t_s), at(1, t_s), at(2, t_s)};
    const double angle = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    const double s = angle > 0 ? std::sin(angle) / angle : 1,
                 c = angle > 0 ? (1 - std::cos(angle)) / (angle * angle) : 0.5;
    const auto cross = [](const Triple& a, const Triple& b) {
      return Triple{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                    a[0] * b[1] - a[1] * b[0]};
    };
    const Triple once = cross(w, leaning), twice = cross(w, once);
    Triple out;
    for (int i = 0; i < 3; ++i)
      out[static_cast<size_t>(i)] = leaning[static_cast<size_t>(i)] +
                                    s * once[static_cast<size_t>(i)] +
                                    c * twice[static_cast<size_t>(i)] + at(3 + i, t_s);
    return out;
  }

 private:
  struct Wave {
    double size = 0, rate = 0, phase = 0;
  };
  double at(int coordinate, double t_s) const {
    double sum = 0;
    for (const Wave& wave : waves_[coordinate])
      sum += wave.size * std::sin(wave.rate * t_s + wave.phase);
    return sum;
  }
  Wave waves_[6][3];
};

Triple displacement(const Video& video, int point) {
  Triple d;
  for (uint64_t axis = 0; axis < 3; ++axis)
    d[axis] = video.displaced_m * normal({video.seed, 5}, 3 * static_cast<uint64_t>(point) + axis);
  return d;
}

std::filesystem::path made(const Video& video) {
  const auto folder = std::filesystem::path(testing::TempDir()) / ("video-" + video.name);
  std::filesystem::create_directories(folder);
  const Hand hand(video);
  std::string rows = "frame,time_s,point,x_m,y_m,z_m,u_px,v_px\n";
  for (int frame = 0; frame < video.frames; ++frame) {
    if (!video.is_kept(frame)) continue;
    for (int point = 0; point < video.along * video.across; ++point) {
      Triple p = {0.04 * (point % video.along - 0.5 * (video.along - 1)),
                  0.04 * (point / video.along - 0.5 * (video.across - 1)), 0};
      const bool second = video.two_boards && p[0] > 0;
      if (video.two_boards && (second ? frame < 8 : frame >= video.frames - 8)) continue;
      if (second) p[2] = -std::sin(0.5) * p[0], p[0] *= std::cos(0.5);
      const Triple by = displacement(video, point);
      const Triple there = {p[0] + by[0], p[1] + by[1], p[2] + by[2]};
      double u = 0, v = 240;
      for (int round = 0; round < 40; ++round) {
        const Triple q = hand.seen(kPeriod_s * frame + video.line_delay_s * v, there);
        u = kFocal_px * q[0] / q[2] + 319.5, v = kFocal_px * q[1] / q[2] + 239.5;
      }
      const auto draw = static_cast<uint64_t>(2 * (frame * 1000 + point));
      u += kNoise_px * normal({video.seed, 4}, draw);
      v += kNoise_px * normal({video.seed, 4}, draw + 1);
      if (u < 0 || v < 0 || u > 639 || v > 479) continue;
      rows += fmt::format("{},{:.3f},{},{:.6f},{:.6f},{:.6f},{:.5f},{:.5f}\n", frame,
                          kPeriod_s * frame, point, p[0], p[1], p[2], u, v);
    }
  }
  write_file_atomically(folder / "points.csv", rows);
  write_file_atomically(
      folder / "measurement.yaml",
      fmt::format("format: seam-measurement/1\nkind: points\n"
                  "camera: {{width_px: 640, height_px: 480, frame_period_s: {}}}\n"
                  "noise: {{u_px: {}, v_px: {}}}\ngroup: frame\nfiles: {{points: points.csv}}\n"
                  "rig: {}\n",
                  kPeriod_s, kNoise_px, kNoise_px, video.rig));
  return folder;
}

Model nominal(const std::string& more = "") {
  return Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects: {pinhole: {fx_px: {value: 500, free: true}, fy_px: {value: "
      "500, free: true}, cx_px: {value: 319.5, free: true}, cy_px: {value: 239.5, free: true}}" +
          more + "}\n",
      "test.yaml"));
}

struct Found {
  double line_delay_s = 0, sigma_s = 0, error = 0;
};

Found read_out(const Video& video) {
  const auto problem = open_problem(made(video));
  const auto added = add_effects(*problem, nominal(), {effects::find_effect("rolling_shutter")});
  const effects::ModelEffect* effect = added.model.find("rolling_shutter");
  if (effect == nullptr) return {};
  const effects::ParameterValue& delay = effect->parameters[0];
  return {delay.value, delay.sigma.value_or(0), added.error_after};
}

// Forty frames of 88 corners by a hand that turns by 1 rad/s.
TEST(Video, TheReadOutTimeIsFoundToTwoPerCent) {
  const Found found = read_out(
      {.name = "delayed", .line_delay_s = kLineDelay_s, .frames = 40, .along = 11, .across = 8});
  EXPECT_NEAR(found.line_delay_s, kLineDelay_s, 0.02 * kLineDelay_s);
  EXPECT_NEAR(found.error, 1, 0.05);
}

TEST(Video, TheReadOutTimeLiesWithinItsError) {
  double sum2 = 0;
  constexpr int kSets = 4;
  for (uint64_t seed = 1; seed <= kSets; ++seed) {
    const Found found = read_out({.name = "few", .line_delay_s = kLineDelay_s, .seed = seed});
    EXPECT_NEAR(found.line_delay_s, kLineDelay_s, 3.5 * found.sigma_s) << seed;
    EXPECT_LT(found.sigma_s, 0.03 * kLineDelay_s) << seed;
    sum2 += std::pow((found.line_delay_s - kLineDelay_s) / found.sigma_s, 2);
  }
  // Chi-square of four: between these in 99 %.
  EXPECT_GT(sum2, 0.2);
  EXPECT_LT(sum2, 14.9);
}

TEST(Video, RowsReadOutFromBelowHaveANegativeDelay) {
  const Found found = read_out({.name = "upwards", .line_delay_s = -kLineDelay_s, .seed = 3});
  EXPECT_NEAR(found.line_delay_s, -kLineDelay_s, 0.02 * kLineDelay_s);
}

TEST(Video, AGapBeginsANewStretch) {
  const auto outside = [](int frame) { return frame < 14 || frame > 24; };
  const Video video{.name = "gap", .line_delay_s = kLineDelay_s, .frames = 38, .is_kept = outside};
  const Found found = read_out(video);
  EXPECT_NEAR(found.line_delay_s, kLineDelay_s, 3 * found.sigma_s);
  EXPECT_LT(found.sigma_s, 0.02 * kLineDelay_s);
  const auto problem = open_problem(made(video));
  EXPECT_THAT(problem->remarks(nominal()), testing::Contains(HasSubstr("2 stretches")));
}

TEST(Video, TwoBoardsWhosePlacesAreKnownServeAsOne) {
  const Found found = read_out({.name = "two-boards",
                                .line_delay_s = kLineDelay_s,
                                .frames = 32,
                                .along = 10,
                                .seed = 5,
                                .two_boards = true});
  EXPECT_NEAR(found.line_delay_s, kLineDelay_s, 3 * found.sigma_s);
  EXPECT_LT(found.sigma_s, 0.02 * kLineDelay_s);
  EXPECT_NEAR(found.error, 1, 0.05);
}

TEST(Video, ADiscoveryNamesTheRollingShutterAndNothingElse) {
  const auto problem =
      open_problem(made({.name = "whole", .line_delay_s = kLineDelay_s, .along = 7, .across = 5}));
  const SearchResult result = search(*problem, nominal(), {}, [](const std::string&) {});
  ASSERT_EQ(result.steps.size(), 1u);
  EXPECT_EQ(result.steps[0].effect, "rolling_shutter");
  EXPECT_NEAR(result.best.assessment.error, 1, 0.06);
}

TEST(Video, AGlobalShutterGetsNoRollingShutter) {
  const auto problem = open_problem(made({.name = "global", .along = 7, .across = 5, .seed = 2}));
  const SearchResult result = search(*problem, nominal(), {}, [](const std::string&) {});
  EXPECT_TRUE(result.steps.empty());
  EXPECT_NEAR(result.best.assessment.error, 1, 0.06);
}

// What a printed board's corners miss is told from the lens, the rows' times and the path.
TEST(Video, DisplacedPointsAreFoundAlongAPath) {
  const Video video{.name = "displaced",
                    .line_delay_s = kLineDelay_s,
                    .frames = 30,
                    .along = 7,
                    .across = 5,
                    .seed = 4,
                    .displaced_m = 3e-4};
  const auto problem = open_problem(made(video));
  const SearchResult result = search(*problem, nominal(), {}, [](const std::string&) {});
  const Model& found = result.best.assessment.model;
  ASSERT_TRUE(found.has("target_scatter"));
  EXPECT_TRUE(found.has("rolling_shutter"));
  EXPECT_EQ(result.steps.size(), 2u);
  EXPECT_NEAR(result.best.assessment.error, 1, 0.08);
  EXPECT_NEAR(found.find("target_scatter")->value("sigma_m"), 3e-4, 6e-5);
  EXPECT_NEAR(found.find("rolling_shutter")->value("line_delay_s"), kLineDelay_s,
              0.02 * kLineDelay_s);
  const std::vector<PlacedPoint> points = problem->placed_points(found);
  ASSERT_EQ(points.size(), 35u);
  double chi2 = 0;
  for (const PlacedPoint& point : points) {
    const Triple truth = displacement(video, std::stoi(point.name));
    for (int axis = 0; axis < 2; ++axis)
      chi2 += std::pow(
          (point.shift_m[axis] - truth[static_cast<size_t>(axis)]) / point.sigma_m[axis], 2);
  }
  // Of 70: between these in 99.9 %, did all points err by themselves.
  EXPECT_GT(chi2, 37);
  EXPECT_LT(chi2, 115);
}

TEST(Video, BendingsOfSingleViewsAreRefusedAlongAPath) {
  const auto problem = open_problem(made({.name = "flexing"}));
  EXPECT_THAT([&] { problem->check_model(nominal(", board_flex: {sigma_m: 0.0001}")); },
              testing::ThrowsMessage<InputError>(HasSubstr("still views")));
}

// Single stretches of six frames say little; those that are fitted to stay together.
TEST(Video, OneStretchOfFourIsHeldOut) {
  const auto problem = open_problem(made({.name = "held", .frames = 54, .along = 4, .across = 3}));
  ASSERT_EQ(problem->folds().size(), 1u);
  for (int frame = 0; frame < 54; ++frame)
    EXPECT_EQ(problem->folds()[0][static_cast<size_t>(frame)], frame / 6 % 4 == 0) << frame;
}

// Stretches tell focal length, centre and read-out time in unlike directions: what is fitted to
// some of them may be far less likely to all than the truth, and gains by any effect.
TEST(Video, NoValuesAreLikelierToAllFramesThanThoseFound) {
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    const auto problem = open_problem(made({.name = "likely",
                                            .line_delay_s = kLineDelay_s,
                                            .frames = 24,
                                            .along = 8,
                                            .across = 6,
                                            .seed = seed}));
    Model truth = nominal(", rolling_shutter: {line_delay_s: {value: 5e-5, free: true}}");
    truth.set_value("pinhole", 0, kFocal_px), truth.set_value("pinhole", 1, kFocal_px);
    problem->prepare(truth);
    const Assessment found = assess(*problem, truth, refitted_unknowns(truth));
    const Fit likeliest = problem->fit(truth, refitted_unknowns(truth), problem->all_groups());
    const Score there = problem->score(likeliest.model, problem->all_groups());
    EXPECT_GT(found.total_ll, there.log_likelihood - 0.1) << seed;
  }
}

TEST(Video, StillViewsSayWhatTheyCannotTell) {
  const auto problem =
      open_problem(made({.name = "still", .line_delay_s = kLineDelay_s, .rig = "{pose: unknown}"}));
  EXPECT_THAT(problem->remarks(nominal()),
              testing::Contains(HasSubstr("effects of time")).Times(1));
  EXPECT_GT(compare(*problem, nominal()).base.assessment.error, 1.5);
}

// A velocity of each view does about a stated delay what a path does.
TEST(Video, EachViewHasAVelocityBesideAStatedDelay) {
  const auto problem = open_problem(made({.name = "velocities",
                                          .line_delay_s = kLineDelay_s,
                                          .rig = "{pose: unknown, motion: constant_velocity}"}));
  const Model stated = nominal(", rolling_shutter: {line_delay_s: 5e-5}");
  EXPECT_NEAR(compare(*problem, stated).base.assessment.error, 1, 0.08);
  EXPECT_GT(compare(*problem, nominal()).base.assessment.error, 1.5);
  EXPECT_THAT(problem->remarks(stated), testing::Contains(HasSubstr("velocity of its own")));
}

TEST(Video, MotionBelongsToUnknownPoses) {
  const auto open = [](const std::string& rig) {
    return [rig] { open_problem(made({.name = "refused", .rig = rig})); };
  };
  EXPECT_THAT(open("{poses: p.csv, motion: spline}"),
              testing::ThrowsMessage<InputError>(HasSubstr("motion")));
  EXPECT_THAT(open("{pose: unknown, knot_s: 0.1}"),
              testing::ThrowsMessage<InputError>(HasSubstr("knot_s")));
  EXPECT_THAT(open("{pose: unknown, motion: splines}"),
              testing::ThrowsMessage<InputError>(HasSubstr("motion")));
}

}  // namespace
}  // namespace seam::measurement
