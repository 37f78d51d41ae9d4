// Each fault of data is told by name, and good data none.
#include "measurement/check/faults.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "sim_core/base/error.h"
#include "sim_core/base/image.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class Faults : public testing::Test {
 protected:
  Faults() { fs::create_directories(folder_); }
  ~Faults() override { fs::remove_all(folder_); }

  void write(const char* name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  MeasurementSet set(const char* kind, const char* files, const char* more = "") const {
    write("measurement.yaml",
          fmt::format("format: seam-measurement/1\nkind: {}\nfiles: {}\n{}", kind, files, more));
    return MeasurementSet::open(folder_);
  }

  // A servo that lags behind a sine, and what a careless hand did to a row of it.
  struct Sample {
    double time_s, command_rad, measured_rad;
  };
  MeasurementSet servo(const std::function<void(int, Sample&)>& spoil) const {
    std::string text = "run,time_s,joint,command_rad,measured_rad\n";
    for (int k = 0; k < 400; ++k) {
      const double t = 0.01 * k;
      const auto path = [](double at) { return 0.5 * std::sin(2 * at) + 0.2 * std::sin(5 * at); };
      Sample sample{t, path(t), path(t - 0.05)};
      spoil(k, sample);
      text += fmt::format("a,{:.9f},pan,{:.9f},{:.9f}\n", sample.time_s, sample.command_rad,
                          sample.measured_rad);
    }
    write("joints.csv", text);
    return set("joints", "{joints: joints.csv}");
  }

  // A walk on a circle. `side` of y, and of the heading.
  MeasurementSet walk(double metres, double radians, double v = 1, double omega = 1,
                      double side = 1, bool exchanged = false) const {
    std::string text = "run,time_s,vx_cmd_mps,vy_cmd_mps,omega_cmd_radps,x_m,y_m,theta_rad\n";
    for (int k = 0; k < 200; ++k) {
      const double t = 0.05 * k, turn = 0.4 * t;
      const double x = metres * 0.75 * std::sin(turn),
                   y = side * metres * 0.75 * (1 - std::cos(turn));
      text += fmt::format("1,{:.3f},{},0,{},{:.6f},{:.6f},{:.6f}\n", t, 0.3 * v, 0.4 * omega,
                          exchanged ? y : x, exchanged ? x : y,
                          radians * std::remainder(turn, 2 * M_PI));
    }
    write("odometry.csv", text);
    return set("odometry", "{odometry: odometry.csv}");
  }

  // A robot on two wheels that curves, turns to and fro, and stands 0.2 m wide; `spoil` gets its
  // pose and ticks.
  struct Wheels {
    double x_m, y_m, theta_rad, left, right;
  };
  MeasurementSet wheels(const std::function<void(Wheels&)>& spoil) const {
    std::string text = "run,time_s,left_ticks,right_ticks,x_m,y_m,theta_rad\n";
    double x = 0, y = 0, theta = 0;
    for (int k = 0; k < 800; ++k) {
      const double left = std::round(60 + 40 * std::sin(0.02 * k)), right = 160 - left - k / 20;
      const double turn = 1e-4 * (right - left) / 0.2, way = 0.5e-4 * (right + left);
      x += way * std::cos(theta + 0.5 * turn), y += way * std::sin(theta + 0.5 * turn);
      theta += turn;
      Wheels row{x, y, std::remainder(theta, 2 * M_PI), left, right};
      spoil(row);
      text += fmt::format("1,{:.3f},{},{},{:.6f},{:.6f},{:.6f}\n", 0.05 * k, row.left, row.right,
                          row.x_m, row.y_m, row.theta_rad);
    }
    write("odometry.csv", text);
    return set("odometry", "{odometry: odometry.csv}");
  }

  MeasurementSet beacons(double range_unit, bool exchanged, double bearing_unit,
                         double time_unit = 1, double heading_unit = 1) const {
    const double places[3][2] = {{-8, 2}, {9, -7}, {3, 12}};
    std::string landmarks = "landmark,x_m,y_m\n", poses = "time_s,x_m,y_m,theta_rad\n",
                seen = "time_s,landmark,range_m,bearing_rad\n";
    for (int i = 0; i < 3; ++i)
      landmarks += fmt::format("{},{},{}\n", i, places[i][exchanged], places[i][!exchanged]);
    for (int k = 0; k < 120; ++k) {
      const double t = 0.1 * k, x = 4 * std::cos(t / 3), y = 3 * std::sin(t / 2);
      const double theta = 0.3 * t;
      poses += fmt::format("{:.3f},{:.6f},{:.6f},{:.6f}\n", t, x, y, heading_unit * theta);
      const double dx = places[k % 3][0] - x, dy = places[k % 3][1] - y;
      seen += fmt::format("{:.6f},{},{:.6f},{:.6f}\n", t * time_unit, k % 3,
                          range_unit * std::hypot(dx, dy),
                          bearing_unit * std::remainder(std::atan2(dy, dx) - theta, 2 * M_PI));
    }
    write("landmarks.csv", landmarks), write("poses.csv", poses), write("seen.csv", seen);
    return set("landmarks", "{landmarks: landmarks.csv, poses: poses.csv, observations: seen.csv}");
  }

  // A board that is turned a little from view to view; `mirror` and `repeat` spoil one view.
  MeasurementSet board(int mirror, int repeat, double metres = 1, double seconds = 1,
                       const char* period = "0.5", int lines = 0) const {
    std::string text = "frame,time_s,point,x_m,y_m,z_m,u_px,v_px\n";
    // Rows of four corners that were seen alone, each with its noise.
    for (int k = 0; k < 4 * lines; ++k)
      text += fmt::format("line{0},9,{1},{2},0,0,{3:.4f},{4:.4f}\n", k / 4, k % 4, 0.03 * (k % 4),
                          200 + 30 * (k % 4) + 0.1 * std::sin(7 * k), 200 + 0.1 * std::cos(9 * k));
    for (int frame = 0; frame < 8; ++frame) {
      const double turn = 0.1 * (frame == repeat ? frame - 1 : frame);
      for (int i = 0; i < 12; ++i) {
        const double x = 0.03 * (i % 4), y = 0.03 * (i / 4), seen = frame == mirror ? 0.09 - x : x;
        text +=
            fmt::format("{0},{6},{1},{2},{3},0,{4:.4f},{5:.4f}\n", frame, i, metres * x, metres * y,
                        200 + 1000 * (seen * std::cos(turn) - y * std::sin(turn)),
                        200 + 1000 * (seen * std::sin(turn) + y * std::cos(turn)), seconds * frame);
      }
    }
    write("points.csv", text);
    return set("points", "{points: points.csv}",
               fmt::format("camera: {{width_px: 640, height_px: 480, frame_period_s: {}}}\n"
                           "rig: {{pose: unknown}}\n",
                           period)
                   .c_str());
  }

  const fs::path folder_ =
      fs::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
};

