// Fixed frames whose fingerprints are pinned (golden_frames.txt): every shape and every effect, so
// that a bit that differs between machines, compilers, vector widths or threads is found.
#pragma once

#include <string>

namespace seam::render {

// "name fingerprint" lines; `threads` may split each frame.
std::string golden_frame_lines(int threads);

}  // namespace seam::render
