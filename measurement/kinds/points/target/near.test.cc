// A wide lens before a near board gets no effect but its own family.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "measurement/kinds/kinds.h"
#include "measurement/search/search.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

using testing::UnorderedElementsAre;

Model model_of(const std::string& effects) {
  return Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\nname: near\neffects: {" + effects + "}\n", "near.yaml"));
}

constexpr const char* kNominal =
    "pinhole: {fx_px: {value: 230, free: true}, fy_px: {value: 230, free: true}, cx_px: {value: "
    "319.5, free: true}, cy_px: {value: 239.5, free: true}}";
constexpr const char* kLens =
    "pinhole: {fx_px: 201, fy_px: 200, cx_px: 323, cy_px: 236}, fisheye: {k1: -0.03, k2: 0.004}";

// 17 x 13 corners, 9 to 30 cm before the lens, tilted all ways.
std::filesystem::path seen_by(const std::string& name, const std::string& truth, uint64_t seed) {
  const auto folder = std::filesystem::path(testing::TempDir()) / ("near-" + name);
  const auto out = std::filesystem::path(testing::TempDir()) / ("near-seen-" + name);
  std::filesystem::create_directories(folder);
  constexpr RandomStream kViews{.seed = 6, .stream = 3};
  std::string rows = "frame,time_s,point,x_m,y_m,z_m\n", poses = "time_s,x_m,y_m,z_m,qw,qx,qy,qz\n";
  for (int frame = 0; frame < 20; ++frame) {
    const auto between = [&](uint64_t what, double low, double high) {
      return low + (high - low) * uniform(kViews.child(what), static_cast<uint64_t>(frame));
    };
    const double around = 2.4 * frame, tilt = frame % 4 == 0 ? 0.05 : between(1, 0.3, 0.8);
    const double x = std::cos(around), y = std::sin(around), s = std::sin(tilt / 2);
    const double w = std::cos(tilt / 2);
    // The camera turned about an axis in the board: its place turns with it.
    const Vec3 axis(x, y, 0),
        eye(between(2, -0.04, 0.04), between(3, -0.03, 0.03), -between(4, 0.09, 0.3));
    const Vec3 place = rotation_about(axis, tilt) * eye;
    poses += fmt::format("{},{:.9f},{:.9f},{:.9f},{:.12f},{:.12f},{:.12f},0\n", frame, place.x,
                         place.y, place.z, w, s * x, s * y);
    for (int point = 0; point < 17 * 13; ++point)
      rows += fmt::format("{0},{0},{1},{2:.3f},{3:.3f},0\n", frame, point, 0.012 * (point % 17 - 8),
                          0.012 * (point / 17 - 6));
  }
  write_file_atomically(folder / "poses.csv", poses);
  write_file_atomically(folder / "points.csv", rows);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: points\n"
                        "camera: {width_px: 640, height_px: 480}\n"
                        "noise: {u_px: 0.1, v_px: 0.1}\ngroup: frame\n"
                        "files: {points: points.csv, poses: poses.csv}\nrig: {pose: unknown}\n");
  std::filesystem::remove_all(out);
  const MeasurementSet protocol = MeasurementSet::open(folder);
  find_kind(protocol.kind).measure(model_of(truth), protocol, {.seed = seed, .out = out}, {});
  return out;
}

struct Found {
  std::vector<std::string> names;
  double error = 0;
};

Found found_in(const std::filesystem::path& folder) {
  const auto problem = open_problem(folder);
  const SearchResult result = search(*problem, model_of(kNominal), {}, [](const std::string&) {});
  Found found{.error = result.best.assessment.error};
  for (const Step& step : result.steps) found.names.push_back(step.effect);
  return found;
}

TEST(Near, ALensWithOnePupilGetsNoOther) {
  const Found found = found_in(seen_by("central", kLens, 1));
  EXPECT_THAT(found.names, UnorderedElementsAre("fisheye"));
  EXPECT_NEAR(found.error, 1, 0.06);
}

}  // namespace
}  // namespace seam::measurement
