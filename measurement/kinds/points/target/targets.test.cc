// Targets that are not as planned: bent, stretched, with displaced corners, with heights of their
// own; and corners that are wrong. Sets are made here by formulas of their own.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <filesystem>
#include <functional>

#include "effects/registry.h"
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

constexpr double kCornerNoise_px = 0.15;

struct Made {
  std::string name;
  int views = 12;
  double warp_x_m = 0, warp_y_m = 0, scatter_m = 0, stretch = 0;
  double height_m = 0;  // Of the plan: every corner has its own, known one.
  double tilt_rad = 0.6;
  double noise_px = kCornerNoise_px;
  uint64_t seed = 3;
  // Changes a finished row: frame, point, u, v.
  std::function<void(int, int&, double&, double&)> spoil = [](int, int&, double&, double&) {};
  std::string columns;                                                        // Further columns,
  std::function<std::string(int)> cells = [](int) { return std::string(); };  // and their cells.
};

constexpr int kAlong = 11, kAcross = 9, kPoints = kAlong * kAcross;
constexpr double kSquare_m = 0.03;

// 11 x 9 corners before a pinhole of 600 px in 640 x 480, tilted all ways.
std::filesystem::path made(const Made& what) {
  const auto folder = std::filesystem::path(testing::TempDir()) / ("target-" + what.name);
  std::filesystem::create_directories(folder);
  const auto draw = [&](uint64_t stream, int index) {
    return normal({what.seed, stream}, static_cast<uint64_t>(index));
  };
  std::string rows = "frame,time_s,point,x_m,y_m,z_m,u_px,v_px" + what.columns + "\n";
  for (int frame = 0; frame < what.views; ++frame) {
    const double around = 2.4 * frame, tilt = what.tilt_rad * (frame % 3 == 0 ? 0.4 : 1);
    const double yaw = tilt * std::cos(around), pitch = tilt * std::sin(around), roll = 0.7 * frame;
    for (int point = 0; point < kPoints; ++point) {
      const double a = kSquare_m * (point % kAlong - kAlong / 2),
                   b = kSquare_m * (point / kAlong - kAcross / 2);
      const double height = what.height_m * draw(9, point);
      const double s = a / (kSquare_m * (kAlong / 2)), t = b / (kSquare_m * (kAcross / 2));
      const double x0 = a * (1 + what.stretch) + what.scatter_m * draw(4, 3 * point),
                   y0 = b + what.scatter_m * draw(4, 3 * point + 1),
                   z0 = height + what.warp_x_m * (1 - s * s) + what.warp_y_m * (1 - t * t) +
                        what.scatter_m * draw(4, 3 * point + 2);
      const double x1 = std::cos(roll) * x0 - std::sin(roll) * y0,
                   y1 = std::sin(roll) * x0 + std::cos(roll) * y0;
      const double y2 = std::cos(pitch) * y1 - std::sin(pitch) * z0,
                   z2 = std::sin(pitch) * y1 + std::cos(pitch) * z0;
      const double x3 = std::cos(yaw) * x1 + std::sin(yaw) * z2,
                   z3 = -std::sin(yaw) * x1 + std::cos(yaw) * z2 + 0.55 + 0.02 * (frame % 4);
      double u = 600 * (x3 + 0.03 * (frame % 3 - 1)) / z3 + 319.5 +
                 what.noise_px * draw(5, 2 * (frame * kPoints + point));
      double v = 600 * (y2 + 0.03 * (frame % 2)) / z3 + 239.5 +
                 what.noise_px * draw(5, 2 * (frame * kPoints + point) + 1);
      int named = point;
      what.spoil(frame, named, u, v);
      if (u < 0 || v < 0 || u > 639 || v > 479) continue;
      rows += fmt::format("{},{},{},{:.6f},{:.6f},{:.6f},{:.4f},{:.4f}{}\n", frame, frame, named,
                          kSquare_m * (named % kAlong - kAlong / 2),
                          kSquare_m * (named / kAlong - kAcross / 2),
                          what.height_m * draw(9, named), u, v, what.cells(named));
    }
  }
  write_file_atomically(folder / "points.csv", rows);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: points\n"
                        "camera: {width_px: 640, height_px: 480}\ngroup: frame\n"
                        "files: {points: points.csv}\nrig: {pose: unknown}\n");
  return folder;
}

