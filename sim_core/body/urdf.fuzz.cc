// Whatever a URDF file holds, reading it ends in a robot whose links have places, or an InputError.
#include "sim_core/body/urdf.h"

#include <cmath>
#include <cstdlib>

#include "sim_core/base/error.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    const std::string text(reinterpret_cast<const char*>(data), size);
    seam::RobotBody body = seam::body_from_urdf(text, {"fuzz.urdf", "/tmp", ""}, {{"p", "meshes"}});
    if (body.tree.connect()) return 0;
    for (const seam::Pose& X : body.tree.link_poses({}))
      if (!std::isfinite(X.p.x + X.p.y + X.p.z)) std::abort();
    body.tree.camera_link_pose({});
  } catch (const seam::InputError&) {
  }
  return 0;
}
