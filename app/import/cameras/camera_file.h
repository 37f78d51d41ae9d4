// Files that hold the calibrations of one or several cameras: which of them are wanted, and where
// they stand beside the first.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/import/draft/calibration.h"
#include "app/import/draft/request.h"
#include "sim_core/base/config.h"

namespace seam::app {

struct CameraFile {
  std::vector<std::string> names;
  std::function<PlainCamera(const std::string& name)> read;
  std::map<std::string, Pose> X_RC;  // In a frame that they share, of those whose pose is stated.
};

// 0 and cam0 are the same camera.
bool are_same_camera(const std::string& one, const std::string& other);

// The cameras that the request names, in its order and by its names, else the first of the file.
// Throws InputError for one that the file lacks, and where sizes differ.
std::vector<PlainCamera> chosen_cameras(const CameraFile& file, const ConfigNode& root,
                                        const ImportRequest& request, SetDraft& draft);

// A change of frames as a matrix of 4 x 4 or 3 x 4; throws where it holds no rotation.
Pose pose_in(const ConfigNode& node);

// A file of camodocal (VINS-Fusion), of ORB-SLAM, or of basalt; nothing where it is none of these.
std::optional<CameraFile> foreign_cameras(const ConfigNode& root, const ImportRequest& request,
                                          SetDraft& draft);

// The lens of the catalogue that is nearest to what a formula of another program gives; the draft
// says what that misses. `project` gives no pixel where the formula has none.
using ForeignProjection = std::function<std::optional<std::array<double, 2>>(const Vec3& p_C)>;
Lens nearest_lens(const ForeignProjection& project, const std::string& model, int width_px,
                  int height_px, const ConfigNode& node, SetDraft& draft);

}  // namespace seam::app
