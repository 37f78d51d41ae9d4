// Fixed frames whose fingerprints are pinned (golden_frames.txt): every shape and every effect, so
// that a bit that differs between machines, compilers, vector widths or threads is found.
#pragma once

#include <string>
#include <vector>

#include "effects/model.h"
#include "sim_core/scene/frame.h"

namespace seam::render {

struct GoldenFrame {
  const char* name;
  effects::Model model;
  FrameJob job;  // Of 178 x 144 pixels.
};
std::vector<GoldenFrame> golden_frames();

// "name fingerprint" lines; `threads` may split each frame.
std::string golden_frame_lines(int threads);
// The version of OpenGL, then the same frames drawn by it, and two with meshes and textures.
std::string opengl_frame_lines();

}  // namespace seam::render
