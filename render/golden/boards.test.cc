// Boards as a detector that shares no code with SEAM finds them: every tag, each corner where the
// board's numbers say.
// The library's pictures are declared without saying that they are C's.
extern "C" {
#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
}
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "render/renderer.h"
#include "render/test_scenes.h"
#include "sim_core/scene/board.h"

namespace seam::render {
namespace {

using namespace testing;

constexpr int kPictureWidth = 640, kPictureHeight = 480;
constexpr double kFocal_px = 1100, kCentreX = 319.5, kCentreY = 239.5;

struct FoundTag {
  int id;
  double corners[4][2];  // Lower left, lower right, upper right, upper left; SEAM's pixels.
};

std::vector<FoundTag> find_tags(const Frame& frame) {
  const std::unique_ptr<image_u8_t, decltype(&image_u8_destroy)> grey(
      image_u8_create(kPictureWidth, kPictureHeight), image_u8_destroy);
  for (int v = 0; v < kPictureHeight; ++v)
    for (int u = 0; u < kPictureWidth; ++u)
      grey->buf[v * grey->stride + u] =
          static_cast<uint8_t>(frame.rgb[3 * (v * kPictureWidth + u) + 1]);
  const std::unique_ptr<apriltag_family_t, decltype(&tag36h11_destroy)> family(tag36h11_create(),
                                                                               tag36h11_destroy);
  const std::unique_ptr<apriltag_detector_t, decltype(&apriltag_detector_destroy)> detector(
      apriltag_detector_create(), apriltag_detector_destroy);
  apriltag_detector_add_family(detector.get(), family.get());
  detector->quad_decimate = 1;
  zarray_t* const detections = apriltag_detector_detect(detector.get(), grey.get());
  std::vector<FoundTag> found;
  for (int i = 0; i < zarray_size(detections); ++i) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(detections, i, &detection);
    FoundTag& tag = found.emplace_back(FoundTag{.id = detection->id, .corners = {}});
    // Its pixels are counted from their corners, ours from their middles.
    for (int corner = 0; corner < 4; ++corner)
      for (int axis = 0; axis < 2; ++axis)
        tag.corners[corner][axis] = detection->p[corner][axis] - 0.5;
  }
  apriltag_detections_destroy(detections);
  return found;
}

TEST(Boards, ADetectorFindsTheTagsWhereTheNumbersSay) {
  const BoardSpec board{.pattern = BoardPattern::aprilgrid, .columns = 4, .rows = 3};
  // Seen from 0.8 m, turned a little about each axis; the board's y is up in the image.
  const Pose X_CO{rotation_zyx(0.25, -0.2, 0.1) * Mat3(1, 0, 0, 0, -1, 0, 0, 0, -1), {0, 0, 0.8}};
  MovingScene scene;
  scene.background = {0.4, 0.4, 0.4};
  scene.camera = [](double) { return Pose{}; };
  scene.primitives = [&](double) { return board_primitives(board, X_CO, 100); };
  const effects::Model model =
      model_of("  pinhole: {fx_px: 1100, fy_px: 1100, cx_px: 319.5, cy_px: 239.5}\n");
  const Frame frame = Renderer(model, kPictureWidth, kPictureHeight)
                          .render(job_of(scene, model, kPictureHeight, 0));
  const std::vector<FoundTag> found = find_tags(frame);
  // The library's own detector loses tags that run into the small squares at their corners.
  ASSERT_GE(found.size(), 8u);
  double sum[2] = {0, 0}, squares = 0;
  const auto corners = static_cast<double>(4 * found.size());
  for (const FoundTag& tag : found) {
    const double pitch = board.tag_m + board.gap_m;
    const double left = tag.id % 4 * pitch - 0.5 * (4 * pitch - board.gap_m);
    const double low = tag.id / 4 * pitch - 0.5 * (3 * pitch - board.gap_m);
    const double across[4] = {0, 1, 1, 0}, up[4] = {0, 0, 1, 1};
    for (int corner = 0; corner < 4; ++corner) {
      const Vec3 p_C =
          X_CO * Vec3(left + across[corner] * board.tag_m, low + up[corner] * board.tag_m, 0);
      const double u = kFocal_px * p_C.x / p_C.z + kCentreX,
                   v = kFocal_px * p_C.y / p_C.z + kCentreY;
      const double du = tag.corners[corner][0] - u, dv = tag.corners[corner][1] - v;
      EXPECT_LT(std::hypot(du, dv), 0.3) << "tag " << tag.id << " corner " << corner;
      sum[0] += du, sum[1] += dv, squares += du * du + dv * dv;
    }
  }
  // The detector's own error: no shift of all corners, and little scatter.
  EXPECT_NEAR(sum[0] / corners, 0, 0.02);
  EXPECT_NEAR(sum[1] / corners, 0, 0.02);
  EXPECT_LT(std::sqrt(squares / (2 * corners)), 0.1);
  RecordProperty("scatter_px", std::to_string(std::sqrt(squares / (2 * corners))));
}

}  // namespace
}  // namespace seam::render