constexpr double kDegrees = 180 / M_PI;

TEST_F(Faults, GoodSetsHaveNone) {
  for (const MeasurementSet& good : {servo([](int, Sample&) {}), walk(1, 1)}) {
    EXPECT_THAT(faults_of_values(good), IsEmpty());
    EXPECT_THAT(faults_of_clocks(good), IsEmpty());
  }
  EXPECT_THAT(faults_of_values(beacons(1, false, 1)), IsEmpty());
  EXPECT_THAT(faults_of_clocks(beacons(1, false, 1)), IsEmpty());
  EXPECT_THAT(faults_of_values(board(-1, -1)), IsEmpty());
  EXPECT_THAT(faults_of_clocks(board(-1, -1)), IsEmpty());
}

TEST_F(Faults, ACommandThatIsTheMeasurementIsTold) {
  const auto copied = servo([](int, Sample& s) { s.command_rad = s.measured_rad; });
  EXPECT_THAT(faults_of_values(copied), ElementsAre(HasSubstr("is really the measurement")));
  // With noise of the encoder, by which an angle is no copy.
  const auto exchanged = servo([](int k, Sample& s) {
    std::swap(s.command_rad, s.measured_rad);
    s.command_rad += 1e-4 * (k % 3);
  });
  EXPECT_THAT(
      faults_of_values(exchanged),
      ElementsAre(HasSubstr("5 rows ahead of the command: are the two columns exchanged?")));
  const auto copy = servo([](int, Sample& s) { std::swap(s.command_rad, s.measured_rad); });
  EXPECT_THAT(faults_of_values(copy),
              ElementsAre(HasSubstr("the measurement 5 rows earlier: is it a copy of it?")));
}

