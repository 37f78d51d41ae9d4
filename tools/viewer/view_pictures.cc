#include "tools/viewer/view_pictures.h"

#include <algorithm>
#include <cmath>

namespace seam::tools {
namespace {

Image image_of(int width_px, int height_px, const std::vector<uint8_t>& bytes) {
  return {.width_px = width_px,
          .height_px = height_px,
          .channels = 3,
          .samples = {bytes.begin(), bytes.end()}};
}

// A colour that people distinguish for each of seam::Label.
constexpr uint8_t kLabelColours[][3] = {
    {40, 40, 48},   {20, 110, 50},  {250, 250, 250}, {200, 200, 205},
    {255, 120, 20}, {250, 210, 30}, {90, 190, 250},  {250, 120, 180},
    {230, 190, 60}, {60, 150, 220}, {40, 170, 90},   {225, 225, 230},
    {210, 30, 30},  {40, 60, 200},  {130, 130, 140}, {160, 90, 200}};

Image labels_of(const render::GroundTruth& truth) {
  Image image{.width_px = truth.width_px, .height_px = truth.height_px, .channels = 3};
  for (const uint8_t label : truth.label) {
    for (const uint8_t value : kLabelColours[std::min<size_t>(label, 15)]) {
      image.samples.push_back(value);
    }
  }
  return image;
}

Image depth_of(const render::GroundTruth& truth) {
  Image image{.width_px = truth.width_px, .height_px = truth.height_px};
  for (const float depth_m : truth.depth_m) {
    const double near = std::isfinite(depth_m) ? 1 / (1 + static_cast<double>(depth_m)) : 0;
    image.samples.push_back(static_cast<uint16_t>(std::lround(255 * near)));
  }
  return image;
}

Image linear_of(const render::LinearImage& linear) {
  Image image{.width_px = linear.width_px, .height_px = linear.height_px, .channels = 3};
  for (size_t i = 0; i < linear.planes[0].size(); ++i) {
    for (const auto& plane : linear.planes) {
      image.samples.push_back(
          static_cast<uint16_t>(std::lround(255 * std::clamp(plane[i], 0.0f, 1.0f))));
    }
  }
  return image;
}

}  // namespace

std::optional<Image> picture_of_stage(const std::string& stage, const FrameJob& job,
                                      const Frame& frame, const render::Renderer& camera) {
  if (stage == "rgb") return image_of(frame.width_px, frame.height_px, frame.rgb);
  if (stage == "ycrcb") return image_of(frame.width_px, frame.height_px, frame.ycrcb);
  if (stage == "labels") return labels_of(camera.ground_truth(job));
  if (stage == "depth") return depth_of(camera.ground_truth(job));
  for (const render::StageImage& image : camera.stages(job)) {
    if (image.name == stage) return linear_of(image.image);
  }
  return std::nullopt;
}

}  // namespace seam::tools
