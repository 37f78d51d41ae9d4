// Views whose points fix no pose (on a line, at one place, seen edge on, too few) are left out and
// named, and the other views answer as they would alone. Points by a pinhole written out here.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>

#include "measurement/kinds/kinds.h"
#include "measurement/kinds/points/views_testing.h"
#include "measurement/search/models/compare.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kPinhole_px = 600, kPinholeNoise_px = 0.1, kPitch_m = 0.03;
constexpr int kCornersAlong = 9, kCornersAcross = 6, kGoodViews = 10;

// Which corners a poor view shows, and how far it is tilted.
struct PoorView {
  std::string name;
  std::function<bool(int along, int across)> shown;
  double tilt_rad = 0.4;
  double height_m = 0;  // Of every second point, across the line.
};

struct PoorViewsSet {
  std::string name, noise = "noise: {u_px: 0.1, v_px: 0.1}\n";
  std::vector<PoorView> poor;
  bool good = true;
};

std::filesystem::path poor_set(const PoorViewsSet& what) {
  const auto folder = std::filesystem::path(testing::TempDir()) / ("poor-" + what.name);
  std::filesystem::create_directories(folder);
  std::string rows = "frame,time_s,point,x_m,y_m,z_m,u_px,v_px\n";
  uint64_t draw = 0;
  const RandomStream random{19, 0};
  const auto view = [&](const std::string& name, int frame, const PoorView& poor) {
    const double turn = 0.5 * frame, tilt = poor.tilt_rad * (frame % 2 == 0 ? 1 : -1),
                 roll = 0.3 * (frame % 3);
    for (int point = 0; point < kCornersAlong * kCornersAcross; ++point) {
      if (!poor.shown(point % kCornersAlong, point / kCornersAlong)) continue;
      const double x = kPitch_m * (point % kCornersAlong - 4),
                   y = kPitch_m * (point / kCornersAlong - 2.5) +
                       (point % 2 == 0 ? poor.height_m : 0);
      const double a = std::cos(roll) * x - std::sin(roll) * y,
                   b = std::sin(roll) * x + std::cos(roll) * y;
      // Tilted about an axis in the image that turns from view to view.
      const double along = std::cos(turn) * a + std::sin(turn) * b,
                   across = -std::sin(turn) * a + std::cos(turn) * b;
      const double flat = std::cos(tilt) * across, deep = 0.5 + std::sin(tilt) * across;
      const double X = std::cos(turn) * along - std::sin(turn) * flat,
                   Y = std::sin(turn) * along + std::cos(turn) * flat;
      rows +=
          fmt::format("{},{},{},{:.6f},{:.6f},0,{:.4f},{:.4f}\n", name, frame, point, x, y,
                      319.5 + kPinhole_px * X / deep + kPinholeNoise_px * normal(random, draw),
                      239.5 + kPinhole_px * Y / deep + kPinholeNoise_px * normal(random, draw + 1));
      draw += 2;
    }
  };
  for (int frame = 0; frame < kGoodViews && what.good; ++frame)
    view(fmt::format("good{}", frame), frame, {"", [](int, int) { return true; }});
  for (size_t i = 0; i < what.poor.size(); ++i)
    view(what.poor[i].name, kGoodViews + static_cast<int>(i), what.poor[i]);
  write_file_atomically(folder / "points.csv", rows);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: points\ncamera: {width_px: 640, "
                        "height_px: 480}\n" +
                            what.noise +
                            "group: frame\nfiles: {points: points.csv}\nrig: {pose: unknown}\n");
  return folder;
}

Model free_camera() {
  return Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects: {pinhole: {fx_px: {value: 590, free: true}, "
      "fy_px: {value: 590, free: true}, cx_px: {value: 319.5, free: true}, "
      "cy_px: {value: 239.5, free: true}}}\n",
      "test.yaml"));
}

bool of_a_row(int along, int across) {
  return across == 2 && along < 5;
}

void expect_good(const PoorViewsSet& what, const std::vector<std::string>& notes) {
  const auto problem = open_problem(poor_set(what));
  for (const std::string& note : notes)
    EXPECT_THAT(problem->facts().notes, Contains(HasSubstr(note))) << what.name;
  EXPECT_EQ(problem->facts().notes.size(), notes.size()) << what.name;
  EXPECT_EQ(problem->facts().groups.size(), static_cast<size_t>(kGoodViews));
  const CompareResult result = compare(*problem, free_camera());
  EXPECT_NEAR(result.base.assessment.error, 1, 0.08) << what.name;
  EXPECT_NEAR(result.base.assessment.model.find("pinhole")->values()[0], kPinhole_px, 2);
}