// A servo that is turned through the back of its circle; one large error alone is none.
TEST_F(Faults, AnglesWithinOneTurnAreTold) {
  const auto wrapped = servo([](int, Sample& s) {
    s.command_rad += 3, s.measured_rad = std::remainder(s.measured_rad + 3, 2 * std::numbers::pi);
  });
  EXPECT_THAT(faults_of_values(wrapped),
              testing::Contains(testing::AllOf(HasSubstr("joints.csv:15: measured_rad jumps"),
                                               HasSubstr("stated within one turn"))));
  const auto gross = servo([](int k, Sample& s) { s.measured_rad += k == 200 ? 2.5 : 0; });
  EXPECT_THAT(faults_of_values(gross), IsEmpty());
}

TEST_F(Faults, DegreesInOneColumnAreTold) {
  const auto measured = servo([](int, Sample& s) { s.measured_rad *= kDegrees; });
  EXPECT_THAT(faults_of_values(measured),
              testing::Contains(testing::AllOf(HasSubstr("measured_rad spans"),
                                               HasSubstr("degrees for radians"))));
  const auto command = servo([](int, Sample& s) { s.command_rad *= kDegrees; });
  EXPECT_THAT(faults_of_values(command),
              testing::Contains(testing::AllOf(HasSubstr("command_rad spans"),
                                               HasSubstr("degrees for radians"))));
  EXPECT_THAT(faults_of_values(walk(1, kDegrees)),
              ElementsAre(HasSubstr("theta_rad turns 57 times as far")));
  EXPECT_THAT(faults_of_values(walk(1, 1, 1, kDegrees)),
              testing::Contains(HasSubstr("omega_cmd_radps turns 57 times as far")));
  EXPECT_THAT(faults_of_values(beacons(1, false, kDegrees)),
              ElementsAre(HasSubstr("more than a turn: degrees for radians")));
  EXPECT_THAT(faults_of_values(beacons(1, false, 1, 1, kDegrees)),
              ElementsAre(HasSubstr("with theta_rad of the poses read as degrees")));
  // Where all columns of a kind are alike no ratio tells it.
  const auto both =
      servo([](int, Sample& s) { s.measured_rad *= kDegrees, s.command_rad *= kDegrees; });
  EXPECT_THAT(faults_of_values(both), ElementsAre(HasSubstr("turns: degrees for radians?")));
  EXPECT_THAT(faults_of_values(walk(1, kDegrees, 1, kDegrees)),
              ElementsAre(HasSubstr("omega_cmd_radps is 22.9183")));
}

TEST_F(Faults, TicksOfAnEncoderForRadiansAreTold) {
  const auto ticks = servo([](int, Sample& s) {
    s.measured_rad = std::round((s.measured_rad + 3) * 1024 / (2 * std::numbers::pi));
  });
  EXPECT_THAT(faults_of_values(ticks),
              ElementsAre(HasSubstr("joints.csv:2: measured_rad spans 160 times as much")));
}

TEST_F(Faults, OfWheelsAreTold) {
  const auto told = [&](auto&& spoil) { return faults_of_values(wheels(spoil)); };
  EXPECT_THAT(told([](Wheels&) {}), IsEmpty());
  EXPECT_THAT(told([](Wheels& w) { w.theta_rad *= kDegrees; }),
              ElementsAre(HasSubstr("goes where it looks, and this one does so where theta_rad is "
                                    "read as degrees")));
  EXPECT_THAT(told([](Wheels& w) { w.y_m = -w.y_m; }),
              ElementsAre(HasSubstr("theta_rad counts to the other side, or y_m does")));
  EXPECT_THAT(told([](Wheels& w) { w.x_m *= 1000, w.y_m *= 1000; }),
              ElementsAre(HasSubstr("the wheels stand 199 m apart: millimetres for metres")));
  EXPECT_THAT(told([](Wheels& w) { w.left = 0; }),
              ElementsAre(HasSubstr("odometry.csv:2: column left_ticks is 0 in this row and in all "
                                    "others, while the body turns")));
  EXPECT_THAT(told([](Wheels& w) { w.right = w.left; }),
              ElementsAre(HasSubstr("are equal in all")));
  EXPECT_THAT(told([](Wheels& w) { std::swap(w.left, w.right); }),
              ElementsAre(HasSubstr("left_ticks and right_ticks are exchanged")));
  EXPECT_THAT(told([](Wheels& w) { w.right = -w.right; }),
              ElementsAre(HasSubstr("right_ticks counts backwards")));
  EXPECT_THAT(told([](Wheels& w) { w.left = -w.left; }),
              ElementsAre(HasSubstr("left_ticks counts backwards")));
  EXPECT_THAT(told([](Wheels& w) { w.left = -w.left, w.right = -w.right; }),
              ElementsAre(HasSubstr("both columns count backwards")));
}

