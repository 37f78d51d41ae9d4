// A board before a fixed camera whose poses nobody knows: a fisheye lens is found although the
// perspective model, bent to the same points, ends far from it. The points come from the lens's
// formula, written out here.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "effects/registry.h"
#include "measurement/kinds/kinds.h"
#include "measurement/search/empirical_lens.h"
#include "measurement/search/exchanges.h"
#include "measurement/search/models/add_effects.h"
#include "measurement/search/models/compare.h"
#include "measurement/search/search.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

constexpr double kFocal_px = 400, kCx_px = 645, kCy_px = 392;
constexpr double kNoise_px = 0.2;

// The angle from the axis goes to a radius by Kannala and Brandt's polynomial.
struct Pixel {
  double u_px, v_px;
};
Pixel fisheye(double x, double y, double z) {
  const double r = std::hypot(x, y), theta = std::atan2(r, z), t2 = theta * theta;
  const double bent = theta * (1 + t2 * (-0.04 + t2 * (-0.002 + t2 * 0.0005)));
  const double scale = r > 0 ? bent / r : 1 / z;
  return {kFocal_px * x * scale + kCx_px, kFocal_px * y * scale + kCy_px};
}

// A perspective lens with the founding paper's distortion, seen in 640 x 480 pixels.
Pixel barrel(double x, double y, double z) {
  const double a = x / z, b = y / z, bent = 2 / (1 + std::sqrt(1 + 4 * 0.05 * (a * a + b * b)));
  return {420 * a * bent + 319.5, 420 * b * bent + 239.5};
}

// A lens of 60 degrees to either side whose edge a quotient of polynomials bends.
Pixel quotient(double x, double y, double z) {
  const double a = x / z, b = y / z, r2 = a * a + b * b;
  const double bent = (1 + 0.5 * r2 + 0.1 * r2 * r2) / (1 + 0.8 * r2 + 0.2 * r2 * r2);
  return {kFocal_px * a * bent + kCx_px, kFocal_px * b * bent + kCy_px};
}

// The same, decentred: far from the axis that moves points by tens of pixels.
Pixel decentred(double x, double y, double z) {
  const double a = x / z, b = y / z, p1 = 0.004, p2 = -0.003;
  const Pixel plain = quotient(x, y, z);
  return {plain.u_px + kFocal_px * (2 * p1 * a * b + p2 * (3 * a * a + b * b)),
          plain.v_px + kFocal_px * (p1 * (a * a + 3 * b * b) + 2 * p2 * a * b)};
}

// The barrel, moulded a little crooked: waves over the image that no formula of a lens has.
Pixel crooked(double x, double y, double z) {
  const Pixel drawn = barrel(x, y, z);
  const double a = (drawn.u_px - 300) / 100, b = (drawn.v_px - 260) / 90;
  return {drawn.u_px + 3 * std::sin(a + 0.4 * b), drawn.v_px + 3 * std::cos(b - 0.3 * a)};
}

struct BoardViews {
  std::string name;
  Pixel (*lens)(double x, double y, double z) = fisheye;
  int width_px = 1280, height_px = 800;
  int views = 16;
  double apart_x_m = 0.45, apart_y_m = 0.3;  // How far the views lie from each other.
  uint64_t seed = 11;
  std::vector<int> points;  // That are seen, of 63; empty: all.
  double tilt_rad = 0.5;
  std::string noise = "";  // A line of measurement.yaml.
};

