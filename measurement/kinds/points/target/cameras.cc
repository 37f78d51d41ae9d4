#include "measurement/kinds/points/target/cameras.h"

#include "effects/registry.h"

namespace seam::measurement {

effects::Model model_of(const effects::Model& model, const std::string& camera) {
  effects::Model own;
  for (const effects::ModelEffect& effect : model.effects()) {
    const std::string& name = effect.definition->name;
    const std::string of = effects::camera_of(name);
    if (of.empty()) {
      if (camera.empty() || !model.has(name + "@" + camera))
        own.set(effect.definition, effect.parameters);
    } else if (of == camera) {
      own.set(effects::find_effect(effects::plain_name(name)), effect.parameters);
    }
  }
  return own;
}

Cameras::Cameras(const effects::Model& model, const std::vector<CameraView>& views) {
  Pose X_LC;
  for (const CameraView& view : views) {
    const effects::Model own = model_of(model, view.name);
    lenses_.emplace_back(own, view.width_px, view.height_px);
    const Pose X_LK = effects::mount_of(own);
    if (X_KC_.empty()) X_LC = X_LK;
    X_KC_.push_back(X_LK.inverse() * X_LC);
  }
}

}  // namespace seam::measurement