Model pinhole_model(const std::string& more = "") {
  return Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects: {pinhole: {fx_px: {value: 580, free: true}, fy_px: {value: "
      "580, free: true}, cx_px: {value: 319.5, free: true}, cy_px: {value: 239.5, free: true}}" +
          more + "}\n",
      "test.yaml"));
}

SearchResult searched(const Problem& problem) {
  return search(const_cast<Problem&>(problem), pinhole_model(), {}, [](const std::string&) {});
}

double value_of(const Model& model, const std::string& effect, const std::string& parameter) {
  const effects::ModelEffect* found = model.find(effect);
  return found ? found->value(parameter) : std::nan("");
}

TEST(Targets, HeightsOfAPlanChangeNothing) {
  for (const double height_m : {0.0, 0.0005, 0.002}) {
    const auto problem =
        open_problem(made({.name = fmt::format("heights-{}", height_m), .height_m = height_m}));
    EXPECT_NEAR(problem->facts().channels[0].noise, kCornerNoise_px, 0.02) << height_m;
    const CompareResult result = compare(*problem, pinhole_model());
    EXPECT_NEAR(result.base.assessment.error, 1, 0.1) << height_m;
  }
}

TEST(Targets, ABendIsFoundAndNotBlamedOnTheLens) {
  const auto problem =
      open_problem(made({.name = "bent", .warp_x_m = 0.0006, .warp_y_m = -0.0003}));
  const SearchResult result = searched(*problem);
  ASSERT_EQ(result.steps.size(), 1u);
  EXPECT_EQ(result.steps[0].effect, "board_warp");
  EXPECT_NEAR(value_of(result.best.assessment.model, "board_warp", "x_m"), 0.0006, 6e-5);
  EXPECT_NEAR(value_of(result.best.assessment.model, "board_warp", "y_m"), -0.0003, 6e-5);
  EXPECT_NEAR(result.best.assessment.error, 1, 0.06);
}

// One picture in four is blurred: without a noise of its own its corners looked like ones that
// failed now and then.
TEST(Targets, ViewsThatScatterUnlikeCountEachByItsOwnNoise) {
  const auto blurred = [](int frame) { return frame % 4 == 1; };
  const double more_px = 0.4, of_blurred_px = std::hypot(kCornerNoise_px, more_px);
  const auto problem = open_problem(made(
      {.name = "unlike", .views = 16, .spoil = [&](int frame, int& point, double& u, double& v) {
         if (!blurred(frame)) return;
         const auto index = static_cast<uint64_t>(2 * (frame * kPoints + point));
         u += more_px * normal({8, 1}, index), v += more_px * normal({8, 1}, index + 1);
       }}));
  EXPECT_THAT(problem->facts().notes, testing::Contains(HasSubstr("views scatter unlike")));
  const SearchResult result = searched(*problem);
  EXPECT_TRUE(result.steps.empty()) << result.steps[0].effect;
  EXPECT_NEAR(result.best.assessment.error, 1, 0.06);
  const Evaluation here = problem->evaluate(result.best.assessment.model, problem->all_groups());
  for (size_t i = 0; i < here.sigma.size(); ++i) {
    const int frame = problem->facts().group_of_row[problem->facts().row_of[i]];
    const double sigma = blurred(frame) ? of_blurred_px : kCornerNoise_px;
    EXPECT_NEAR(here.sigma[i], sigma, 0.3 * sigma) << frame;
  }
}

// Where the set states the noise nothing is told by itself: the text says which views differ.
TEST(Targets, ViewsThatScatterOtherThanTheSetStatesAreTold) {
  for (const double more_px : {0.0, 0.2}) {
    const auto problem = open_problem(
        made({.name = fmt::format("stated-{}", more_px),
              .views = 16,
              .spoil =
                  [&](int frame, int& point, double& u, double& v) {
                    const auto index = static_cast<uint64_t>(2 * (frame * kPoints + point));
                    if (frame != 5) return;
                    u += more_px * normal({8, 1}, index), v += more_px * normal({8, 1}, index + 1);
                  },
              .columns = ",sigma_px",
              .cells = [](int) { return fmt::format(",{}", kCornerNoise_px); }}));
    problem->prepare(pinhole_model());
    const Assessment found = assess(*problem, pinhole_model(), refitted_unknowns(pinhole_model()));
    const auto unlike = testing::Contains(
        testing::AllOf(HasSubstr("other than the set states"), HasSubstr("in frame 5, where")));
    if (more_px > 0) {
      EXPECT_THAT(problem->remarks(found.model), unlike);
    } else {
      EXPECT_THAT(problem->remarks(found.model),
                  testing::Not(testing::Contains(HasSubstr("unlike"))));
    }
  }
}

TEST(Targets, ViewsThatScatterAlikeHaveOneNoise) {
  const auto problem = open_problem(made({.name = "alike", .views = 16, .scatter_m = 0.0002}));
  EXPECT_THAT(problem->facts().notes, testing::Not(testing::Contains(HasSubstr("unlike"))));
}

// Of five views each displaced corner has ten numbers, and fields take half of these.
TEST(Targets, NoiseOfFewViewsIsNotUnderrated) {
  double sum = 0;
  constexpr int kSets = 6;
  for (int set = 0; set < kSets; ++set) {
    const auto problem = open_problem(made({.name = fmt::format("five-{}", set),
                                            .views = 5,
                                            .seed = 20 + static_cast<uint64_t>(set)}));
    for (const Channel& channel : problem->facts().channels)
      sum += channel.noise / kCornerNoise_px / (2 * kSets);
  }
  // A sigma of some 2000 numbers in all is good to 2 %.
  EXPECT_NEAR(sum, 1, 0.05);
}

// A bend is as smooth as the image of a plane, and corners that are off by many noises are in all
// views: neither counts as noise, however far.
TEST(Targets, WhatATargetIsOffItsPlanIsNoNoise) {
  for (const double noise_px : {0.05, 0.15}) {
    for (const double warp_m : {0.0, 0.006}) {
      const auto problem = open_problem(made({.name = fmt::format("off-{}-{}", noise_px, warp_m),
                                              .warp_x_m = warp_m,
                                              .warp_y_m = -0.5 * warp_m,
                                              .scatter_m = 0.001,
                                              .noise_px = noise_px}));
      for (const Channel& channel : problem->facts().channels)
        EXPECT_NEAR(channel.noise, noise_px, 0.1 * noise_px) << channel.name << ", " << warp_m;
    }
  }
}

TEST(Targets, AStretchIsToldFromTheFocalLengths) {
  // Twelve views at 0.15 px tell the stretch to 1.8e-4 at best (Cramer and Rao), at 0.03 px to a
  // fifth of that.
  const auto problem =
      open_problem(made({.name = "stretched", .stretch = 0.002, .noise_px = 0.03}));
  const SearchResult result = searched(*problem);
  ASSERT_EQ(result.steps.size(), 1u);
  EXPECT_EQ(result.steps[0].effect, "board_scale");
  const Model& found = result.best.assessment.model;
  EXPECT_NEAR(value_of(found, "board_scale", "x_scale") - value_of(found, "board_scale", "y_scale"),
              0.002, 1e-4);
}

TEST(Targets, DisplacedPointsAreFoundEachForItself) {
  const Made what{.name = "displaced", .views = 16, .scatter_m = 0.0002};
  const auto problem = open_problem(made(what));
  const SearchResult result = searched(*problem);
  ASSERT_EQ(result.steps.size(), 1u);
  EXPECT_EQ(result.steps[0].effect, "target_scatter");
  const Model& found = result.best.assessment.model;
  EXPECT_NEAR(value_of(found, "target_scatter", "sigma_m"), 0.0002, 3e-5);
  EXPECT_NEAR(result.best.assessment.error, 1, 0.06);
  // Their own displacements lie within their errors: chi-square over three numbers a point, less
  // what the views' poses and the lens take.
  const std::vector<PlacedPoint> points = problem->placed_points(found);
  ASSERT_EQ(points.size(), static_cast<size_t>(kPoints));
  double chi2 = 0, shift2 = 0, missed2 = 0;
  for (const PlacedPoint& point : points) {
    const int number = std::stoi(point.name);
    for (int axis = 0; axis < 3; ++axis) {
      const double truth =
          what.scatter_m * normal({what.seed, 4}, static_cast<uint64_t>(3 * number + axis));
      const double missed = point.shift_m[axis] - truth;
      chi2 += missed * missed / (point.sigma_m[axis] * point.sigma_m[axis]);
      if (axis < 2) shift2 += truth * truth, missed2 += missed * missed;
    }
  }
  EXPECT_NEAR(chi2 / (3 * kPoints), 1, 0.35);
  EXPECT_LT(missed2, 0.15 * shift2);
}

// Where the camera's motion is known, the likelihood is a normal one with a dense covariance.
TEST(Targets, TheLikelihoodIsThatOfTheDenseCovariance) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "target-dense";
  std::filesystem::create_directories(folder);
  std::string rows = "frame,time_s,point,x_m,y_m,z_m,u_px,v_px\n";
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(3 * 5 * 2, 3 * 5);
  Eigen::VectorXd left(3 * 5 * 2);
  for (int frame = 0; frame < 3; ++frame) {
    for (int point = 0; point < 5; ++point) {
      const double x = 2 + 0.1 * frame, y = 0.3 * (point - 2), z = 0.1 * point;
      // The camera looks along +x: image right is -y, down is -z.
      const double d = x, u = 100 * -y / d + 50, v = 100 * -z / d + 40;
      const int row = 2 * (5 * frame + point);
      left[row] = normal({8, 1}, static_cast<uint64_t>(row));
      left[row + 1] = normal({8, 1}, static_cast<uint64_t>(row + 1));
      slopes.block<2, 3>(row, 3 * point) << 100 * y / (d * d), -100 / d, 0, 100 * z / (d * d), 0,
          -100 / d;
      rows += fmt::format("{0},{0},p{1},{2},{3},{4},{5:.9f},{6:.9f}\n", frame, point, x, y, z,
                          u + left[row], v + left[row + 1]);
    }
  }
  write_file_atomically(folder / "points.csv", rows);
  write_file_atomically(
      folder / "measurement.yaml",
      "format: seam-measurement/1\nkind: points\ncamera: {width_px: 100, height_px: 80}\n"
      "noise: {u_px: 0.8, v_px: 0.8}\ngroup: frame\nfiles: {points: points.csv}\n"
      "rig: {chain: [{translate_m: [0, 0, 0]}]}\n");
  const auto problem = open_problem(folder);
  constexpr double kScatter_m = 0.003;
  const Model model = Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects: {pinhole: {fx_px: 100, fy_px: 100, cx_px: 50, cy_px: 40}, "
      "target_scatter: {sigma_m: 0.003}}\n",
      "test.yaml"));
  const Eigen::MatrixXd S = 0.64 * Eigen::MatrixXd::Identity(30, 30) +
                            kScatter_m * kScatter_m * slopes * slopes.transpose();
  const double chi2 = left.dot(S.ldlt().solve(left));
  const double expected =
      -0.5 * (chi2 + std::log(S.determinant()) + 30 * std::log(2 * std::acos(-1.0)));
  const Score score = problem->score(model, problem->all_groups());
  EXPECT_NEAR(score.chi2, chi2, 2e-3 * chi2);  // Linear but for the displacements' own size.
  EXPECT_NEAR(score.log_likelihood, expected, 2e-2);
  // A group that is held out, given the others.
  Groups others(3, 1), last(3, 0);
  others[2] = 0, last[2] = 1;
  EXPECT_NEAR(problem->score_held_out(model, last).log_likelihood,
              expected - problem->score(model, others).log_likelihood, 5e-2);
}