// Views of a board of 9 x 7 corners, turned by up to 30 degrees, all over the image.
std::filesystem::path board_views(const BoardViews& what) {
  const auto folder = std::filesystem::path(testing::TempDir()) / what.name;
  std::filesystem::create_directories(folder);
  std::string rows = "frame,time_s,point,x_m,y_m,z_m,u_px,v_px\n";
  uint64_t draw = 0;
  const auto within = [&](double limit) {
    return limit * (2 * uniform({what.seed, 1}, draw++) - 1);
  };
  for (int frame = 0; frame < what.views; ++frame) {
    const double yaw = within(what.tilt_rad), pitch = within(what.tilt_rad), roll = within(0.6);
    const double cx = what.apart_x_m * (frame % 4 - 1.5), cy = what.apart_y_m * (frame / 4 - 1.5),
                 cz = 0.45 + within(0.1);
    for (int point = 0; point < 63; ++point) {
      const auto& seen_here = what.points;
      if (!seen_here.empty() &&
          std::find(seen_here.begin(), seen_here.end(), point) == seen_here.end())
        continue;
      const double a = 0.04 * (point % 9 - 4), b = 0.04 * (point / 9 - 3);
      const double x = std::cos(roll) * a - std::sin(roll) * b,
                   y = std::sin(roll) * a + std::cos(roll) * b;
      const double y2 = std::cos(pitch) * y, z2 = std::sin(pitch) * y;
      const double x3 = std::cos(yaw) * x + std::sin(yaw) * z2,
                   z3 = -std::sin(yaw) * x + std::cos(yaw) * z2;
      const Pixel seen = what.lens(x3 + cx, y2 + cy, z3 + cz);
      if (seen.u_px < 0 || seen.v_px < 0 || seen.u_px > what.width_px - 1 ||
          seen.v_px > what.height_px - 1)
        continue;
      const double noise_u = normal({what.seed, 2}, 2 * draw),
                   noise_v = normal({what.seed, 2}, 2 * draw++ + 1);
      rows += fmt::format("{},{},{},{:.6f},{:.6f},0,{:.4f},{:.4f}\n", frame, frame, point, a, b,
                          seen.u_px + kNoise_px * noise_u, seen.v_px + kNoise_px * noise_v);
    }
  }
  write_file_atomically(folder / "points.csv", rows);
  write_file_atomically(
      folder / "measurement.yaml",
      fmt::format("format: seam-measurement/1\nkind: points\n"
                  "camera: {{width_px: {}, height_px: {}}}\n{}"
                  "group: frame\nfiles: {{points: points.csv}}\nrig: {{pose: unknown}}\n",
                  what.width_px, what.height_px, what.noise));
  return folder;
}

Model free_pinhole(int width_px, int height_px) {
  return Model::from_config(ConfigNode::from_text(
      fmt::format("format: seam-model/1\neffects: {{pinhole: {{fx_px: {{value: 420, free: true}}, "
                  "fy_px: {{value: 420, free: true}}, cx_px: {{value: {}, free: true}}, cy_px: "
                  "{{value: {}, free: true}}}}}}\n",
                  0.5 * (width_px - 1), 0.5 * (height_px - 1)),
      "test.yaml"));
}

// A small image: less room for the lens to differ from others in.
BoardViews small(const std::string& name, uint64_t seed) {
  return {.name = name,
          .lens = barrel,
          .width_px = 640,
          .height_px = 480,
          .views = 10,
          .apart_x_m = 0.1,
          .apart_y_m = 0.07,
          .seed = seed};
}

TEST(Boards, AFisheyeLensIsFoundAndItsStepShown) {
  const auto problem = open_problem(board_views({.name = "fisheye-board"}));
  const Model nominal = free_pinhole(1280, 800);
  const SearchResult result = search(*problem, nominal, {}, [](const std::string&) {});
  ASSERT_EQ(result.steps.size(), 1u);
  EXPECT_EQ(result.steps[0].effect, "fisheye");
  EXPECT_GT(result.steps[0].error_before, 10);
  const Model& found = result.best.assessment.model;
  EXPECT_NEAR(found.find("fisheye")->value("k1"), -0.04, 0.01);
  EXPECT_NEAR(found.find("pinhole")->value("fx_px"), kFocal_px, 2);
  EXPECT_NEAR(found.find("pinhole")->value("cx_px"), kCx_px, 2);
  for (const double rms_px : result.best.assessment.held.native)
    EXPECT_NEAR(rms_px, kNoise_px, 0.03);
}

