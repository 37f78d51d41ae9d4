// What a hostile or careless hand does to a set is refused, told or doubted with its evidence.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "measurement/check/describe.h"
#include "measurement/check/doubts.h"
#include "measurement/kinds/kinds.h"
#include "measurement/search/models/compare.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// A fixed camera at the origin that looks along +x (chain without joints) with fx = fy = 100 px and
// the centre at (80, 60) of 160 x 120 pixels: u = 80 - 100 y / x, v = 60 - 100 z / x.
struct Point {
  int frame;
  double x, y, z;
  std::string u, v;
};

std::vector<Point> grid() {
  std::vector<Point> points;
  for (int frame = 0; frame < 8; ++frame) {
    for (int i = -2; i <= 2; ++i) {
      for (int j = -1; j <= 1; ++j) {
        const double x = 1 + 0.1 * frame, y = 0.3 * i, z = 0.2 * j + 0.05 * frame;
        // A detector's rounding to tenths of pixels is the noise.
        points.push_back({frame, x, y, z, fmt::format("{:.1f}", 80 - 100 * y / x),
                          fmt::format("{:.1f}", 60 - 100 * z / x)});
      }
    }
  }
  return points;
}

class CheckedSet : public testing::Test {
 protected:
  CheckedSet() { fs::create_directories(folder_); }
  ~CheckedSet() override { fs::remove_all(folder_); }

  void write(const std::vector<Point>& points, int width_px = 160) {
    std::ofstream(folder_ / "measurement.yaml")
        << "format: seam-measurement/1\nkind: points\ntitle: grid\ncamera: {width_px: " << width_px
        << ", height_px: 120}\nnoise: {u_px: 0.05, v_px: 0.05}\nfiles: {points: points.csv}\n"
        << "rig: {chain: [{translate_m: [0, 0, 0]}]}\n";
    std::ofstream table(folder_ / "points.csv");
    table << "frame,time_s,point,x_m,y_m,z_m,u_px,v_px\n";
    for (size_t i = 0; i < points.size(); ++i) {
      const Point& p = points[i];
      table << fmt::format("{},{},{},{:.4f},{:.4f},{:.4f},{},{}\n", p.frame, 0.1 * p.frame, i % 15,
                           p.x, p.y, p.z, p.u, p.v);
    }
  }
  MeasurementSet set() const { return MeasurementSet::open(folder_); }
  std::string error() const {
    try {
      open_problem(folder_);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }
  // What compare prints before its results.
  std::vector<std::string> doubts_here() const {
    const auto problem = open_problem(folder_);
    return doubts(set(), model_, compare(*problem, model_).base.assessment.error);
  }

  const fs::path folder_ = fs::path(testing::TempDir()) / "checked_set";
  const effects::Model model_ = effects::Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects:\n  pinhole: {fx_px: 100, fy_px: 100, cx_px: 80, cy_px: 60}\n",
      "model"));
};

TEST_F(CheckedSet, AGoodSetGivesNoDoubt) {
  write(grid());
  EXPECT_EQ(error(), "no error");
  EXPECT_THAT(doubts_here(), IsEmpty());
  const SetDescription description = describe_set(set(), model_);
  EXPECT_THAT(description.errors, IsEmpty());
  EXPECT_THAT(description.warnings, IsEmpty());
  for (const char* said :
       {"kind points: grid", "160 x 120", "points.csv, 120 rows", "u_px                 px",
        "8 by frame, of 15 to 15 observations; 3 held out", "0.05 stated", "0 points lie outside",
        "0 points stand behind", "radial_distortion", "the rig has no joint pan"})
    EXPECT_THAT(description.text, HasSubstr(said));
}

TEST_F(CheckedSet, DoubledRowsAreRefused) {
  std::vector<Point> points = grid();
  for (int i = 0; i < 30; ++i) points.push_back(Point(points[i]));
  write(points);
  EXPECT_THAT(error(), HasSubstr("points.csv:122: found the row of line 2 again"));
  EXPECT_THAT(error(), HasSubstr("30 of 150 rows stand twice"));
  EXPECT_THAT(describe_set(set(), {}).errors, Contains(HasSubstr("points.csv:122")));
}

