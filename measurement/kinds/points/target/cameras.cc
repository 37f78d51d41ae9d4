#include "measurement/kinds/points/target/cameras.h"

namespace seam::measurement {

Cameras::Cameras(const effects::Model& model, const std::vector<CameraView>& views) {
  Pose X_LC;
  for (const CameraView& view : views) {
    const effects::Model own = model_of(model, view.name);
    lenses_.emplace_back(own, view.width_px, view.height_px, effects::Reaches::detector);
    const Pose X_LK = effects::mount_of(own);
    if (X_KC_.empty()) X_LC = X_LK;
    X_KC_.push_back(X_LK.inverse() * X_LC);
  }
}

}  // namespace seam::measurement