// From the perspective model no fit leads there, and near neutral its two polynomials look alike:
// it begins at the image of the lens that was found first. The noise is not stated, and a near
// board is no polynomial of low degree in such a lens.
TEST(Boards, ARationalLensTakesThePlaceOfTheFisheye) {
  const auto problem = open_problem(board_views({.name = "rational-board", .lens = quotient}));
  for (const Channel& channel : problem->facts().channels)
    EXPECT_NEAR(channel.noise, kNoise_px, 0.1 * kNoise_px) << channel.name;
  const SearchResult result =
      search(*problem, free_pinhole(1280, 800), {}, [](const std::string&) {});
  ASSERT_EQ(result.steps.size(), 1u);
  EXPECT_EQ(result.steps[0].effect, "rational_lens");
  EXPECT_LT(result.best.assessment.error, 1.1);
  EXPECT_NEAR(result.best.assessment.model.find("pinhole")->value("cx_px"), kCx_px, 2);
}

// The nominal model with lenses added one after the other.
Grown with_effects(Problem& problem, const std::vector<std::string>& names,
                   const Model& nominal = free_pinhole(1280, 800)) {
  problem.check_model(nominal);
  problem.prepare(nominal);
  Grown grown{.assessment = assess(problem, nominal, refitted_unknowns(nominal))};
  std::vector<NotTestable> reasons;
  for (const std::string& name : names) {
    auto wider = try_effect(problem, grown, effects::find_effect(name), reasons);
    if (!wider) throw std::runtime_error("no fit of " + name);
    grown = std::move(wider->grown);
  }
  return grown;
}

// A polynomial and a quotient side by side: their values cannot be told, those of one can.
// An empirical lens is compared with the best that has a formula, and named where that leaves more.
TEST(Boards, ALensOfSplinesIsNamedWhereNoFormulaOfALensFits) {
  const auto held = [](Pixel (*lens)(double, double, double), const std::string& name) {
    BoardViews views = small(name, 21);
    views.lens = lens, views.views = 24, views.noise = "noise: {u_px: 0.2, v_px: 0.2}\n";
    const auto problem = open_problem(board_views(views));
    SearchResult result{.material = kMaterial};
    result.best = with_effects(*problem, {"radial_distortion"}, free_pinhole(640, 480));
    result.unnamed = UnnamedCause{.depends_on = {{"row", "column"}}};
    hold_against_splines(
        *problem, [](const std::string&) {}, result.best, result);
    return result.splines;
  };
  const auto odd = held(crooked, "crooked-lens");
  ASSERT_TRUE(odd);
  EXPECT_EQ(odd->effect, "spline_lens");
  EXPECT_EQ(odd->named, std::vector<std::string>{"radial_distortion"});
  EXPECT_LT(odd->rms_px, 1.15 * kNoise_px);
  EXPECT_GT(odd->named_rms_px, 3 * odd->rms_px);
  EXPECT_FALSE(held(barrel, "straight-lens"));
}

TEST(Boards, WhatIsExchangedStandsWhereTheOtherStood) {
  const auto problem = open_problem(board_views({.name = "exchanged", .lens = quotient}));
  const Grown both = with_effects(*problem, {"radial_polynomial", "thin_prism"});
  const auto other = Exchanges(*problem).with_other(both, "radial_polynomial",
                                                    effects::find_effect("radial_distortion"));
  ASSERT_TRUE(other);
  EXPECT_THAT(other->added, testing::ElementsAre("radial_distortion", "thin_prism"));
}

// What the fitted camera leaves is the same in each view, wherever the board is.
TEST(Boards, WhatACameraOfAnotherFamilyLeavesIsNoNoise) {
  const auto problem = open_problem(board_views({.name = "decentred-board", .lens = decentred}));
  for (const Channel& channel : problem->facts().channels)
    EXPECT_NEAR(channel.noise, kNoise_px, 0.1 * kNoise_px) << channel.name;
}

