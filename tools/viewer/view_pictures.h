// Stages of a frame as pictures for the viewer.
#pragma once

#include <optional>
#include <string>

#include "render/renderer.h"
#include "sim_core/base/image.h"

namespace seam::tools {

// "rgb", "ycrcb" (shown as it is), "labels" (a colour for each class), "depth" (near is bright), or
// a stage of the renderer by its name; nothing for other names.
std::optional<Image> picture_of_stage(const std::string& stage, const FrameJob& job,
                                      const Frame& frame, const render::Renderer& camera);

}  // namespace seam::tools
