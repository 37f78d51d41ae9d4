#include "app/import/draft/calibration.h"

#include <algorithm>
#include <cmath>

#include "app/import/draft/points_draft.h"
#include "effects/stages/lens_domain.h"
#include "sim_core/base/config.h"
#include "sim_core/base/error.h"

namespace seam::app {

void take_coefficients(const std::vector<double>& k, bool fisheye, const std::string& where,
                       Lens& lens, SetDraft& draft) {
  constexpr size_t kKnown[] = {0, 4, 5, 8, 12, 14};
  const bool known = std::find(std::begin(kKnown), std::end(kKnown), k.size()) != std::end(kKnown);
  if (fisheye ? k.size() != 4 : !known)
    throw InputError(fmt::format("{}: found {} coefficients, expected {}", where, k.size(),
                                 fisheye ? "4 (fisheye)" : "0, 4, 5, 8, 12 or 14"));
  lens.coefficients = k;
  if (fisheye) {
    lens.family = LensFamily::equidistant;
    return;
  }
  if (k.size() == 14) {
    if (k[12] != 0 || k[13] != 0)
      draft.warn(fmt::format("{}: a sensor tilted by {} and {} rad is no effect: left out", where,
                             k[12], k[13]));
    lens.coefficients.resize(12);
  }
  lens.coefficients.resize(lens.coefficients.size() <= 5   ? 5
                           : lens.coefficients.size() <= 8 ? 8
                                                           : 12);
  lens.family = lens.coefficients.size() == 5   ? LensFamily::plumb_bob
                : lens.coefficients.size() == 8 ? LensFamily::rational
                                                : LensFamily::thin_prism;
}

void check_calibrated(const std::vector<double>& matrix, const std::string& where) {
  if (std::all_of(matrix.begin(), matrix.end(), [](double number) { return number == 0; }))
    throw InputError(fmt::format(
        "{}: the camera is not calibrated: all numbers of its matrix are 0, as drivers write them "
        "that know no calibration; expected fx, fy, cx and cy in pixels: calibrate the camera "
        "(seam import images) or give the file of its calibration",
        where));
}

void doubt_lens(const PlainCamera& camera, const std::string& where, SetDraft& draft) {
  const auto model = effects::Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects:\n" + effects_of(camera), "calibration"));
  for (const std::string& doubt : effects::lens_doubts(model, camera.width_px, camera.height_px))
    draft.warn(fmt::format("{}: {}", where, doubt));
}

void check_camera(const PlainCamera& camera, const std::string& where) {
  const Lens& lens = camera.lens;
  if (camera.width_px < 2 || camera.height_px < 2 || camera.width_px > 100'000 ||
      camera.height_px > 100'000)
    throw InputError(
        fmt::format("{}: found an image of {} x {} px, expected its size (--size "
                    "WIDTHxHEIGHT where the file has none)",
                    where, camera.width_px, camera.height_px));
  if (!(lens.fx_px >= 1 && lens.fx_px <= 1e5 && lens.fy_px >= 1 && lens.fy_px <= 1e5))
    throw InputError(fmt::format("{}: found focal lengths {} and {}, expected pixels, 1 to 100000",
                                 where, lens.fx_px, lens.fy_px));
  if (!(std::abs(lens.cx_px) <= 1e5 && std::abs(lens.cy_px) <= 1e5))
    throw InputError(fmt::format("{}: found the principal point at {}, {}, expected pixels", where,
                                 lens.cx_px, lens.cy_px));
}

}  // namespace seam::app