TEST_F(CheckedSet, PointsMeasuredAnewAreCounted) {
  std::vector<Point> points = grid();
  for (int i = 0; i < 15; ++i) points.push_back(Point(points[i]));
  for (size_t i = 120; i < points.size(); ++i) points[i].u += "1";
  write(points);
  EXPECT_EQ(error(), "no error");
  EXPECT_THAT(doubts_here(), Contains(HasSubstr("points.csv:122: measures the frame, time_s, "
                                                "point of line 2 anew; 15 of 135 rows do so")));
}

TEST_F(CheckedSet, PlacesOutsideTheImageAreRefused) {
  write(grid(), 80);
  EXPECT_THAT(error(), HasSubstr("points.csv:2: column u_px: found '140.0', expected a place in "
                                 "the image of 80 x 120 pixels"));
  EXPECT_THAT(error(), Not(HasSubstr("exchanged")));
}

TEST_F(CheckedSet, AnAbsurdCellIsRefused) {
  std::vector<Point> points = grid();
  points[7].v = "1e30";
  write(points);
  EXPECT_THAT(error(), HasSubstr("points.csv:9: column v_px: found '1e30'"));
  EXPECT_THAT(error(), HasSubstr("; 1 of 120 points lie outside it"));
}

TEST_F(CheckedSet, APlaceJustOutsideIsAWarning) {
  std::vector<Point> points = grid();
  points[0].u = "160.2";
  write(points);
  EXPECT_EQ(error(), "no error");
  EXPECT_THAT(doubts_here(), Contains(HasSubstr("warning: " + (folder_ / "points.csv").string() +
                                                ":2: column u_px: found '160.2'")));
}

TEST_F(CheckedSet, ExchangedCoordinatesAreSuspected) {
  std::vector<Point> points = grid();
  for (Point& point : points) std::swap(point.u, point.v);
  write(points);
  EXPECT_THAT(error(), HasSubstr("u_px and v_px exchanged? With v_px for u_px all lie inside"));
  // Where all lie inside either way, the model tells.
  std::erase_if(points, [](const Point& point) { return std::stod(point.v) > 119; });
  write(points);
  EXPECT_EQ(error(), "no error");
  EXPECT_THAT(doubts_here(), Contains(HasSubstr("u_px and v_px exchanged? With v_px read as u_px "
                                                "the error is ")));
}

TEST_F(CheckedSet, PointsBehindTheCameraAreDoubted) {
  std::vector<Point> points = grid();
  for (Point& point : points) point.x = -point.x;
  write(points);
  EXPECT_THAT(doubts_here(), Contains(HasSubstr("points.csv:2: the point stands behind the camera, "
                                                "one of 120 among 120 rows")));
  EXPECT_THAT(describe_set(set(), {}).warnings, Contains(HasSubstr("behind the camera")));
}

TEST_F(CheckedSet, AnErrorThatIsNoNumberIsSaidInWords) {
  write(grid());
  const std::vector<std::string> said = doubts(set(), model_, NAN);
  EXPECT_THAT(said, Contains(HasSubstr("The model predicts no number for some rows")));
  EXPECT_THAT(said, testing::Not(Contains(HasSubstr("nan"))));
}

TEST_F(CheckedSet, MillimetresAreDoubted) {
  std::vector<Point> points = grid();
  for (Point& point : points) point.x *= 1000;  // And not the others.
  write(points);
  const std::vector<std::string> said = doubts_here();
  EXPECT_THAT(said, Contains(HasSubstr("units? axes? The error is ")));
  EXPECT_THAT(said, Contains(HasSubstr("column x_m reaches 1700: millimetres?")));
}

}  // namespace
}  // namespace seam::measurement
