// Frames of a replay log as a set of whole images: the pictures that a robot took, where its
// camera was, and the scene that it saw.
#pragma once

#include "app/import/draft/set_draft.h"
#include "scheduler/log/log.h"

namespace seam::app {

// The match is run again, since logs keep the pictures of few frames. `robot` is its place in the
// scenario. Throws InputError where its camera took none.
void draft_frames(const scheduler::Log& log, size_t robot, SetDraft& draft);

}  // namespace seam::app
