// Why a robot's pictures show nothing of the world, and what of its files is not there.
#pragma once

#include "app/simulator.h"
#include "sim_core/scene/frame.h"

namespace seam::app {

// Both on stderr. Of a run that begins: what readers of the robots' files left out, and each camera
// that is inside something.
void warn_of_robots(const Simulator& simulator);
// The same of one robot and the frame that was made.
void warn_of_frame(const Simulator& simulator, size_t robot, const FrameJob& job);

}  // namespace seam::app