TEST_F(Faults, DegreesOfAHeadAreTold) {
  write("joints.csv", "time_s,pan_rad\n0,-35\n0.1,0\n0.2,35\n");
  board(-1, -1);
  EXPECT_THAT(
      faults_of_values(set("points", "{points: points.csv, joints: joints.csv}",
                           "rig: {chain: [{joint: pan, axis: [0, 0, 1]}]}\n")),
      ElementsAre(HasSubstr("joints.csv: pan_rad spans 70, 11 turns: degrees for radians?")));
}

TEST_F(Faults, MillimetresAreTold) {
  EXPECT_THAT(faults_of_values(walk(1000, 1)),
              ElementsAre(HasSubstr("1000 times as far as the other columns say: millimetres")));
  EXPECT_THAT(faults_of_values(walk(1, 1, 1000)),
              ElementsAre(HasSubstr("vx_cmd_mps and vy_cmd_mps go 1000 times")));
  EXPECT_THAT(faults_of_values(beacons(1000, false, 1)),
              testing::Contains(HasSubstr("millimetres for metres in range_m")));
  EXPECT_THAT(faults_of_values(board(-1, -1, 1000)),
              ElementsAre(HasSubstr("are 30 m apart: millimetres for metres?")));
  write("ranges.csv", "trial,true_m,measured_m\n1,0.5,520\n2,1,990\n3,2,2050\n");
  EXPECT_THAT(faults_of_values(set("ranges", "{ranges: ranges.csv}")),
              ElementsAre(HasSubstr("measured_m is 1025 times the other: millimetres for metres")));
}

TEST_F(Faults, ExchangedAxesAreTold) {
  EXPECT_THAT(faults_of_values(beacons(1, true, 1)),
              testing::Contains(HasSubstr("with x_m and y_m of the landmarks exchanged")));
  EXPECT_THAT(faults_of_values(walk(1, 1, 1, 1, 1, true)),
              ElementsAre(HasSubstr("with x_m and y_m exchanged")));
  EXPECT_THAT(faults_of_values(walk(1, 1, 1, 1, -1)),
              ElementsAre(HasSubstr("with y_m counted to the other side")));
  EXPECT_THAT(faults_of_values(walk(1, -1, 1, 1, -1)),
              ElementsAre(HasSubstr("theta_rad turns against omega_cmd_radps")));
  EXPECT_THAT(faults_of_values(beacons(1, false, -1)),
              ElementsAre(HasSubstr("bearing_rad counted to the other side (expected: left)")));
}

TEST_F(Faults, ABeaconThatNobodyPlacedIsTold) {
  const MeasurementSet good = beacons(1, false, 1);
  EXPECT_THAT(faults_of_values(good), IsEmpty());
  write("landmarks.csv", "landmark,x_m,y_m\n0,-8,2\n1,0,0\n2,3,12\n");
  EXPECT_THAT(faults_of_values(good),
              ElementsAre(HasSubstr("landmarks.csv:3: landmark 1 stands at 0, 0 and its ranges "
                                    "miss by")));
  write("landmarks.csv", "landmark,x_m,y_m\n0,0,0\n1,0,0\n2,0,0\n");
  EXPECT_THAT(faults_of_values(good),
              ElementsAre(HasSubstr("landmarks.csv:3: landmark 1 stands at 0, 0, the very place of "
                                    "landmark 0 (line 2), and so do 1 others")));
}

TEST_F(Faults, ClocksAreTold) {
  for (const auto& [unit, name] : {std::pair{1e3, "10 s apart: milliseconds for seconds"},
                                   {1e6, "microseconds for seconds"},
                                   {1e9, "nanoseconds for seconds"}}) {
    const double factor = unit;
    EXPECT_THAT(faults_of_clocks(servo([factor](int, Sample& s) { s.time_s *= factor; })),
                ElementsAre(HasSubstr(name)));
  }
  const auto jump = servo([](int k, Sample& s) { s.time_s += k < 200 ? 0 : 30; });
  EXPECT_THAT(faults_of_clocks(jump),
              ElementsAre(HasSubstr("joints.csv:202: the clock jumps by 30.01 s where 0.01 s")));
  EXPECT_THAT(faults_of_clocks(beacons(1, false, 1, 1000)),
              ElementsAre(HasSubstr("where it is read as milliseconds")));
  EXPECT_THAT(faults_of_clocks(board(-1, -1, 1, 1e3)),
              ElementsAre(HasSubstr("frames are 1000 s apart where the camera's period is 0.5 s: "
                                    "milliseconds for seconds")));
}

