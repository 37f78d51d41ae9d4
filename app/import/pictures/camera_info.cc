#include "app/import/pictures/camera_info.h"

namespace seam::app {

std::optional<PlainCamera> read_camera_info(RosMessage& message, const std::string& topic,
                                            bool rectified, SetDraft& draft) {
  message.header();
  PlainCamera camera{.name = topic};
  camera.height_px = static_cast<int>(message.number() & 0x7FFFFFFF);
  camera.width_px = static_cast<int>(message.number() & 0x7FFFFFFF);
  const std::string model = message.text();
  auto d = message.reals();
  // K has 3 columns; behind it R, and P, which has 4.
  const auto take = [&](size_t columns) {
    camera.lens.fx_px = message.real();
    message.skip_reals(1);
    camera.lens.cx_px = message.real();
    message.skip_reals(columns - 2);
    camera.lens.fy_px = message.real(), camera.lens.cy_px = message.real();
  };
  take(3);
  if (rectified) {
    message.skip_reals(3 + 9);
    take(4);
    d.clear();
  }
  if (camera.lens.fx_px == 0) {
    draft.could_not_know(topic + ": the camera is not calibrated, the numbers of its matrix are 0");
    return std::nullopt;
  }
  const bool fisheye = !rectified && (model == "equidistant" || model == "fisheye");
  take_coefficients(d, fisheye, topic, camera.lens, draft);
  check_camera(camera, topic);
  return camera;
}

}  // namespace seam::app
