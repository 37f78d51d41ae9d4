// Cameras of other programs as effects of a model.
#include <algorithm>

#include "app/import/draft/points_draft.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

bool any(const std::vector<double>& k, size_t from, size_t to) {
  for (size_t i = from; i < std::min(to, k.size()); ++i) {
    if (k[i] != 0) return true;
  }
  return false;
}

double at(const std::vector<double>& k, size_t i) {
  return i < k.size() ? k[i] : 0;
}

}  // namespace

std::string effects_of(const PlainCamera& camera, const std::string& of_camera) {
  const std::string of = of_camera.empty() ? "" : "@" + of_camera;
  const Lens& lens = camera.lens;
  const std::vector<double>& k = lens.coefficients;
  std::string text =
      fmt::format("  pinhole{}: {{fx_px: {}, fy_px: {}, cx_px: {}, cy_px: {}}}\n", of,
                  exact(lens.fx_px), exact(lens.fy_px), exact(lens.cx_px), exact(lens.cy_px));
  if (lens.family == LensFamily::equidistant) {
    text += fmt::format("  fisheye{}: {{k1: {}, k2: {}, k3: {}, k4: {}}}\n", of, exact(at(k, 0)),
                        exact(at(k, 1)), exact(at(k, 2)), exact(at(k, 3)));
  } else {
    if (any(k, 5, 8)) {
      text += fmt::format("  rational_lens{}: {{k1: {}, k2: {}, k3: {}, k4: {}, k5: {}, k6: {}}}\n",
                          of, exact(at(k, 0)), exact(at(k, 1)), exact(at(k, 4)), exact(at(k, 5)),
                          exact(at(k, 6)), exact(at(k, 7)));
    } else if (any(k, 0, 2) || any(k, 4, 5)) {
      text += fmt::format("  radial_polynomial{}: {{k1: {}, k2: {}, k3: {}}}\n", of,
                          exact(at(k, 0)), exact(at(k, 1)), exact(at(k, 4)));
    }
    if (any(k, 2, 4))
      text += fmt::format("  tangential_distortion{}: {{p1: {}, p2: {}}}\n", of, exact(at(k, 2)),
                          exact(at(k, 3)));
    if (any(k, 8, 12))
      text += fmt::format("  thin_prism{}: {{s1: {}, s2: {}, s3: {}, s4: {}}}\n", of,
                          exact(at(k, 8)), exact(at(k, 9)), exact(at(k, 10)), exact(at(k, 11)));
  }
  if (camera.line_delay_s != 0)
    text +=
        fmt::format("  rolling_shutter{}: {{line_delay_s: {}}}\n", of, exact(camera.line_delay_s));
  if (camera.time_shift_s != 0)
    text += fmt::format("  frame_latency{}: {{latency_s: {}}}\n", of, exact(camera.time_shift_s));
  return text;
}

}  // namespace seam::app