TEST(PoorViews, PointsOnALineFixNoPose) {
  PoorViewsSet what{.name = "line"};
  what.poor = {{"row", of_a_row},
               {"column", [](int along, int) { return along == 3; }},
               {"diagonal", [](int along, int across) { return along == across; }}};
  expect_good(what, {"frame row, column, diagonal left out, 3 of 13 views: they show points on one "
                     "line of the target"});
  what.name = "line-unstated", what.noise = "";
  expect_good(what, {"frame row, column, diagonal left out"});
}

TEST(PoorViews, NearlyOnALineCountsAsOnIt) {
  PoorViewsSet what{.name = "near-line"};
  what.poor = {{"near", of_a_row, 0.4, 2e-4}};  // 0.12 px to either side: the noise.
  expect_good(what, {"frame near left out, 1 of 11 views"});
}

TEST(PoorViews, OnePlaceEdgeOnAndTooFew) {
  PoorViewsSet what{.name = "others"};
  what.poor = {{"three", [](int along, int across) { return along < 3 && across == along % 2; }},
               {"edge", [](int, int) { return true; }, M_PI / 2 - 1e-3}};
  expect_good(what, {"frame three left out, 1 of 12 views: they show fewer than 4 points",
                     "frame edge left out, 1 of 12 views: they show points on one line of the "
                     "image: the target is seen edge on"});
}

// The width that two rows have is enough.
TEST(PoorViews, TwoRowsOfCornersAreKept) {
  PoorViewsSet what{.name = "two-rows"};
  what.poor = {{"two", [](int along, int across) { return across < 2 && along < 5; }}};
  const auto problem = open_problem(poor_set(what));
  EXPECT_THAT(problem->facts().notes, IsEmpty());
  EXPECT_NEAR(compare(*problem, free_camera()).base.assessment.error, 1, 0.08);
}

TEST(PoorViews, ASetOfNothingElseIsRefused) {
  PoorViewsSet what{.name = "nothing-else", .good = false};
  what.poor = {{"a", of_a_row}, {"b", of_a_row}};
  EXPECT_THAT([&] { open_problem(poor_set(what)); },
              testing::ThrowsMessage<InputError>(
                  AllOf(HasSubstr("points.csv: every view (frame) shows points on one line"))));
  what.poor.push_back({"c", [](int along, int across) { return along == 1 && across < 2; }});
  EXPECT_THAT(
      [&] { open_problem(poor_set(what)); },
      testing::ThrowsMessage<InputError>(AllOf(HasSubstr("no view (frame) fixes a pose"),
                                               HasSubstr("frame a, b"), HasSubstr("frame c"))));
}

TEST(PoorViews, PlacesOfAnEarlierFitOnALineAreRefused) {
  const auto folder = poor_set({.name = "places"});
  std::string places = "point,x_m,y_m,z_m\n";
  for (int point = 0; point < kCornersAlong * kCornersAcross; ++point)
    places += fmt::format("{},{},0,0\n", point, kPitch_m * (point % kCornersAlong));
  write_file_atomically(folder / "places.csv", places);
  MeasurementSet set = MeasurementSet::open(folder);
  set.target = folder / "places.csv";
  EXPECT_THAT([&] { open_problem(set); },
              testing::ThrowsMessage<InputError>(
                  AllOf(HasSubstr("places.csv: with these places every view of"),
                        HasSubstr("points.csv shows points on one line of the target"))));
}

// Each name at another place: no view is an image of the target.
TEST(PoorViews, ASetOfNothingButWrongNamesIsRefused) {
  std::string rows;
  for (int frame = 0; frame < 6; ++frame) {
    for (int point = 0; point < 49; ++point) {
      const auto draw = static_cast<uint64_t>(2 * (49 * frame + point));
      rows += fmt::format("{},{},{},{},{},0,{:.3f},{:.3f}\n", frame, frame, point,
                          0.03 * (point % 7), 0.03 * (point / 7), 320 + 50 * normal({4, 1}, draw),
                          240 + 40 * normal({4, 1}, draw + 1));
    }
  }
  EXPECT_THAT([&] { open_problem(write_views("wrong-names", rows)); },
              testing::ThrowsMessage<InputError>(
                  AllOf(HasSubstr("points.csv: no row takes part, expected views"),
                        HasSubstr("frame 0 is no smooth image of the target"))));
}

}  // namespace
}  // namespace seam::measurement
