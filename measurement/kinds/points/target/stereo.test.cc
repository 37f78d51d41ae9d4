// Two cameras on one rig before a board and before a room of points: where the second one is, what
// lens each has and how much later it sees are found again. The sets are made here by formulas of
// their own.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>

#include "effects/registry.h"
#include "measurement/fitting/assess.h"
#include "measurement/kinds/kinds.h"
#include "measurement/search/exchanges.h"
#include "measurement/search/search.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::measurement::stereo {
namespace {

using testing::HasSubstr;
using Triple = std::array<double, 3>;

constexpr double kNoise_px = 0.2;
// The right camera stands so far from the left one, and is turned about the axis that points down:
// to the left by this angle.
constexpr Triple kBaseline_m = {0.15, 0.01, -0.02};
constexpr double kTurned_rad = -0.35;
constexpr double kLate_s = 0.004;

Triple turned(const Triple& p, int axis, double by) {
  const auto a = static_cast<size_t>((axis + 1) % 3), b = static_cast<size_t>((axis + 2) % 3);
  Triple out = p;
  out[a] = std::cos(by) * p[a] - std::sin(by) * p[b];
  out[b] = std::sin(by) * p[a] + std::cos(by) * p[b];
  return out;
}

struct Seen {
  double u_px, v_px;
  bool inside;
};

// A point of the left camera's frame as the left or the right camera has it.
Seen seen(Triple p, bool right) {
  if (right) {
    for (size_t i = 0; i < 3; ++i) p[i] -= kBaseline_m[i];
    p = turned(p, 1, -kTurned_rad);
  }
  const double x = p[0] / p[2], y = p[1] / p[2], r2 = x * x + y * y;
  const double f = right ? 610 : 520, bent = right ? 1 : 1 - 0.08 * r2;
  const double u = f * x * bent + (right ? 330 : 315), v = f * y * bent + (right ? 228 : 244);
  return {u, v, p[2] > 0 && u > 0 && v > 0 && u < 639 && v < 479};
}

struct StereoSet {
  std::string name;
  int frames = 14;
  bool moves = false;  // Before the board as it stands, seen 25 times a second.
  bool column = true;
  int odd_frame = -1;  // The board has moved by 4 mm until the right camera takes it.
  // In each frame it has moved by so much, and turned about its middle, until then.
  double shift_m = 0, turn_rad = 0;
};

// A corner of a board that has moved a little, in the board's axes.
Triple swayed(const StereoSet& rig, int frame, Triple p) {
  const auto drawn = [&](uint64_t which) {
    return normal({7, 3}, 6 * static_cast<uint64_t>(frame) + which);
  };
  for (int axis = 0; axis < 3; ++axis)
    p = turned(p, axis, rig.turn_rad * drawn(static_cast<uint64_t>(axis)));
  for (size_t axis = 0; axis < 3; ++axis) p[axis] += rig.shift_m * drawn(3 + axis);
  return p;
}

// The board's corners in the left camera's frame. It leans before both of them.
Triple corner(const StereoSet& rig, int frame, double t_s, Triple p) {
  const auto within = [&](uint64_t draw, double limit) {
    return limit * (2 * uniform({7, 1}, 10 * static_cast<uint64_t>(frame) + draw) - 1);
  };
  if (rig.moves) {
    p = turned(turned(p, 0, 0.4 + 0.2 * std::sin(5.1 * t_s)), 1, 0.3 * std::sin(6.7 * t_s + 1));
    p = turned(p, 2, 0.3 * std::sin(4.3 * t_s + 2));
    return {p[0] + 0.06 + 0.04 * std::sin(7.3 * t_s), p[1] + 0.03 * std::sin(6.1 * t_s + 0.5),
            p[2] + 0.6 + 0.04 * std::sin(5.9 * t_s + 2)};
  }
  p = turned(turned(turned(p, 0, within(0, 0.6)), 1, within(1, 0.6)), 2, within(2, 0.8));
  return {p[0] + 0.06 + within(3, 0.08), p[1] + within(4, 0.08), p[2] + 0.6 + within(5, 0.12)};
}

std::filesystem::path made(const StereoSet& rig) {
  const auto folder = std::filesystem::path(testing::TempDir()) / ("stereo-" + rig.name);
  std::filesystem::create_directories(folder);
  std::string rows =
      fmt::format("frame,time_s,{}point,x_m,y_m,z_m,u_px,v_px\n", rig.column ? "camera," : "");
  uint64_t draw = 0;
  for (int frame = 0; frame < rig.frames; ++frame) {
    for (const bool right : {false, true}) {
      // Some frames only one of them took.
      if (!rig.moves && frame % 5 == (right ? 3 : 4)) continue;
      if (right && !rig.column) continue;
      const double stamp_s = rig.moves ? 0.04 * frame : frame;
      for (int point = 0; point < 56; ++point) {
        const double a = 0.035 * (point % 8 - 3.5), b = 0.035 * (point / 8 - 3);
        const Triple on_board = right ? swayed(rig, frame, {a, b, 0}) : Triple{a, b, 0};
        Triple p = corner(rig, frame, stamp_s + (right && rig.moves ? kLate_s : 0), on_board);
        if (right && frame == rig.odd_frame) p[0] += 0.004;
        const Seen at = seen(p, right);
        ++draw;
        if (!at.inside) continue;
        rows += fmt::format("{},{:.3f},{}{},{:.6f},{:.6f},0,{:.4f},{:.4f}\n", frame, stamp_s,
                            rig.column ? (right ? "right," : "left,") : "", point, a, b,
                            at.u_px + kNoise_px * normal({7, 2}, 2 * draw),
                            at.v_px + kNoise_px * normal({7, 2}, 2 * draw + 1));
      }
    }
  }
  write_file_atomically(folder / "points.csv", rows);
  write_file_atomically(
      folder / "measurement.yaml",
      fmt::format("format: seam-measurement/1\nkind: points\n"
                  "camera: {{width_px: 640, height_px: 480{}}}\n"
                  "noise: {{u_px: 0.2, v_px: 0.2}}\ngroup: frame\n"
                  "files: {{points: points.csv}}\nrig: {{pose: unknown{}}}\n",
                  rig.moves ? ", frame_period_s: 0.04" : "", rig.moves ? ", motion: spline" : ""));
  return folder;
}

Model model(const std::string& effects) {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects: {" + effects + "}\n", "test.yaml"));
}

std::string free_pinhole(const std::string& name) {
  return "pinhole@" + name +
         ": {fx_px: {value: 560, free: true}, fy_px: {value: 560, free: true}, cx_px: {value: "
         "319.5, free: true}, cy_px: {value: 239.5, free: true}}, ";
}

// Nothing is known of where the right camera is.
std::string nominal() {
  std::string text = free_pinhole("left") + free_pinhole("right") +
                     "radial_polynomial@left: {k1: {value: 0, free: true}}, camera_pose@right: {";
  for (const char* name : {"x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"})
    text += fmt::format("{}: {{value: 0, free: true}}, ", name);
  return text + "}";
}

void expect_found(const Assessment& found, const std::string& effect, const std::string& parameter,
                  double truth, double enough) {
  for (size_t k = 0; k < found.unknowns.size(); ++k) {
    const Unknown& unknown = found.unknowns[k];
    const effects::ModelEffect& in_model = *found.model.find(unknown.effect);
    if (unknown.effect != effect ||
        in_model.definition->parameters[unknown.parameter].name != parameter)
      continue;
    const double value = in_model.parameters[unknown.parameter].value;
    EXPECT_LT(std::abs(value - truth), 4 * found.fit.sigma[k]) << effect << " " << parameter;
    EXPECT_LT(found.fit.sigma[k], enough) << effect << " " << parameter;
    return;
  }
  ADD_FAILURE() << effect << " has no " << parameter;
}

TEST(Stereo, ItsPlaceAndBothLensesAreFoundFromNothing) {
  const auto problem = open_problem(made({.name = "board"}));
  const Model start = model(nominal());
  problem->check_model(start);
  problem->prepare(start);
  const Assessment found = assess(*problem, start, refitted_unknowns(start));
  ASSERT_TRUE(found.valid);
  EXPECT_NEAR(found.error, 1, 0.1);
  expect_found(found, "camera_pose@right", "x_m", kBaseline_m[0], 5e-4);
  expect_found(found, "camera_pose@right", "y_m", kBaseline_m[1], 5e-4);
  expect_found(found, "camera_pose@right", "z_m", kBaseline_m[2], 3e-3);
  expect_found(found, "camera_pose@right", "rx_rad", 0, 3e-3);
  expect_found(found, "camera_pose@right", "ry_rad", kTurned_rad, 3e-3);
  expect_found(found, "camera_pose@right", "rz_rad", 0, 1e-3);
  expect_found(found, "pinhole@left", "fx_px", 520, 2);
  expect_found(found, "pinhole@right", "fx_px", 610, 2);
  expect_found(found, "pinhole@right", "cy_px", 228, 2);
  expect_found(found, "radial_polynomial@left", "k1", -0.08, 5e-3);
}

TEST(Stereo, OneCameraThatSeesLaterIsTold) {
  const auto problem = open_problem(made({.name = "late", .frames = 24, .moves = true}));
  const Model start =
      model(nominal() + ", frame_latency@right: {latency_s: {value: 0, free: true}}");
  problem->check_model(start);
  problem->prepare(start);
  const Assessment found = assess(*problem, start, refitted_unknowns(start));
  ASSERT_TRUE(found.valid);
  EXPECT_NEAR(found.error, 1, 0.1);
  expect_found(found, "frame_latency@right", "latency_s", kLate_s, 3e-4);
  expect_found(found, "camera_pose@right", "x_m", kBaseline_m[0], 1e-3);
}

Model without_lenses() {
  std::string text = free_pinhole("left") + free_pinhole("right") + "camera_pose@right: {";
  for (const char* name : {"x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"})
    text += fmt::format("{}: {{value: 0, free: true}}, ", name);
  return model(text + "}");
}

// The left camera's lens is told as a fisheye's first: the other family has its numbers from the
// images of that camera, and no lens comes beside one that leaves it no room.
TEST(Stereo, OneCamerasLensIsExchangedForItsOwnAlone) {
  const auto problem = open_problem(made({.name = "exchanged"}));
  const Model start = without_lenses();
  problem->check_model(start);
  problem->prepare(start);
  Grown grown{.assessment = assess(*problem, start, refitted_unknowns(start))};
  std::vector<NotTestable> reasons;
  grown = try_effect(*problem, grown, effects::find_effect("fisheye@left"), reasons)->grown;
  const auto moves = possible_exchanges(
      *problem, grown, {}, [](const std::string& name) { return effects::find_effect(name); });
  EXPECT_THAT(moves, testing::Contains(Exchange{"fisheye@left", "radial_polynomial@left"}));
  EXPECT_THAT(moves,
              testing::Not(testing::Contains(Exchange{"fisheye@left", "radial_polynomial"})));
  const Exchanges exchanges(*problem);
  const auto other =
      exchanges.with_other(grown, "fisheye@left", effects::find_effect("radial_polynomial@left"));
  ASSERT_TRUE(other);
  EXPECT_NEAR(other->assessment.error, 1, 0.1);
  expect_found(other->assessment, "radial_polynomial@left", "k1", -0.08, 2e-2);

  Grown both = grown;
  both.assessment.model.set(effects::find_effect("fisheye"),
                            std::vector<effects::ParameterValue>(4));
  both.added.push_back("fisheye");
  for (const char* name : {"radial_polynomial", "radial_polynomial@left"})
    EXPECT_FALSE(exchanges.with_other(both, "fisheye@left", effects::find_effect(name))) << name;
}

TEST(Stereo, AFrameThatTheCamerasDidNotTakeAtOnceIsNamed) {
  for (const int odd : {-1, 6}) {
    const auto problem = open_problem(made({.name = fmt::format("odd{}", odd), .odd_frame = odd}));
    const Model start = model(nominal());
    problem->prepare(start);
    const Assessment found = assess(*problem, start, refitted_unknowns(start));
    const std::vector<std::string> remarks = problem->remarks(found.model);
    EXPECT_EQ(std::count_if(remarks.begin(), remarks.end(),
                            [](const std::string& remark) {
                              return remark.find("in places of their own") != std::string::npos;
                            }),
              odd < 0 ? 0 : 1);
    if (odd >= 0) {
      EXPECT_THAT(remarks, testing::Contains(HasSubstr("frame 6: the cameras see the target")));
    }
  }
}

// A board that is held by hand, and cameras that are released one after the other.
TEST(Stereo, ABoardThatSwaysBetweenThePicturesIsNamed) {
  constexpr double kShift_m = 0.0008, kTurn_rad = 0.004;
  const StereoSet sway{.name = "sway", .frames = 22, .shift_m = kShift_m, .turn_rad = kTurn_rad};
  const auto problem = open_problem(made(sway));
  const SearchResult result = search(*problem, model(nominal()), {}, [](const std::string&) {});
  ASSERT_EQ(result.steps.size(), 1u);
  EXPECT_EQ(result.steps[0].effect, "board_sway");
  const Assessment& found = result.best.assessment;
  EXPECT_NEAR(found.error, 1, 0.05);
  // Of 13 frames that both took: a spread of 39 numbers is known to a tenth.
  const effects::ModelEffect& told = *found.model.find("board_sway");
  EXPECT_NEAR(told.value("shift_sigma_m"), kShift_m, 0.3 * kShift_m);
  EXPECT_NEAR(told.value("turn_sigma_rad"), kTurn_rad, 0.3 * kTurn_rad);
  expect_found(found, "camera_pose@right", "x_m", kBaseline_m[0], 2e-3);
}

TEST(Stereo, ABoardThatStandsStillDoesNotSway) {
  const auto problem = open_problem(made({.name = "still", .frames = 20}));
  EXPECT_TRUE(search(*problem, model(nominal()), {}, [](const std::string&) {}).steps.empty());
}

TEST(Stereo, ACameraThatNobodyPlacesOrThatIsNoneIsNamed) {
  const auto problem = open_problem(made({.name = "unplaced"}));
  const auto why = [](const Problem& of, const std::string& effects) -> std::string {
    try {
      of.check_model(model(effects));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(why(*problem, free_pinhole("left") + free_pinhole("right")),
              HasSubstr("where camera 'right' is beside 'left': expected an effect of the stage "
                        "mount for it, such as camera_pose@right"));
  EXPECT_THAT(why(*problem, nominal() + ", thin_prism@middle: {}"),
              HasSubstr("no camera 'middle': expected one of left, right"));
  const auto alone = open_problem(made({.name = "alone", .column = false}));
  EXPECT_THAT(why(*alone, nominal()), HasSubstr("expected a column camera"));
}

}  // namespace
}  // namespace seam::measurement::stereo
