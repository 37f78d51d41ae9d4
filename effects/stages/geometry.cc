#include "effects/stages/geometry.h"

#include <cmath>

#include "effects/exact_key.h"
#include "effects/not_a_number.h"
#include "effects/questions.h"
#include "effects/registry.h"
#include "sim_core/base/error.h"

namespace seam::effects {

Projection::Projection(const Model& model, int width_px, int height_px, Reaches end)
    : width_px_(width_px), height_px_(height_px), end_(end) {
  if (base_of(model, Base::projection) == nullptr) {
    throw InputError(fmt::format("the model has no '{}', expected one: it makes the image",
                                 base_name(Base::projection)));
  }
  if (const ModelEffect* lens = replacement_in(model); lens != nullptr) {
    throw InputError(
        fmt::format("the model has '{}' and another radial effect, expected one of them",
                    lens->definition->name));
  }
  for (const ModelEffect& effect : model.effects()) {
    if (!camera_of(effect.definition->name).empty())
      throw InputError(fmt::format("'{}' is one camera's own, expected a model of one camera",
                                   effect.definition->name));
    const EffectDefinition& definition = *effect.definition;
    const bool lens = definition.geometry || definition.image_map;
    const bool acts = end == Reaches::detector ? lens || definition.corner_detector
                                               : lens && !of_points_alone(definition);
    if (acts) effects_.push_back(effect);
  }
}

std::string Projection::key() const {
  std::string key =
      fmt::format("{}x{}{};", width_px_, height_px_, end_ == Reaches::light ? "" : "d");
  for (const ModelEffect& effect : effects_) key += exact_key(effect);
  return key;
}

ImagePoint Projection::before_formulas(const Vec3& p_C, double t_s, double row, int channel,
                                       const RowColumns& columns) const {
  ImagePoint point{.p_C = p_C,
                   .t_s = t_s,
                   .row = row,
                   .channel = channel,
                   .width_px = width_px_,
                   .height_px = height_px_,
                   .columns = columns};
  // Behind the camera only a fisheye sees; it sets `visible` and x, y itself.
  point.visible = p_C.z > 0;
  point.x = point.xd = p_C.x / p_C.z;
  point.y = point.yd = p_C.y / p_C.z;
  for (const ModelEffect& effect : effects_) {
    if (effect.definition->geometry) effect.definition->geometry(effect.values(), point);
  }
  point.u = point.fx * point.xd + point.cx;
  point.v = point.fy * point.yd + point.cy;
  return point;
}

ImagePoint Projection::project(const Vec3& p_C, double t_s, double row, int channel,
                               const RowColumns& columns) const {
  ImagePoint point = before_formulas(p_C, t_s, row, channel, columns);
  for (const ModelEffect& effect : effects_) {
    if (effect.definition->image_map) effect.definition->image_map(effect.values(), point);
  }
  point.light_v = point.v;
  if (end_ == Reaches::detector) {
    for (const ModelEffect& effect : effects_) {
      if (effect.definition->corner_detector)
        effect.definition->corner_detector(effect.values(), point);
    }
  }
  if (!std::isfinite(point.u) || !std::isfinite(point.v)) point.visible = point.at_edge = false;
  return point;
}

void Projection::check_at(double u, double v, double t_s, int channel) const {
  const ImagePoint axis = before_formulas({0, 0, 1}, t_s, v, channel, {});
  ImagePoint point =
      before_formulas({(u - axis.cx) / axis.fx, (v - axis.cy) / axis.fy, 1}, t_s, v, channel, {});
  for (const ModelEffect& effect : effects_) {
    if (!effect.definition->image_map) continue;
    effect.definition->image_map(effect.values(), point);
    for (const auto& [name, value] : {std::pair{"u", point.u}, std::pair{"v", point.v}}) {
      if (!usable(value, kLargestOfImage))
        fail_with(effect.definition->name, name, value,
                  fmt::format("pixel ({:g}, {:g}) at {:.9g} s", u, v, t_s));
    }
  }
}

std::optional<Vec3> Projection::unproject(double u, double v, double t_s, int channel) const {
  // Newton's method over the direction, from the axis outwards along the undistorted guess.
  const ImagePoint axis = project({0, 0, 1}, t_s, v, channel);
  if (!axis.visible) return std::nullopt;
  double x = (u - axis.u) / axis.fx;
  double y = (v - axis.v) / axis.fy;
  for (int shrink = 0; shrink < 8 && !project({x, y, 1}, t_s, v, channel).visible; ++shrink)
    x *= 0.7, y *= 0.7;
  for (int step = 0; step < 30; ++step) {
    const ImagePoint here = project({x, y, 1}, t_s, v, channel);
    if (!here.visible) return std::nullopt;
    const double error_u = u - here.u;
    const double error_v = v - here.v;
    if (std::abs(error_u) < 1e-10 && std::abs(error_v) < 1e-10) return Vec3{x, y, 1};
    constexpr double kStep = 1e-6;
    const ImagePoint px = project({x + kStep, y, 1}, t_s, v, channel);
    const ImagePoint py = project({x, y + kStep, 1}, t_s, v, channel);
    if (!px.visible || !py.visible) return std::nullopt;
    const double a = (px.u - here.u) / kStep, b = (py.u - here.u) / kStep;
    const double c = (px.v - here.v) / kStep, d = (py.v - here.v) / kStep;
    const double determinant = a * d - b * c;
    // A lens whose image folds back has no inverse there.
    if (!(determinant * axis.fx * axis.fy > 0)) return std::nullopt;
    double dx = (d * error_u - b * error_v) / determinant;
    double dy = (a * error_v - c * error_u) / determinant;
    for (int half = 0; half < 20 && !project({x + dx, y + dy, 1}, t_s, v, channel).visible; ++half)
      dx /= 2, dy /= 2;
    x += dx, y += dy;
  }
  const ImagePoint end = project({x, y, 1}, t_s, v, channel);
  if (!end.visible || std::abs(end.u - u) > 1e-6 || std::abs(end.v - v) > 1e-6) return std::nullopt;
  return Vec3{x, y, 1};
}

Pose mount_of(const Model& model) {
  Pose X_LC;
  for (const ModelEffect& effect : model.effects()) {
    if (effect.definition->mount) effect.definition->mount(effect.values(), X_LC);
  }
  return X_LC * rotation(link_to_camera_axes());
}

double rho(double u, double v, int width_px, int height_px) {
  const double du = u - 0.5 * (width_px - 1);
  const double dv = v - 0.5 * (height_px - 1);
  return std::sqrt((du * du + dv * dv) /
                   (0.25 * width_px * width_px + 0.25 * height_px * height_px));
}

}  // namespace seam::effects