TEST(Targets, WrongCornersAreListedAndSteerNothing) {
  const auto swap = [](int frame, int& point, double&, double&) {
    if (frame == 2 && (point == 10 || point == 47)) point = 57 - point;
    if (frame == 5 && (point == 0 || point == 98)) point = 98 - point;
  };
  const auto problem = open_problem(made({.name = "swapped", .spoil = swap}));
  ASSERT_EQ(problem->facts().notes.size(), 1u);
  EXPECT_THAT(problem->facts().notes[0], HasSubstr("4 rows left out (lines "));
  const CompareResult result = compare(*problem, pinhole_model());
  EXPECT_NEAR(result.base.assessment.error, 1, 0.06);
  EXPECT_EQ(result.outliers.size(), 8u);  // Two residuals a row.
}

TEST(Targets, AMirroredViewIsNamed) {
  const auto mirror = [](int frame, int& point, double&, double&) {
    if (frame == 4) point = kAlong * (point / kAlong) + kAlong - 1 - point % kAlong;
  };
  const auto problem = open_problem(made({.name = "mirrored", .warp_x_m = 0.001, .spoil = mirror}));
  EXPECT_THAT(problem->facts().notes, testing::Contains(HasSubstr("frame 4 shows the board from "
                                                                  "behind")));
  const CompareResult result =
      compare(*problem, pinhole_model(", board_warp: {x_m: 0.001, y_m: 0}"));
  EXPECT_NEAR(result.base.assessment.error, 1, 0.06);
}