// Near its far edge the image of a board that goes away from a wide lens bends by more than a third
// of what is left of the distance between corners.
TEST(Boards, ABoardThatGoesAwayFromAWideLensHasNoWrongCorners) {
  std::string rows = "frame,time_s,point,x_m,y_m,z_m,u_px,v_px\n";
  for (int frame = 0; frame < 8; ++frame) {
    const double yaw = 0.3 + 0.06 * frame;
    for (int point = 0; point < 140; ++point) {
      // Tags of 30 mm, 9 mm apart.
      const int column = point % 14, line = point / 14;
      const double a = 0.039 * (column / 2) + 0.03 * (column % 2) - 0.13,
                   b = 0.039 * (line / 2) + 0.03 * (line % 2) - 0.09;
      const Pixel seen = fisheye(0.12 + a * std::cos(yaw), b, 0.14 + a * std::sin(yaw));
      rows += fmt::format("{},{},{},{:.6f},{:.6f},0,{:.4f},{:.4f}\n", frame, frame, point, a, b,
                          seen.u_px, seen.v_px);
    }
  }
  const auto folder = board_views({.name = "goes-away"});
  write_file_atomically(folder / "points.csv", rows);
  const auto problem = open_problem(folder);
  EXPECT_THAT(problem->facts().notes, testing::Not(Contains(HasSubstr("left out"))));
}

// Lenses with three and four parameters bend as this one with one does. Which of them gains most is
// chance; the simplest is named first, always.
TEST(Boards, OneParameterThatDoesIsPreferredToFour) {
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    const auto problem = open_problem(board_views(small("barrel-board", seed)));
    const SearchResult result =
        search(*problem, free_pinhole(640, 480), {}, [](const std::string&) {});
    ASSERT_EQ(result.steps.size(), 1u) << seed;
    EXPECT_EQ(result.steps[0].effect, "radial_distortion") << seed;
    EXPECT_EQ(result.first.candidates[0].effect->name, "radial_distortion") << seed;
    const auto& ties = result.steps[0].indistinguishable_from;
    EXPECT_NE(std::find(ties.begin(), ties.end(), "radial_polynomial"), ties.end()) << seed;
  }
}

// Of two lenses that exclude each other one is refused by name, and the other comes in its place.
TEST(Boards, LensesThatExcludeEachOtherAreToldSo) {
  const auto problem = open_problem(board_views(small("either-lens", 1)));
  const auto with = [](const std::string& lens) {
    Model model = free_pinhole(640, 480);
    model.add_neutral(effects::find_effect(lens));
    return model;
  };
  for (const std::string radial : {"radial_distortion", "radial_polynomial", "rational_lens"}) {
    try {
      add_effects(*problem, with("fisheye"), {effects::find_effect(radial)});
      ADD_FAILURE() << radial;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), AllOf(HasSubstr("'" + radial + "' and 'fisheye' exclude"),
                                      HasSubstr("take 'fisheye' out of it")));
    }
  }
  const auto added =
      add_effects(*problem, with("radial_distortion"), {effects::find_effect("fisheye")});
  EXPECT_EQ(added.replaced, std::vector<std::string>{"radial_distortion"});
}

TEST(Boards, ViewsOfThreePointsTellNothing) {
  BoardViews few = small("three-points", 1);
  few.points = {0, 8, 31};
  few.noise = "noise: {u_px: 0.2, v_px: 0.2}\n";
  EXPECT_THAT([&] { open_problem(board_views(few)); },
              testing::ThrowsMessage<InputError>(testing::AllOf(
                  testing::HasSubstr("points.csv"), testing::HasSubstr("fewer than 4 points"))));
}

