// Scene radiance to a linear image: pixels integrate over their squares, rows over their windows.
#pragma once

#include <functional>

#include "render/base/linear_image.h"
#include "render/base/renderer_options.h"
#include "render/cast/ray_table.h"
#include "render/cast/row_caster.h"
#include "sim_core/scene/frame.h"

namespace seam::render {

// A frame's instants as they are sampled: the job's own, or more where things move fast.
class SampledInstants {
 public:
  SampledInstants(const FrameJob& job, const CameraRays& rays, const RendererOptions& options);
  // At least so many a row, and no fewer than the job has.
  SampledInstants(const FrameJob& job, const CameraRays& rays, int a_row);

  const RowSchedule& schedule() const { return refined_ ? finer_ : job_.schedule; }
  int count() const { return static_cast<int>(schedule().instants.size()); }
  int fewest_a_row() const { return fewest_a_row_; }
  // Rows of rays that sample this instant, from the first to the last; rows of the border go with
  // the nearest row of the image.
  RowRange rows_of(int k) const { return rows_[k]; }
  void with_scene(int k, const std::function<void(const SceneInstant&)>& see) const;

 private:
  const FrameJob& job_;
  bool refined_ = false;
  RowSchedule finer_;
  int fewest_a_row_ = 0;
  std::vector<RowRange> rows_;
};

struct SamplingPlan {
  SampledInstants instants;
  std::vector<PreparedInstant> scenes;  // One for each instant.
};

SamplingPlan plan_sampling(const FrameJob& job, const CameraRays& rays,
                           const RendererOptions& options);

// The light of the plan as an image, which is as large as the table of rays (border included).
// Rows of the border see what the nearest row of the image sees, at its times: the lens, not the
// shutter, brings their light into the image.
void integrate_light(const SamplingPlan& plan, const CameraRays& rays, const FrameJob& job,
                     const RendererOptions& options, LinearImage& image);

}  // namespace seam::render
