// What a camera does to the image of a board whose poses nobody knows: these follow whatever moves
// a view as a whole, and still a formula has its wave, its edge and its place within a pixel.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "measurement/fitting/assess.h"
#include "measurement/kinds/kinds.h"
#include "measurement/kinds/points/views_testing.h"
#include "measurement/suggest/suggest.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

using testing::ContainsRegex;

using MovesPixel = void (*)(double& u_px, double& v_px);

// Twelve views of 9 x 7 corners, 640 x 480 pixels, with a noise of 0.1 pixels.
std::filesystem::path moved_views(const std::string& name, MovesPixel moves) {
  const RandomStream lot = RandomStream{.seed = 5}.child(name);
  std::string rows;
  uint64_t draw = 0;
  const auto within = [&](double limit) { return limit * (2 * uniform(lot, draw++) - 1); };
  for (int frame = 0; frame < 12; ++frame) {
    const double yaw = within(0.6), pitch = within(0.6), cx = within(0.1), cy = within(0.07),
                 cz = 0.45 + within(0.05);
    for (int point = 0; point < 63; ++point) {
      const double a = 0.04 * (point % 9 - 4), b = 0.04 * (point / 9 - 3);
      const double y = std::cos(pitch) * b, z = std::sin(pitch) * b;
      const double x3 = cx + std::cos(yaw) * a + std::sin(yaw) * z,
                   z3 = cz - std::sin(yaw) * a + std::cos(yaw) * z;
      double u = 500 * x3 / z3 + 319.5, v = 500 * (y + cy) / z3 + 239.5;
      moves(u, v);
      u += 0.1 * normal(lot.child("noise"), draw++), v += 0.1 * normal(lot.child("noise"), draw++);
      if (u < 0 || v < 0 || u > 639 || v > 479) continue;
      rows +=
          fmt::format("{},{},{},{:.6f},{:.6f},0,{:.4f},{:.4f}\n", frame, frame, point, a, b, u, v);
    }
  }
  return write_views(name, rows, "noise: {u_px: 0.1, v_px: 0.1}\n");
}

std::string formula_of_views(const std::string& name, MovesPixel moves) {
  const auto problem = open_problem(moved_views(name, moves));
  const Model camera = Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects: {pinhole: {fx_px: {value: 490, free: true}, fy_px: {value: "
      "490, free: true}, cx_px: {value: 320, free: true}, cy_px: {value: 240, free: true}}}\n",
      "test.yaml"));
  problem->prepare(camera);
  const auto found =
      suggest(*problem, {.assessment = assess(*problem, camera, refitted_unknowns(camera))});
  if (!found) return "none";
  EXPECT_LT(found->error, 1.1) << name;
  return found->formula;
}

TEST(ImageFormula, AWaveHasItsPeriod) {
  EXPECT_THAT(formula_of_views("image-wave",
                               [](double& u, double&) {
                                 u += 0.4 * std::sin(2 * 3.14159265358979 * u / 70 + 0.5);
                               }),
              ContainsRegex("^u: 0[.](4|39|38)[0-9]* [*] sin[(]2 [*] pi [*] u / "
                            "(70|69[.][89]|70[.][12])[0-9]* [+] 0[.][345][0-9]*[)]$"));
}

TEST(ImageFormula, AnEdgeHasItsPlace) {
  EXPECT_THAT(formula_of_views("image-edge", [](double&, double& v) { v += v > 200 ? 0.6 : 0; }),
              ContainsRegex("^v: -?0[.](6|5[6789])[0-9]* [*] [(]0[.]5 [+-] 0[.]5 [*] sign[(]v - "
                            "(199|20[01])[0-9.]*[)][)]$"));
}

TEST(ImageFormula, WhereACornerLiesWithinAPixelMatters) {
  EXPECT_THAT(
      formula_of_views("image-pixel",
                       [](double& u, double&) { u += 0.15 * std::sin(2 * 3.14159265358979 * u); }),
      ContainsRegex("^u: 0[.]1[3456][0-9]* [*] sin[(]2 [*] pi [*] u[)]$"));
}

}  // namespace
}  // namespace seam::measurement
