// Boxes are seen where their six faces are: their outlines leave no ray out, also where they cross
// the camera's plane.
#include <gtest/gtest.h>

#include "render/renderer.h"
#include "render/test_scenes.h"

namespace seam::render {
namespace {

using namespace testing;

std::vector<Primitive> faces_of(const Primitive& box) {
  std::vector<Primitive> faces;
  for (int axis = 0; axis < 3; ++axis) {
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    for (const double side : {-0.5, 0.5}) {
      const Mat3& R = box.X_WO.R;
      Primitive face = box;
      face.shape = Shape::rectangle;
      face.X_WO = {Mat3(R[b], R[c], R[axis]), box.X_WO.p + side * box.size[axis] * R[axis]};
      face.size = {box.size[b], box.size[c], 0};
      faces.push_back(face);
    }
  }
  return faces;
}

TEST(BoxOutline, BoxesAreSeenAsTheirFaces) {
  const effects::Model model =
      model_of("  pinhole: {fx_px: 60, fy_px: 60, cx_px: 44.3, cy_px: 35.6}\n");
  const Renderer renderer(model, 90, 72);
  int met = 0, crossing = 0;
  for (uint64_t trial = 0; trial < 200; ++trial) {
    const auto draw = [&](uint64_t k, double low, double high) {
      return low + (high - low) * uniform({.seed = 9, .stream = trial}, k);
    };
    Primitive box{.shape = Shape::box, .label = Label::wall, .rgb = {1, 1, 1}};
    box.X_WO = {rotation_zyx(draw(0, -3, 3), draw(1, -3, 3), draw(2, -3, 3)),
                {draw(3, -1, 1), draw(4, -1, 1), draw(5, -0.5, 1.5)}};
    box.size = {draw(6, 0.05, 2), draw(7, 0.05, 2), draw(8, 0.05, 0.3)};
    const auto seen = [&](std::vector<Primitive> primitives) {
      const MovingScene scene{
          [](double) { return Pose{}; }, [&](double) { return primitives; }, {}, {}};
      return renderer.ground_truth(job_of(scene, model, 72, 0, 1));
    };
    // From inside, faces are seen and a box is not.
    const Vec3 camera_O = glm::transpose(box.X_WO.R) * -box.X_WO.p;
    if (std::abs(camera_O.x) < 0.5 * box.size.x && std::abs(camera_O.y) < 0.5 * box.size.y &&
        std::abs(camera_O.z) < 0.5 * box.size.z) {
      continue;
    }
    const GroundTruth whole = seen({box}), faces = seen(faces_of(box));
    int differ = 0;
    bool seen_at_all = false;
    for (size_t i = 0; i < whole.label.size(); ++i) {
      met += whole.label[i] == static_cast<uint8_t>(Label::wall);
      seen_at_all |= whole.label[i] == static_cast<uint8_t>(Label::wall);
      // A ray along an edge may meet the one and pass the other.
      differ += whole.label[i] != faces.label[i];
      if (whole.label[i] == faces.label[i] && whole.depth_m[i] != faces.depth_m[i]) {
        EXPECT_NEAR(whole.depth_m[i], faces.depth_m[i], 1e-3 * faces.depth_m[i]) << trial;
      }
    }
    EXPECT_LE(differ, 2) << trial;
    double least_z = 1e9;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 half(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
      least_z = std::min(least_z, (box.X_WO * (half * box.size)).z);
    }
    crossing += seen_at_all && least_z < 0;
  }
  EXPECT_GT(met, 10000);
  EXPECT_GT(crossing, 20);
}

// Bounding a capsule by the way from one of its balls to the other leaves no ray out either: it is
// seen where its tube and its two balls are.
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
