// Capsules are seen where their tube and their two balls are: bounding them by the way from one
// ball to the other leaves no ray out.
#include <gtest/gtest.h>

#include "render/renderer.h"
#include "render/test_scenes.h"

namespace seam::render {
namespace {

using namespace testing;

TEST(CapsuleSweep, CapsulesAreSeenAsTheirParts) {
  // Behind this lens a row of pixels is bent over several rows of a plane.
  const effects::Model model = model_of(
      "  pinhole: {fx_px: 60, fy_px: 60, cx_px: 44.3, cy_px: 35.6}\n"
      "  radial_distortion: {kappa: -0.2}\n");
  const Renderer renderer(model, 90, 72);
  int met = 0;
  for (uint64_t trial = 0; trial < 200; ++trial) {
    const auto draw = [&](uint64_t k, double low, double high) {
      return low + (high - low) * uniform({.seed = 11, .stream = trial}, k);
    };
    Primitive capsule{.shape = Shape::capsule, .label = Label::wall, .rgb = {1, 1, 1}};
    capsule.X_WO = {rotation_zyx(draw(0, -3, 3), draw(1, -3, 3), draw(2, -3, 3)),
                    {draw(3, -1, 1), draw(4, -1, 1), draw(5, 0.3, 2)}};
    capsule.size = {draw(6, 0.01, 0.15), 0, draw(7, 0.02, 1)};
    Primitive tube = capsule, foot = capsule, top = capsule;
    tube.shape = Shape::cylinder, foot.shape = top.shape = Shape::sphere;
    top.X_WO.p += capsule.size.z * capsule.X_WO.R[2];
    const auto seen = [&](std::vector<Primitive> primitives) {
      const MovingScene scene{
          [](double) { return Pose{}; }, [&](double) { return primitives; }, {}, {}};
      return renderer.ground_truth(job_of(scene, model, 72, 0, 1));
    };
    const GroundTruth whole = seen({capsule}), parts = seen({tube, foot, top});
    int differ = 0;
    for (size_t i = 0; i < whole.label.size(); ++i) {
      met += whole.label[i] == static_cast<uint8_t>(Label::wall);
      // A ray along an edge may meet the one and pass the other.
      differ += whole.label[i] != parts.label[i];
    }
    EXPECT_LE(differ, 1) << "trial " << trial;
  }
  EXPECT_GT(met, 20'000);
}

}  // namespace
}  // namespace seam::render
