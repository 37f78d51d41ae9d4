#include "render/assets/enclosed.h"

#include <algorithm>
#include <cmath>

namespace seam::render {
namespace {

// Of all directions from p, how many the triangles cover, those that run clockwise counted against
// the others (Van Oosterom and Strackee, 1983).
double covered_share(const Mesh& mesh, const Vec3& p) {
  double sum = 0;
  for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const Vec3 a = mesh.place_of(mesh.indices[i]) - p, b = mesh.place_of(mesh.indices[i + 1]) - p,
               c = mesh.place_of(mesh.indices[i + 2]) - p;
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    const double volume = glm::dot(a, glm::cross(b, c));
    const double rest =
        la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb;
    if (volume != 0 || rest != 0) sum += 2 * maths::atan2(volume, rest);
  }
  return sum / (4 * maths::kPi);
}

}  // namespace

bool is_inside(const Primitive& primitive, const Vec3& p, const Assets& assets) {
  const Vec3& size = primitive.size;
  const double aside = std::sqrt(p.x * p.x + p.y * p.y);
  switch (primitive.shape) {
    case Shape::rectangle:
      return false;
    case Shape::sphere:
      return glm::length(p) < size.x;
    case Shape::cylinder:
      return aside < size.x && p.z > 0 && p.z < size.z;
    case Shape::capsule:
      return glm::length(p - Vec3(0, 0, std::clamp(p.z, 0.0, size.z))) < size.x;
    case Shape::box:
      return 2 * std::abs(p.x) < size.x && 2 * std::abs(p.y) < size.y && 2 * std::abs(p.z) < size.z;
    case Shape::mesh:
      break;
  }
  if (primitive.asset == 0 || primitive.asset > assets.meshes.size()) return false;
  const Mesh& mesh = assets.meshes[primitive.asset - 1];
  return glm::length(p) < mesh.radius_m && std::abs(covered_share(mesh, p)) > 0.5;
}

}  // namespace seam::render
