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

// By what views of several cameras belong to one frame.
enum class SameFrame {
  time,          // They are nearer than half the shortest time between two views of one camera.
  picture_name,  // Their pictures have one name but for the camera's.
  name,          // They have one name.
};

// The views of all cameras, those of one frame one after another under one name. Throws InputError
// for a camera that shares no frame with any other.
std::vector<SeenView> views_of_rig(std::vector<CameraViews> cameras, SameFrame by, SetDraft& draft);

}  // namespace seam::app
