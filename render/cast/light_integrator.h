// Scene radiance to a linear image: pixels integrate over their squares, rows over their windows.
#pragma once

#include "render/base/linear_image.h"
#include "render/base/renderer_options.h"
#include "render/cast/ray_table.h"
#include "render/cast/row_caster.h"
#include "sim_core/scene/frame.h"

namespace seam::render {

// A frame's instants as they are sampled: the job's own, or more where things move fast.
struct SamplingPlan {
  RowSchedule schedule;
  std::vector<PreparedInstant> scenes;  // One for each of schedule.instants.
};

SamplingPlan plan_sampling(const FrameJob& job, const CameraRays& rays,
                           const RendererOptions& options);

// The light of the plan as an image, which is as large as the table of rays (border included).
// Rows of the border see what the nearest row of the image sees, at its times: the lens, not the
// shutter, brings their light into the image.
void integrate_light(const SamplingPlan& plan, const CameraRays& rays, const FrameJob& job,
                     const RendererOptions& options, LinearImage& image);

}  // namespace seam::render
