// Scene radiance to a linear image: pixels integrate over their squares, rows over their windows.
#pragma once

#include "render/ray_table.h"
#include "render/renderer.h"
#include "render/row_caster.h"

namespace seam::render {

// A frame's instants as they are sampled: the job's own, or more where things move fast.
struct SamplingPlan {
  RowSchedule schedule;
  std::vector<PreparedInstant> scenes;  // One for each of schedule.instants.
};

SamplingPlan plan_sampling(const FrameJob& job, const RayTable& rays, const RendererOptions& options);

// Adds the light of the plan to the image, which is as large as the ray table (border included).
// Rows of the border see what the nearest row of the image sees, at its times: the lens, not the
// shutter, brings their light into the image. With `channel` 0 to 2 only that plane is made.
void integrate_light(const SamplingPlan& plan, const RayTable& rays, const FrameJob& job,
                     const RendererOptions& options, int channel, LinearImage& image);

}  // namespace seam::render
