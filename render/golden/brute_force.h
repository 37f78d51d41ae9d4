// The reference that the renderer is tested against: plain ray casting in double precision, one ray
// at a time against every primitive, with formulas of its own and none of the renderer's code.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "render/test_scenes.h"
#include "sim_core/base/maths.h"

namespace seam::render::testing {

struct BruteLens {
  double fx, fy, cx, cy, kappa;
  // The division model is the closed-form inverse of the founding paper's eq. 2.
  Vec3 direction(double u, double v) const {
    const double xd = (u - cx) / fx, yd = (v - cy) / fy;
    const double undo = 1 + kappa * (xd * xd + yd * yd);
    return {xd / undo, yd / undo, 1};
  }
};

// Distance along the unit ray and the outward normal, both in the world.
struct BruteHit {
  double distance = 1e30;
  Vec3 normal{0.0};
  const Primitive* primitive = nullptr;
};

class BruteCaster {
 public:
  BruteCaster(const std::vector<Primitive>& primitives, const Rgb& background,
              const Lighting& lighting)
      : primitives_(primitives), background_(background), lighting_(lighting) {}

  Rgb radiance(const Vec3& from, const Vec3& toward) const {
    const Vec3 d = toward / std::sqrt(glm::dot(toward, toward));
    BruteHit best;
    for (const Primitive& primitive : primitives_) {
      // In the object's frame, whose columns are its axes.
      const Vec3 moved = from - primitive.X_WO.p;
      const Vec3 o(glm::dot(primitive.X_WO.R[0], moved), glm::dot(primitive.X_WO.R[1], moved),
                   glm::dot(primitive.X_WO.R[2], moved));
      const Vec3 e(glm::dot(primitive.X_WO.R[0], d), glm::dot(primitive.X_WO.R[1], d),
                   glm::dot(primitive.X_WO.R[2], d));
      meet(primitive, o, e, best);
    }
    if (!best.primitive) return background_;
    Rgb rgb = best.primitive->rgb;
    if (!lighting_.lambert) return rgb;
    const Vec3 n_W = best.primitive->X_WO.R * best.normal;
    const double light =
        lighting_.ambient + lighting_.diffuse * std::max(0.0, glm::dot(n_W, lighting_.direction_W));
    for (double& value : rgb) value *= light;
    return rgb;
  }

 private:
  static void take(const Primitive& primitive, double t, const Vec3& normal, BruteHit& best) {
    // Of coplanar surfaces the later is seen (lines on the carpet).
    if (t > 1e-9 && t < best.distance * (1 + 1e-9)) best = {t, normal, &primitive};
  }

  static void meet_sphere(const Primitive& primitive, const Vec3& o, const Vec3& e,
                          const Vec3& centre, double radius, BruteHit& best) {
    const Vec3 f = o - centre;
    const double b = glm::dot(f, e), c = glm::dot(f, f) - radius * radius;
    if (b * b < c) return;
    const double t = -b - std::sqrt(b * b - c);
    take(primitive, t, (f + t * e) / radius, best);
  }

  static void meet_side(const Primitive& primitive, const Vec3& o, const Vec3& e, BruteHit& best) {
    const double radius = primitive.size.x;
    const double a = e.x * e.x + e.y * e.y, b = o.x * e.x + o.y * e.y,
                 c = o.x * o.x + o.y * o.y - radius * radius;
    if (a < 1e-18 || b * b < a * c) return;
    const double t = (-b - std::sqrt(b * b - a * c)) / a;
    const double z = o.z + t * e.z;
    if (z >= 0 && z <= primitive.size.z)
      take(primitive, t, Vec3(o.x + t * e.x, o.y + t * e.y, 0) / radius, best);
  }

