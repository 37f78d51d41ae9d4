#include "sim_core/scene/frame.h"

#include <utility>

namespace seam {

std::vector<Primitive> all_primitives(const FrameJob& job, const SceneInstant& instant) {
  std::vector<Primitive> all = job.scenery;
  all.insert(all.end(), instant.primitives.begin(), instant.primitives.end());
  for (const FigureAt& at : instant.figures) at.figure->add_parts(at.posture, all);
  return all;
}

FrameJob with_all_primitives(FrameJob job) {
  for (SceneInstant& instant : job.instants) {
    instant.primitives = all_primitives(job, instant);
    instant.figures.clear();
  }
  job.scenery.clear();
  return job;
}

}  // namespace seam
