#include "app/import/cameras/camera_file.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/import/files/storage.h"
#include "app/import/pictures/rig_views.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::app {

bool are_same_camera(const std::string& one, const std::string& other) {
  const auto number = [](const std::string& name) -> std::string {
    const size_t digits = name.find_last_not_of("0123456789") + 1;
    const std::string letters = name.substr(0, digits);
    return letters.empty() || letters == "cam" ? name.substr(digits) : "";
  };
  return one == other || (!number(one).empty() && number(one) == number(other));
}

std::vector<PlainCamera> chosen_cameras(const CameraFile& file, const ConfigNode& root,
                                        const ImportRequest& request, SetDraft& draft) {
  const std::vector<std::string>& names = file.names;
  std::vector<std::string> wanted = {names.front()};
  if (!request.camera.empty()) wanted = cameras_in(request.camera);
  if (request.camera.empty() && names.size() > 1)
    draft.did(
        fmt::format("of {} cameras the first, {} (--camera; --camera {} takes them as one rig)",
                    names.size(), names.front(), fmt::join(names, ",")));
  std::vector<PlainCamera> cameras;
  std::optional<Pose> X_RF;  // Of the first.
  for (const std::string& one : wanted) {
    const auto found = std::find_if(names.begin(), names.end(), [&](const std::string& name) {
      return are_same_camera(name, one);
    });
    if (found == names.end())
      root.fail(fmt::format("--camera {}: no such camera{}, expected {}", one,
                            suggestion_for(one, names), fmt::join(names, ", ")));
    PlainCamera camera = file.read(*found);
    camera.name = one;
    const auto place = file.X_RC.find(*found);
    if (cameras.empty() && place != file.X_RC.end()) X_RF = place->second;
    if (!cameras.empty() && X_RF && place != file.X_RC.end())
      camera.X_FC = X_RF->inverse() * place->second;
    cameras.push_back(std::move(camera));
    const PlainCamera &first = cameras.front(), &last = cameras.back();
    if (last.width_px != first.width_px || last.height_px != first.height_px)
      root.fail(fmt::format(
          "cameras {} and {} have images of {} x {} and {} x {} px, expected one "
          "size, which a set has for all of its cameras",
          first.name, one, first.width_px, first.height_px, last.width_px, last.height_px));
  }
  if (wanted.size() == 1 && names.size() > 1)
    draft.could_not_know(
        "what the places of the cameras beside each other would be good for: one camera is taken, "
        "and each view's pose is free");
  return cameras;
}

Pose pose_in(const ConfigNode& node) {
  const auto t = numbers_in(node);
  if (t.size() != 16 && t.size() != 12)
    node.fail(fmt::format("found {} numbers, expected 4 x 4", t.size()));
  Pose pose;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      pose.R[column][row] = t[static_cast<size_t>(4 * row + column)];
    pose.p[row] = t[static_cast<size_t>(4 * row + 3)];
  }
  const Mat3 square = pose.R * glm::transpose(pose.R);
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      if (!(std::abs(square[column][row] - (row == column ? 1 : 0)) < 1e-3))
        node.fail("expected a rotation in the first three columns and rows");
    }
  }
  return pose;
}

Lens nearest_lens(const ForeignProjection& project, const std::string& model, int width_px,
                  int height_px, const ConfigNode& node, SetDraft& draft) {
  constexpr double kDegree = std::numbers::pi / 180;
  constexpr int kWays = 48, kMostDegrees = 120;
  std::vector<Sight> sights;
  for (int way = 0; way < kWays; ++way) {
    const double around = 2 * std::numbers::pi * way / kWays;
    double before_px = -1;
    const auto axis = project({0, 0, 1});
    for (int k = 0; k <= kMostDegrees && axis; ++k) {
      const double s = maths::sin(k * kDegree);
      const Vec3 ray(s * maths::cos(around), s * maths::sin(around), maths::cos(k * kDegree));
      const auto seen = project(ray);
      if (!seen) break;
      const auto [u, v] = *seen;
      const double radius_px = std::hypot(u - (*axis)[0], v - (*axis)[1]);
      const bool inside = u > -1 && v > -1 && u < width_px && v < height_px;
      if (!inside || !(radius_px > before_px)) break;
      before_px = radius_px;
      sights.push_back({ray, u, v});
    }
  }
  if (sights.size() < 100)
    node.fail(
        fmt::format("model '{}' leads {} of the rays tried into the image of {} x {} px, "
                    "expected a lens that fills it",
                    model, sights.size(), width_px, height_px));
  using enum LensFamily;
  const LensFit fit = best_lens(sights, {plumb_bob, rational, equidistant}, width_px, height_px);
  const std::string sentence = fmt::format(
      "{}: the model '{}' is no effect of the catalogue; its nearest lens is {}, which misses by "
      "{:.2g} px (root mean square), {:.2g} px at most over the image",
      node.where(), model, words_of(fit.lens.family), fit.rms_px, fit.most_px);
  constexpr double kVisible_px = 0.1;
  if (fit.most_px > kVisible_px) {
    draft.warn(sentence);
  } else {
    draft.did(sentence);
  }
  return fit.lens;
}

}  // namespace seam::app