  static void meet(const Primitive& primitive, const Vec3& o, const Vec3& e, BruteHit& best) {
    const Vec3& size = primitive.size;
    switch (primitive.shape) {
      case Shape::rectangle: {
        const double t = -o.z / e.z;
        const Vec3 p = o + t * e;
        if (std::abs(p.x) <= size.x / 2 && std::abs(p.y) <= size.y / 2)
          take(primitive, t, {0, 0, o.z > 0 ? 1 : -1}, best);
        return;
      }
      case Shape::sphere:
        meet_sphere(primitive, o, e, Vec3(0), size.x, best);
        return;
      case Shape::capsule:
        meet_side(primitive, o, e, best);
        meet_sphere(primitive, o, e, Vec3(0), size.x, best);
        meet_sphere(primitive, o, e, {0, 0, size.z}, size.x, best);
        return;
      case Shape::cylinder:
        meet_side(primitive, o, e, best);
        for (const double z : {0.0, size.z}) {
          const double t = (z - o.z) / e.z;
          const Vec3 p = o + t * e;
          if (p.x * p.x + p.y * p.y <= size.x * size.x)
            take(primitive, t, {0, 0, z > 0 ? 1 : -1}, best);
        }
        return;
      case Shape::mesh:  // brute_triangles.h
        return;
      case Shape::box:
        for (int axis = 0; axis < 3; ++axis) {
          for (const double sign : {-1.0, 1.0}) {
            const double t = (sign * size[axis] / 2 - o[axis]) / e[axis];
            const Vec3 p = o + t * e;
            const int other = (axis + 1) % 3, third = (axis + 2) % 3;
            if (std::abs(p[other]) > size[other] / 2 || std::abs(p[third]) > size[third] / 2)
              continue;
            Vec3 normal(0.0);
            normal[axis] = sign;
            take(primitive, t, normal, best);
          }
        }
        return;
    }
  }

  const std::vector<Primitive>& primitives_;
  Rgb background_;
  Lighting lighting_;
};

// Light of one row of the image at the window of exposure row `exposed` (they differ for the rows
// that the lens blurs into it): `instants` even instants, `rays` rays a pixel at each, spread over
// the pixel's square. Columns from -border to width + border.
inline std::vector<Rgb> brute_row(const MovingScene& scene, const BruteLens& lens,
                                  const RowWindow& window, int row, int width, int border,
                                  int instants, int rays) {
  std::vector<Rgb> light(static_cast<size_t>(width + 2 * border), Rgb{0, 0, 0});
  const double start = window.start.s(), exposure = (window.end - window.start).s();
  for (int k = 0; k < instants; ++k) {
    const double t = start + exposure * (k + 0.5) / instants;
    const std::vector<Primitive> primitives = scene.primitives(t);
    const Pose X_WC = scene.camera(t);
    const BruteCaster caster(primitives, scene.background, scene.lighting);
    for (int column = -border; column < width + border; ++column) {
      for (int j = 0; j < rays; ++j) {
        // Hammersley points of all rays of the pixel, turned by the pixel's own hash.
        const auto index = static_cast<uint32_t>(k * rays + j);
        uint32_t reversed = 0;
        for (int bit = 0; bit < 32; ++bit) reversed |= ((index >> bit) & 1u) << (31 - bit);
        const uint32_t hash = (static_cast<uint32_t>(column + 512) * 2654435761u) ^
                              (static_cast<uint32_t>(row + 512) * 2246822519u);
        const double a = index * 0.7548776662466927 + hash * 0x1p-32;
        const double du = a - std::floor(a) - 0.5;
        const double b = reversed * 0x1p-32 + (hash * 2654435761u) * 0x1p-32;
        const double dv = b - std::floor(b) - 0.5;
        const Rgb rgb = caster.radiance(X_WC.p, X_WC.R * lens.direction(column + du, row + dv));
        for (int c = 0; c < 3; ++c) light[column + border][c] += rgb[c] / (instants * rays);
      }
    }
  }
  return light;
}

// The same behind a lens of Gaussian blur: at each instant the lens blurs, then the row integrates.
inline std::vector<Rgb> brute_blurred_row(const MovingScene& scene, const BruteLens& lens,
                                          const RowWindow& window, int row, int width, double sigma,
                                          int instants, int rays) {
  const int border = static_cast<int>(std::ceil(4 * sigma));
  std::vector<double> kernel;
  double total = 0;
  for (int k = -border; k <= border; ++k)
    total += kernel.emplace_back(maths::exp(-k * k / (2 * sigma * sigma)));
  std::vector<Rgb> light(static_cast<size_t>(width), Rgb{0, 0, 0});
  for (int dv = -border; dv <= border; ++dv) {
    const std::vector<Rgb> strip =
        brute_row(scene, lens, window, row + dv, width, border, instants, rays);
    for (int u = 0; u < width; ++u) {
      for (int du = -border; du <= border; ++du) {
        const double weight = kernel[dv + border] * kernel[du + border] / (total * total);
        for (int c = 0; c < 3; ++c) light[u][c] += weight * strip[u + du + border][c];
      }
    }
  }
  return light;
}

}  // namespace seam::render::testing
