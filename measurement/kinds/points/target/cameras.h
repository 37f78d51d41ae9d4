// Cameras on one rig: each has a lens of its own and a place beside the first. A pose of the rig is
// that of its first camera.
#pragma once

#include <string>
#include <vector>

#include "effects/cameras.h"
#include "effects/stages/geometry.h"

namespace seam::measurement {

struct CameraView {
  std::string name;  // Empty where the set's cameras have none: there is one.
  int width_px = 0, height_px = 0;
};

using effects::model_of;

class Cameras {
 public:
  // One alone. Not explicit: a lens is a rig of one camera.
  Cameras(effects::Projection alone) : lenses_{std::move(alone)}, X_KC_(1) {}
  Cameras(const effects::Model& model, const std::vector<CameraView>& views);

  // The image of a point in the first camera's frame, as the camera of this number has it.
  effects::ImagePoint project(const Vec3& p_C, double t_s, double row, int camera = 0,
                              const effects::RowColumns& columns = {}) const {
    const auto k = static_cast<size_t>(camera);
    return lenses_[k].project(k == 0 ? p_C : X_KC_[k] * p_C, t_s, row, effects::kGreen, columns);
  }

  const effects::Projection& lens(int camera) const { return lenses_[static_cast<size_t>(camera)]; }
  // From the first camera's frame to this one's.
  const Pose& X_KC(int camera) const { return X_KC_[static_cast<size_t>(camera)]; }

 private:
  std::vector<effects::Projection> lenses_;
  std::vector<Pose> X_KC_;
};

}  // namespace seam::measurement