TEST(Targets, RowsStateTheirOwnNoise) {
  // Every third corner is four times as noisy, and says so.
  const auto noisy = [](int frame, int& point, double& u, double& v) {
    if (point % 3 != 0) return;
    u += kCornerNoise_px * std::sqrt(15.0) *
         normal({6, 1}, static_cast<uint64_t>(2 * (frame * 99 + point)));
    v += kCornerNoise_px * std::sqrt(15.0) *
         normal({6, 1}, static_cast<uint64_t>(2 * (frame * 99 + point) + 1));
  };
  const auto stated = open_problem(
      made({.name = "sigma", .spoil = noisy, .columns = ",sigma_px", .cells = [](int point) {
              return point % 3 == 0 ? ",0.6" : ",0.15";
            }}));
  EXPECT_NEAR(compare(*stated, pinhole_model()).base.assessment.error, 1, 0.06);
  EXPECT_FALSE(stated->facts().channels[0].estimated);
  const auto weighted = open_problem(
      made({.name = "weight", .spoil = noisy, .columns = ",weight", .cells = [](int point) {
              return point % 3 == 0 ? ",0.0625" : ",1";
            }}));
  EXPECT_NEAR(weighted->facts().channels[0].noise, kCornerNoise_px, 0.03);
  EXPECT_NEAR(compare(*weighted, pinhole_model()).base.assessment.error, 1, 0.1);
  for (const std::string cell : {",1e300", ",1e-300", ",-1"}) {
    for (const std::string column : {",sigma_px", ",weight"})
      EXPECT_THAT(
          [&] {
            open_problem(
                made({.name = "beyond", .columns = column, .cells = [&](int) { return cell; }}));
          },
          testing::ThrowsMessage<InputError>(HasSubstr("from 1e-12 to 1e+12")));
  }
  const auto both = made({.name = "both", .columns = ",weight,sigma_px", .cells = [](int) {
                            return std::string(",1,0.1");
                          }});
  EXPECT_THROW(open_problem(both), InputError);
}

