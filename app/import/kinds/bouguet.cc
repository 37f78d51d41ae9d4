// `seam import bouguet`: Calib_Results.mat of the Camera Calibration Toolbox for MATLAB.
#include <cmath>

#include "app/import/draft/points_draft.h"
#include "app/import/files/mat_file.h"
#include "app/import/kinds/kinds.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

double scalar(const MatFile& mat, const std::string& name) {
  const MatArray& array = mat.at(name);
  if (array.values.size() != 1 || !std::isfinite(array.values[0]))
    throw InputError(fmt::format("{}: {}: found {} values, expected a number", mat.file(), name,
                                 array.values.size()));
  return array.values[0];
}

double element(const MatFile& mat, const std::string& name, size_t i) {
  const MatArray& array = mat.at(name);
  if (i >= array.values.size() || !std::isfinite(array.values[i]))
    throw InputError(
        fmt::format("{}: {}: expected {} finite numbers or more", mat.file(), name, i + 1));
  return array.values[i];
}

PlainCamera camera_of(const MatFile& mat, SetDraft& draft) {
  PlainCamera camera;
  camera.width_px = static_cast<int>(std::lround(scalar(mat, "nx")));
  camera.height_px = static_cast<int>(std::lround(scalar(mat, "ny")));
  if (camera.width_px < 2 || camera.height_px < 2 || camera.width_px > 100'000 ||
      camera.height_px > 100'000)
    throw InputError(fmt::format("{}: nx, ny: found {} x {}, expected the size of the images",
                                 mat.file(), camera.width_px, camera.height_px));
  camera.lens.family = LensFamily::plumb_bob;
  camera.lens.fx_px = element(mat, "fc", 0), camera.lens.fy_px = element(mat, "fc", 1);
  camera.lens.cx_px = element(mat, "cc", 0), camera.lens.cy_px = element(mat, "cc", 1);
  for (size_t i = 0; i < 5; ++i)
    camera.lens.coefficients.push_back(mat.find("kc") == nullptr ? 0 : element(mat, "kc", i));
  // The toolbox writes three standard errors.
  if (mat.find("fc_error") != nullptr && mat.find("cc_error") != nullptr)
    camera.sigma_px = {element(mat, "fc_error", 0) / 3, element(mat, "fc_error", 1) / 3,
                       element(mat, "cc_error", 0) / 3, element(mat, "cc_error", 1) / 3};
  const double skew = mat.find("alpha_c") == nullptr ? 0 : scalar(mat, "alpha_c");
  if (skew != 0)
    draft.warn(fmt::format(
        "alpha_c {}: no effect skews pixels; left out, which costs up to {:.3g} "
        "px over the image",
        skew, std::abs(skew) * camera.height_px * 0.5 * (camera.lens.fx_px / camera.lens.fy_px)));
  return camera;
}

}  // namespace

void import_bouguet(const ImportRequest& request, SetDraft& draft) {
  if (request.sources.size() != 1)
    throw UsageError("bouguet: expected one file, Calib_Results.mat");
  const MatFile mat = MatFile::read(request.sources[0]);
  const PlainCamera camera = camera_of(mat, draft);
  draft.camera.width_px = camera.width_px, draft.camera.height_px = camera.height_px;
  const double metres = metres_in(request.length_unit.empty() ? "mm" : request.length_unit);
  std::vector<SeenView> views;
  size_t unused = 0;
  // Views are numbered from 1; the file says how many there were, used or not.
  const size_t count = mat.find("n_ima") == nullptr
                           ? mat.arrays().size()
                           : static_cast<size_t>(std::max(0.0, scalar(mat, "n_ima")));
  for (size_t k = 1; k <= std::min<size_t>(count, 100'000); ++k) {
    const MatArray* x = mat.find(fmt::format("x_{}", k));
    const MatArray* target = mat.find(fmt::format("X_{}", k));
    if (x == nullptr && target == nullptr) continue;
    if (x == nullptr || target == nullptr)
      throw InputError(
          fmt::format("{}: found one of x_{} and X_{}, expected both", mat.file(), k, k));
    if (x->values.size() < 2 || !std::isfinite(x->values[0])) {
      ++unused;
      continue;
    }
    if (x->rows != 2 || target->rows != 3 || x->columns != target->columns)
      throw InputError(
          fmt::format("{}: found x_{} of {} x {} and X_{} of {} x {}, expected 2 x n and 3 x n",
                      mat.file(), k, x->rows, x->columns, k, target->rows, target->columns));
    SeenView view{.name = fmt::format("{}", k)};
    for (size_t i = 0; i < x->columns; ++i) {
      SeenCorner corner{.point = i,
                        .p_W = metres * Vec3(target->at(0, i), target->at(1, i), target->at(2, i)),
                        .u_px = x->at(0, i),
                        .v_px = x->at(1, i)};
      if (!std::isfinite(corner.u_px) || !std::isfinite(corner.v_px) ||
          !std::isfinite(corner.p_W.x) || !std::isfinite(corner.p_W.y) ||
          !std::isfinite(corner.p_W.z))
        throw InputError(fmt::format("{}: column {} of x_{} or X_{}: found no finite number",
                                     mat.file(), i + 1, k, k));
      view.corners.push_back(corner);
    }
    views.push_back(std::move(view));
  }
  if (views.empty())
    throw InputError(fmt::format("{}: found no view, expected x_1, X_1 and so on", mat.file()));
  draft_views(views, false, &camera, mat.file(), draft);
  if (unused > 0)
    draft.did(fmt::format("{} views hold NaN, as those do that were not used", unused));
}

}  // namespace seam::app