TEST(Boards, AViewWithTooFewPointsIsLeftOutAndNamed) {
  const auto folder = board_views(small("one-poor-view", 1));
  const std::string all = read_file(folder / "points.csv");
  write_file_atomically(folder / "points.csv",
                        all + "poor,99,1,0,0,0,100,100\npoor,99,2,0.04,0,0,140,100\n");
  const auto problem = open_problem(folder);
  ASSERT_EQ(problem->facts().notes.size(), 1u);
  EXPECT_NE(problem->facts().notes[0].find("frame poor left out"), std::string::npos)
      << problem->facts().notes[0];
  EXPECT_EQ(problem->facts().groups.size(), 10u);
  const CompareResult result = compare(*problem, free_pinhole(640, 480));
  EXPECT_TRUE(std::isfinite(result.base.assessment.error));
}

TEST(Boards, NoiseThatFewPointsDoNotTellMustBeStated) {
  BoardViews few = small("four-points", 1);
  few.points = {0, 8, 54, 62};
  EXPECT_THAT([&] { open_problem(board_views(few)); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("noise")));
  few.noise = "noise: {u_px: 0.2, v_px: 0.2}\n";
  const auto problem = open_problem(board_views(few));
  EXPECT_TRUE(std::isfinite(compare(*problem, free_pinhole(640, 480)).base.assessment.error));
}

// One of the two views has two of its points outside the image; the other has eight numbers for the
// six unknowns of its pose and four of the camera.
TEST(Boards, FewerObservationsThanUnknownsAreRefused) {
  BoardViews few = small("two-views", 1);
  few.points = {0, 8, 54, 62}, few.views = 2;
  few.noise = "noise: {u_px: 0.2, v_px: 0.2}\n";
  const auto problem = open_problem(board_views(few));
  EXPECT_THAT(
      [&] { compare(*problem, free_pinhole(640, 480)); },
      testing::ThrowsMessage<InputError>(testing::HasSubstr("8 residuals for 10 unknowns")));
}

// One view of two does not determine a camera, and a camera fitted to it misses the other by
// hundreds of noise units: of both, parts are held out.
TEST(Boards, TwoViewsAreHeldOutInParts) {
  BoardViews two = small("two-views", 21);
  two.views = 2, two.noise = "noise: {u_px: 0.2, v_px: 0.2}\n";
  const auto problem = open_problem(board_views(two));
  EXPECT_THAT(problem->facts().notes, Contains(HasSubstr("two views: parts of both are held out")));
  const SearchResult result =
      search(*problem, free_pinhole(640, 480), {}, [](const std::string&) {});
  EXPECT_LT(result.base.assessment.error, 5);
  EXPECT_NEAR(result.best.assessment.error, 1, 0.15);
  EXPECT_FALSE(result.best.assessment.model.has("board_warp"));
  EXPECT_THAT(problem->remarks(result.best.assessment.model),
              Contains(HasSubstr("cannot be told from the lens")));
}

// From the front any focal length will do, so that no value of a lens is clear of neutral; that the
// lens bends, and by what every lens does, is plain all the same.
TEST(Boards, AFacingBoardTellsOfTheLensButNotOfTheFocalLength) {
  BoardViews facing = small("facing", 22);
  facing.views = 3, facing.tilt_rad = 0, facing.noise = "noise: {u_px: 0.2, v_px: 0.2}\n";
  const auto problem = open_problem(board_views(facing));
  const SearchResult result =
      search(*problem, free_pinhole(640, 480), {}, [](const std::string&) {});
  ASSERT_FALSE(result.steps.empty());
  EXPECT_EQ(result.steps.front().effect, "radial_distortion");
  EXPECT_THAT(problem->remarks(result.best.assessment.model),
              Contains(HasSubstr("focal length and distance are not separable")));
  for (const Unknown& unknown : result.best.assessment.unknowns) {
    const auto* effect = result.best.assessment.model.find(unknown.effect);
    EXPECT_TRUE(std::isfinite(effect->parameters[unknown.parameter].value)) << unknown.effect;
  }
}

}  // namespace
}  // namespace seam::measurement