TEST_F(Faults, ExposuresInMillisecondsAreTold) {
  const auto frames = [&](double unit) {
    std::string text = "frame,file,time_s,exposure_s,illumination\n";
    for (int k = 0; k < 4; ++k)
      text += fmt::format("{0},{0}.png,{1},{2},1\n", k, 0.1 * k, unit * 0.002 * (k + 1));
    write("frames.csv", text);
    return set("photometry", "{frames: frames.csv}");
  };
  EXPECT_THAT(faults_of_clocks(frames(1)), IsEmpty());
  EXPECT_THAT(faults_of_clocks(frames(1000)),
              ElementsAre(HasSubstr("frames.csv:4: exposure_s is 6 s, and the next frame 0.1 s "
                                    "later: milliseconds for seconds?")));
}

TEST_F(Faults, PicturesStoredTwiceAreTold) {
  for (const char* name : {"a.png", "b.png", "c.png"}) write(name, "one");
  const char* head = "frame,file,time_s,exposure_s,illumination\n";
  write("frames.csv", std::string(head) + "0,a.png,0,1,1\n1,b.png,1,1,1\n2,c.png,2,1,1\n");
  const auto twice = set("photometry", "{frames: frames.csv}");
  EXPECT_THAT(faults_of_values(twice),
              ElementsAre(HasSubstr("frames.csv:3: 2 pictures are those before them")));
  write("b.png", "two");
  EXPECT_THAT(faults_of_values(twice), IsEmpty());
  // Beyond the range of a camera all pictures are the same.
  Image clipped{.width_px = 2, .height_px = 2, .channels = 1, .samples = {255, 255, 255, 255}};
  for (const char* name : {"a.png", "b.png", "c.png"}) write(name, encode_png(clipped));
  EXPECT_THAT(faults_of_values(twice), IsEmpty());
  clipped.samples[0] = 254;
  for (const char* name : {"a.png", "b.png"}) write(name, encode_png(clipped));
  EXPECT_THAT(faults_of_values(twice), ElementsAre(HasSubstr("frames.csv:3: 1 pictures")));
}

TEST_F(Faults, StampsOfFramesThatCannotBeAreTold) {
  const auto video = [&](const std::vector<const char*>& times, const char* motion) {
    std::string text = "frame,time_s,point,x_m,y_m,z_m,u_px,v_px\n";
    for (size_t row = 0; row < times.size(); ++row)
      text += fmt::format("f{},{},{},{},0,0,{},5\n", row / 2, times[row], row % 2, row % 2, row);
    write("points.csv", text);
    return set("points", "{points: points.csv}",
               fmt::format("rig: {{pose: unknown, motion: {}}}\n", motion).c_str());
  };
  EXPECT_THAT(faults_of_values(video({"0", "0", "0.1", "0.1"}, "spline")), IsEmpty());
  EXPECT_THAT(faults_of_values(video({"0", "0", "0.1", "0.2", "0.3", "0.4"}, "still")),
              ElementsAre(HasSubstr("points.csv:5: column time_s: found 0.1 and 0.2 in frame f1, 2 "
                                    "such frames in all")));
  EXPECT_THAT(
      faults_of_values(video({"0.1", "0.1", "0.1", "0.1"}, "spline")),
      ElementsAre(HasSubstr("points.csv:4: column time_s: frames f0 and f1 have one time")));
  EXPECT_THAT(faults_of_values(video({"0.1", "0.1", "0.1", "0.1"}, "still")), IsEmpty());
}

TEST_F(Faults, ViewsThatRepeatOrAreMirroredAreTold) {
  EXPECT_THAT(faults_of_values(board(-1, 5)),
              ElementsAre(HasSubstr("1 views repeat the one before to the last digit, the first is "
                                    "5")));
  EXPECT_THAT(faults_of_values(board(3, -1)),
              ElementsAre(HasSubstr("1 of 8 views show the target mirrored against the others, the "
                                    "first is 3")));
  // Points on a line have no handedness.
  EXPECT_THAT(faults_of_values(board(-1, -1, 1, 1, "0.5", 6)), IsEmpty());
  EXPECT_THAT(faults_of_values(board(3, -1, 1, 1, "0.5", 6)),
              ElementsAre(HasSubstr("1 of 8 views show the target mirrored")));
}

}  // namespace
}  // namespace seam::measurement