TEST(Targets, FewOrAlikeViewsAreSaid) {
  const auto facing = open_problem(made({.name = "facing", .tilt_rad = 0.01}));
  EXPECT_THAT(facing->remarks(pinhole_model()),
              testing::Contains(HasSubstr("focal length and distance are not separable")));
  const auto two = open_problem(made({.name = "two-of-it", .views = 2}));
  EXPECT_THAT(two->remarks(pinhole_model()),
              testing::Contains(HasSubstr("two views of the target")));
  const SearchResult result = searched(*two);
  EXPECT_TRUE(std::isfinite(result.best.assessment.error));
  EXPECT_TRUE(result.steps.empty());
}

TEST(Targets, AShapeLearntFromOneSetServesAnother) {
  const auto learnt = open_problem(made({.name = "first", .views = 16, .scatter_m = 0.0003}));
  const auto added =
      add_effects(*learnt, pinhole_model(), {effects::find_effect("target_scatter")});
  std::string table = "point,x_m,y_m,z_m\n";
  for (const PlacedPoint& point : learnt->placed_points(added.model))
    table += fmt::format("{},{:.9f},{:.9f},{:.9f}\n", point.name, point.place_m.x, point.place_m.y,
                         point.place_m.z);
  const auto file = std::filesystem::path(testing::TempDir()) / "learnt.csv";
  write_file_atomically(file, table);
  // The same target (its draws come from the seed), other views.
  const auto folder = made({.name = "second", .views = 7, .scatter_m = 0.0003, .tilt_rad = 0.5});
  const double planned = compare(*open_problem(folder), pinhole_model()).base.assessment.error;
  const double carried =
      compare(*open_problem(folder, {}, file), pinhole_model()).base.assessment.error;
  EXPECT_GT(planned, 1.7);
  EXPECT_LT(carried, 1.25);
}

}  // namespace
}  // namespace seam::measurement
