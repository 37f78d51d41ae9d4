// What a renderer elsewhere gets, and its way over the wire (proto/seam/v1/render.proto): the
// scene and the cameras once, then for each frame its schedule and the states that its rows need.
#pragma once

#include <string>
#include <vector>

#include "sim_core/scenario/scenario.h"
#include "sim_core/scene/frame.h"

namespace seam::v1 {
class RenderJob;
class RenderSetup;
}  // namespace seam::v1

namespace seam::scheduler {

struct RenderCamera {
  std::string robot;
  int width_px = 0;
  int height_px = 0;
  std::string model_yaml;  // Empty: the ideal camera.
  std::string model_name;
};

// All that jobs have in common.
struct RenderSetup {
  std::string version;
  std::vector<RenderCamera> cameras;  // One a robot, in the scenario's order.
  std::vector<Primitive> scene;       // As the run starts.
  Rgb background{0, 0, 0};
  Lighting lighting;
  int samples_per_pixel = 0;
  int edge_samples_per_pixel = 0;
  double max_motion_px = 0;
  SimTime reference;
  std::string opengl;       // The driver's version where OpenGL draws.
  std::string opengl_from;  // "osmesa" or "egl".
  std::string assets;       // Then the scene's meshes and textures; the renderer's own bytes.
};

void setup_to_wire(const RenderSetup& setup, v1::RenderSetup& wire);
RenderSetup setup_from_wire(const v1::RenderSetup& wire);

// Background and lighting must be the setup's. `row_cameras` do not travel: no pixel needs them.
void job_to_wire(const RenderSetup& setup, uint64_t number, int robot, const FrameJob& job,
                 v1::RenderJob& wire);
// Throws InputError naming the field of a message that is no whole job.
FrameJob job_from_wire(const RenderSetup& setup, const v1::RenderJob& wire);

}  // namespace seam::scheduler
