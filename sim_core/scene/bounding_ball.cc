#include "sim_core/scene/bounding_ball.h"

#include <cmath>

namespace seam {

Vec3 bounding_centre(const Primitive& primitive) {
  const bool stands = primitive.shape == Shape::cylinder || primitive.shape == Shape::capsule;
  return {0, 0, stands ? 0.5 * primitive.size.z : 0};
}

double bounding_radius(const Primitive& primitive) {
  const Vec3& size = primitive.size;
  switch (primitive.shape) {
    case Shape::rectangle:
      return 0.5 * std::sqrt(size.x * size.x + size.y * size.y);
    case Shape::sphere:
      return size.x;
    case Shape::cylinder:
      return std::sqrt(size.x * size.x + 0.25 * size.z * size.z);
    case Shape::capsule:
      return size.x + 0.5 * size.z;
    case Shape::box:
      return 0.5 * std::sqrt(glm::dot(size, size));
    case Shape::mesh:
      return size.x;
  }
  return 0;
}

}  // namespace seam
