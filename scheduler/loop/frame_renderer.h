// Images, known to the scheduler by interface alone; app/ supplies the real one from render/.
#pragma once

#include "sim_core/scene/frame.h"

namespace seam::scheduler {

class FrameRenderer {
 public:
  virtual ~FrameRenderer() = default;

  // How many frames may be made at once, each on a thread of its own. The number never changes
  // any pixel.
  virtual int workers() const = 0;

  // When the rows of the frame with this stamp are exposed and light is sampled; depends on the
  // robot's model, the arguments and nothing else. Called from the loop's thread.
  virtual RowSchedule schedule(int robot, uint64_t frame_index, SimTime stamp) = 0;

  // X_LC: the robot's camera in the last link of its head.
  virtual Pose mount(int robot) const = 0;

  // Makes the frame, its fingerprint included; a pure function of the job. `worker` is below
  // workers(), and no two calls with the same worker overlap; a worker keeps its thread.
  virtual Frame render(int robot, const FrameJob& job, int worker) = 0;
};

}  // namespace seam::scheduler
