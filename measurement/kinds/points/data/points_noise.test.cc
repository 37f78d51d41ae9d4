// The noise of points where the set does not state it.
#include "measurement/kinds/points/data/points_noise.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <regex>
#include <sstream>

#include "effects/registry.h"
#include "measurement/kinds/kinds.h"
#include "measurement/study/study.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;

// The study's room, seen with this noise by a camera that the nominal model lacks two effects of;
// noise is left out, and so are all but the first frames.
fs::path room(double noise_px, int frames) {
  const fs::path protocol = fs::path(testing::TempDir()) / "noise-protocol",
                 out = fs::path(testing::TempDir()) / "noise-set";
  const Model nominal = write_study_protocol("points", protocol);
  const std::string stated = fmt::format("noise: {{u_px: {}, v_px: {}}}", noise_px, noise_px);
  const fs::path description = protocol / "measurement.yaml";
  write_file_atomically(
      description, std::regex_replace(read_file(description), std::regex("noise: .*"), stated));
  Model truth = nominal;
  truth.set(effects::find_effect("rolling_shutter"), {{.value = 5e-5}});
  truth.set(effects::find_effect("radial_distortion"), {{.value = -0.04}});
  fs::remove_all(out);
  measure_set(truth, MeasurementSet::open(protocol), {.seed = 11, .out = out});
  write_file_atomically(
      out / "measurement.yaml",
      std::regex_replace(read_file(out / "measurement.yaml"), std::regex("noise: .*\n"), ""));
  std::string kept;
  std::istringstream lines(read_file(out / "points.csv"));
  for (std::string line; std::getline(lines, line);) {
    if (kept.empty() || std::stoi(line) < frames) kept += line + "\n";
  }
  write_file_atomically(out / "points.csv", kept);
  return out;
}

// A dozen points in a frame: where there are few of them, what the model lacks counts as noise in
// part, but they are never taken for exact.
TEST(PointsNoise, IsEstimatedFromFewAndMany) {
  for (const double noise_px : {0.1, 0.4}) {
    for (const int frames : {1, 2, 5, 42}) {
      const auto problem = open_problem(room(noise_px, frames));
      for (const auto& channel : problem->facts().channels) {
        EXPECT_GT(channel.noise, 0.6 * noise_px) << channel.name << ", " << frames << " frames";
        EXPECT_LT(channel.noise, (frames < 42 ? 4 : 1.2) * noise_px)
            << channel.name << ", " << frames << " frames";
      }
    }
  }
}

// A point far beside a camera that turns fast: the rows that would see it run away from it, and
// `measure` once wrote where the search for the row had stopped.
TEST(PointsMeasured, APointThatNoRowSeesIsLeftOut) {
  const fs::path protocol = fs::path(testing::TempDir()) / "runaway-protocol",
                 out = fs::path(testing::TempDir()) / "runaway-set";
  Model truth = write_study_protocol("points", protocol);
  truth.set(effects::find_effect("rolling_shutter"), {{.value = 2e-4}});
  std::string joints = "time_s,tilt_rad,pan_rad\n";
  for (int i = 0; i <= 1300; ++i) {
    const double t = 0.008 * i;
    joints += fmt::format("{:.6f},{:.7f},{:.7f}\n", t, 0.25 * std::sin(3.3 * t + 0.4),
                          0.8 * std::sin(5.1 * t) + 0.1 * std::sin(17 * t));
  }
  write_file_atomically(protocol / "joints.csv", joints);
  write_file_atomically(protocol / "points.csv",
                        "frame,time_s,point,x_m,y_m,z_m\n"
                        "0,0.150000,0,2.26522,0.77139,0.91886\n"
                        "91,3.881000,106,1.77216,-1.68641,-0.31803\n");
  fs::remove_all(out);
  measure_set(truth, MeasurementSet::open(protocol), {.seed = 1, .out = out});
  const CsvTable seen = MeasurementSet::open(out).table("points");
  ASSERT_EQ(seen.rows(), 1u);
  EXPECT_EQ(seen.cell(0, "point"), "0");
}

}  // namespace
}  // namespace seam::measurement
