#include "effects/stages/target.h"

#include <cmath>

namespace seam::effects {

double TargetShape::bending(double a, double b) const {
  const double size = std::sqrt(warp_x_m * warp_x_m + warp_y_m * warp_y_m);
  const double along_x = size > 0 ? warp_x_m / size : std::sqrt(0.5);
  const double along_y = size > 0 ? warp_y_m / size : std::sqrt(0.5);
  return along_x * (1 - a * a) + along_y * (1 - b * b);
}

Vec3 TargetShape::placed(const Vec3& p_B, double a, double b, double flex_m) const {
  Vec3 p = p_B;
  p.x += x_scale * p_B.x + shear * p_B.y;
  p.y += y_scale * p_B.y;
  p.z += warp_x_m * (1 - a * a) + warp_y_m * (1 - b * b);
  if (flex_m != 0) p.z += flex_m * bending(a, b);
  for (const auto& map : maps) map(p);
  return p;
}

Vec3 swayed_by(const Vec3& p_B, const Vec3& shift_m, const Vec3& turn_rad) {
  return shift_m + glm::cross(turn_rad, p_B);
}

TargetShape target_of(const Model& model) {
  TargetShape shape;
  for (const ModelEffect& effect : model.effects()) {
    if (effect.definition->target) effect.definition->target(effect.values(), shape);
  }
  return shape;
}

}  // namespace seam::effects
