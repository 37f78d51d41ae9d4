// Pictures of several cameras on one rig: what was taken at once is one frame.
#pragma once

#include <string>
#include <vector>

#include "app/import/draft/points_draft.h"

namespace seam::app {

struct CameraViews {
  std::string name;
  std::vector<SeenView> views;  // Named by their pictures' files.
};

// The names in `left,right`; one that is empty where none is asked for. Throws UsageError for one
// that stands twice or is none.
std::vector<std::string> cameras_in(const std::string& words);

// The views of all cameras, those of one frame one after another under one name: by their times
// where these are known, else by what is left of their pictures' names without the camera's. Throws
// InputError for a camera that shares no frame with any other.
std::vector<SeenView> views_of_rig(std::vector<CameraViews> cameras, bool times_known,
                                   SetDraft& draft);

}  // namespace seam::app
