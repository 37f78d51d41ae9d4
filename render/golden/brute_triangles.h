// The reference for meshes and textures: every ray against every triangle in double precision, with
// none of the renderer's code.
#pragma once

#include "render/assets/assets.h"
#include "render/golden/brute_force.h"

namespace seam::render::testing {

struct BruteScene {
  const Assets& assets;
  Rgb background;
  Lighting lighting;
};

inline double linear_of_srgb(uint8_t value) {
  const double v = value / 255.0;
  return v <= 0.04045 ? v / 12.92 : maths::pow((v + 0.055) / 1.055, 2.4);
}

// Between the middles of four texels; beyond the picture its edge or, repeated, its other side.
inline Rgb texel(const Picture& picture, double u, double v, bool repeat) {
  const double x = u * picture.width_px - 0.5, y = v * picture.height_px - 0.5;
  Rgb sum{0, 0, 0};
  for (int corner = 0; corner < 4; ++corner) {
    const double left = std::floor(x) + (corner & 1), top = std::floor(y) + (corner >> 1);
    const double share = (1 - std::abs(x - left)) * (1 - std::abs(y - top));
    const auto place = [&](double at, int size) {
      const int i = static_cast<int>(at);
      return repeat ? ((i % size) + size) % size : std::clamp(i, 0, size - 1);
    };
    const size_t i = static_cast<size_t>(place(top, picture.height_px)) * picture.width_px +
                     place(left, picture.width_px);
    for (int c = 0; c < 3; ++c) sum[c] += share * linear_of_srgb(picture.rgb[3 * i + c]);
  }
  return sum;
}

struct TriangleHit {
  double t = 1e30;
  Vec3 normal{0.0};
  Rgb rgb{0, 0, 0};
};

inline void meet_mesh(const Mesh& mesh, const Primitive& primitive, const Vec3& from,
                      const Vec3& toward, TriangleHit& best) {
  const Pose X_OW = primitive.X_WO.inverse();
  const Vec3 o = X_OW * from, d = X_OW.R * toward;
  for (const MeshPart& part : mesh.parts) {
    for (uint32_t i = part.first; i < part.first + part.count; i += 3) {
      const MeshVertex* corner[3];
      Vec3 p[3];
      for (int k = 0; k < 3; ++k) {
        corner[k] = &mesh.vertices[mesh.indices[i + k]];
        p[k] = Vec3(corner[k]->p[0], corner[k]->p[1], corner[k]->p[2]);
      }
      // Möller and Trumbore, 1997.
      const Vec3 e1 = p[1] - p[0], e2 = p[2] - p[0], q = glm::cross(d, e2);
      const double determinant = glm::dot(e1, q);
      if (std::abs(determinant) < 1e-15) continue;
      const Vec3 s = o - p[0], r = glm::cross(s, e1);
      const double b = glm::dot(s, q) / determinant, c = glm::dot(d, r) / determinant;
      const double t = glm::dot(e2, r) / determinant;
      if (b < 0 || c < 0 || b + c > 1 || t < 1e-3 || t >= best.t) continue;
      const double weight[3] = {1 - b - c, b, c};
      Vec3 normal(0.0);
      double u = 0, v = 0;
      best.rgb = {0, 0, 0};
      for (int k = 0; k < 3; ++k) {
        normal += weight[k] * Vec3(corner[k]->n[0], corner[k]->n[1], corner[k]->n[2]);
        u += weight[k] * corner[k]->uv[0], v += weight[k] * corner[k]->uv[1];
        for (int a = 0; a < 3; ++a) best.rgb[a] += weight[k] * corner[k]->rgb[a];
      }
      const Rgb look =
          part.picture < 0 ? Rgb{1, 1, 1} : texel(*mesh.pictures[part.picture], u, v, true);
      for (int a = 0; a < 3; ++a) best.rgb[a] *= look[a] * primitive.rgb[a];
      if (part.flat != 0) normal = glm::cross(e1, e2);
      normal = primitive.X_WO.R * (normal / std::sqrt(glm::dot(normal, normal)));
      best.normal = glm::dot(normal, toward) > 0 ? -normal : normal;
      best.t = t;
    }
  }
}

// A rectangle, with a texture or without: the picture's upper edge towards +y.
inline void meet_rectangle(const Picture* picture, const Primitive& primitive, const Vec3& from,
                           const Vec3& toward, TriangleHit& best) {
  const Pose X_OW = primitive.X_WO.inverse();
  const Vec3 o = X_OW * from, d = X_OW.R * toward;
  const double t = -o.z / d.z;
  const Vec3 p = o + t * d;
  if (!(t > 1e-3) || t >= best.t || std::abs(p.x) > primitive.size.x / 2 ||
      std::abs(p.y) > primitive.size.y / 2)
    return;
  best.t = t;
  best.normal = (o.z > 0 ? 1.0 : -1.0) * primitive.X_WO.R[2];
  best.rgb =
      picture ? texel(*picture, p.x / primitive.size.x + 0.5, 0.5 - p.y / primitive.size.y, false)
              : Rgb{1, 1, 1};
  for (int a = 0; a < 3; ++a) best.rgb[a] *= primitive.rgb[a];
}

inline Rgb radiance_of(const BruteScene& scene, const std::vector<Primitive>& primitives,
                       const Vec3& from, const Vec3& toward) {
  TriangleHit best;
  for (const Primitive& primitive : primitives) {
    if (primitive.shape == Shape::mesh)
      meet_mesh(scene.assets.meshes[primitive.asset - 1], primitive, from, toward, best);
    else
      meet_rectangle(
          primitive.asset == 0 ? nullptr : scene.assets.textures[primitive.asset - 1].picture.get(),
          primitive, from, toward, best);
  }
  if (best.t > 1e29) return scene.background;
  if (!scene.lighting.lambert) return best.rgb;
  const double light =
      scene.lighting.ambient +
      scene.lighting.diffuse * std::max(0.0, glm::dot(best.normal, scene.lighting.direction_W));
  for (double& value : best.rgb) value *= light;
  return best.rgb;
}

}  // namespace seam::render::testing
