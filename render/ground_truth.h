// Labels, depth and optical flow from the same rays and primitives as the image.
#pragma once

#include "render/cast/light_integrator.h"
#include "render/renderer.h"

namespace seam::render {

GroundTruth make_ground_truth(const FrameJob& job, const CameraRays& rays,
                              const effects::Projection& projection, const GlDevice* opengl);

}  // namespace seam::render
