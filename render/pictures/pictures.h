// Frames, stages and ground truth as pictures, with captions, on one sheet.
#pragma once

#include <string>
#include <vector>

#include "render/renderer.h"
#include "sim_core/base/image.h"

namespace seam::render {

// 8-bit RGB; linear light 1 becomes 255, as in frames.
Image picture_of(const LinearImage& image);
Image picture_of_frame(const Frame& frame);
// One colour for each label.
Image picture_of_labels(const GroundTruth& truth);
// Near is bright; black where nothing is met.
Image picture_of_depth(const GroundTruth& truth);
// Hue is the direction, brightness the length (`full_px` is full).
Image picture_of_flow(const GroundTruth& truth, double full_px);
// Eight detected colours; a pixel that carries several shows the first. `bits`: one byte a pixel.
Image picture_of_detections(const std::vector<uint8_t>& bits, int width_px, int height_px);

// The same pixels, each `times` as large.
Image enlarged(const Image& image, int times);

struct Panel {
  std::string caption;  // Printable ASCII.
  Image image;          // 8-bit RGB.
};

// Rows of panels from left to right, each with its caption below.
Image contact_sheet(const std::vector<Panel>& panels, int columns);

}  // namespace seam::render
