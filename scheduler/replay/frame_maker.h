// Frames of a recorded run, made after the fact: any robot, any time, any renderer.
#pragma once

#include <functional>

#include "scheduler/loop/frame_pipeline.h"
#include "scheduler/replay/rewinder.h"

namespace seam::scheduler {

// Makes every frame of the robot's clock whose stamp is in [from, to], in order, and hands each
// to `visit`. FrameJob::row_cameras are filled. The rewinder is left at the end of the last frame.
// Frames that end after the log's end are not made.
void make_frames(Rewinder& rewinder, FrameRenderer& renderer, int robot, SimTime from, SimTime to,
                 const std::function<void(const FinishedFrame&)>& visit);

// The clock of a robot's camera.
Clock camera_clock(const Scenario& scenario, int robot);

}  // namespace seam::scheduler
