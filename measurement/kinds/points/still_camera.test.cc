// What a camera that stands still does not show.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "effects/registry.h"
#include "measurement/kinds/kinds.h"
#include "sim_core/base/output.h"

namespace seam::measurement {
namespace {

// Why the latency of frames cannot be tested where the camera goes `way_m` in the set's 2 s.
std::string why_no_latency(const std::string& name, double way_m) {
  const auto folder = std::filesystem::path(testing::TempDir()) / ("still-camera-" + name);
  std::filesystem::create_directories(folder);
  std::string points = "frame,time_s,point,x_m,y_m,z_m,u_px,v_px\n";
  for (int frame = 0; frame < 10; ++frame) {
    for (int point = 0; point < 12; ++point) {
      const double x = 0.1 * (point % 4), y = 0.1 * (point / 4), z = 1 + 0.05 * (point % 3);
      const double seen_x = x - 0.1 * frame * way_m;
      points += fmt::format("{},{:.1f},{},{},{},{},{:.3f},{:.3f}\n", frame, 0.2 * frame, point, x,
                            y, z, 600 * seen_x / z + 319.5, 600 * y / z + 239.5);
    }
  }
  write_file_atomically(folder / "points.csv", points);
  write_file_atomically(
      folder / "poses.csv",
      fmt::format("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n2,{},0,0,1,0,0,"
                  "0\n",
                  way_m));
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: points\n"
                        "camera: {width_px: 640, height_px: 480}\ngroup: frame\n"
                        "files: {points: points.csv}\nrig: {poses: poses.csv}\n");
  const auto problem = open_problem(folder);
  const Model model = Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects: {pinhole: {fx_px: 600, fy_px: 600, cx_px: 319.5, cy_px: "
      "239.5}, frame_latency: {latency_s: 0.01}}\n",
      "model"));
  return problem->not_testable(model, *effects::find_effect("frame_latency"), 0);
}

TEST(StillCamera, ShowsNoTimeOfAFrame) {
  EXPECT_THAT(why_no_latency("still", 0), testing::HasSubstr("stands still"));
  EXPECT_EQ(why_no_latency("moving", 0.3), "");
}

}  // namespace
}  // namespace seam::measurement
