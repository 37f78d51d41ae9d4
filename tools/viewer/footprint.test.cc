#include "tools/viewer/footprint.h"

#include <gtest/gtest.h>

namespace seam::tools {
namespace {

// By the shoelace formula.
double area_of(const Footprint& footprint) {
  double area = 0;
  const auto& corners = footprint.corners;
  for (size_t i = 0; i < corners.size(); ++i) {
    const auto &a = corners[i], &b = corners[(i + 1) % corners.size()];
    area += (a[0] * b[1] - b[0] * a[1]) / 2;
  }
  return area;
}

Primitive standing(Shape shape, const Vec3& size, const Mat3& R) {
  Primitive primitive;
  primitive.shape = shape;
  primitive.size = size;
  primitive.X_WO = {R, {1, 2, 0.5}};
  return primitive;
}

const Mat3 kLevel = rotation_about({0, 0, 1}, 0.7);
const Mat3 kUpright = rotation_about({0, 0, 1}, 0.7) * rotation_about({1, 0, 0}, maths::kPi / 2);
const double kCircle = 24 * std::sin(maths::kPi / 24) * std::cos(maths::kPi / 24);  // Of radius 1.

TEST(Footprint, IsWhatAShapeCoversFromAbove) {
  EXPECT_NEAR(area_of(footprint_of(standing(Shape::rectangle, {2, 3, 0}, kLevel), {})), 6, 1e-9);
  EXPECT_NEAR(area_of(footprint_of(standing(Shape::box, {2, 3, 4}, kUpright), {})), 8, 1e-9);
  EXPECT_NEAR(area_of(footprint_of(standing(Shape::sphere, {2, 0, 0}, kUpright), {})), 4 * kCircle,
              1e-9);
  EXPECT_NEAR(area_of(footprint_of(standing(Shape::cylinder, {1, 0, 5}, kLevel), {})), kCircle,
              1e-9);
  EXPECT_NEAR(area_of(footprint_of(standing(Shape::cylinder, {1, 0, 5}, kUpright), {})), 10, 1e-9);
  EXPECT_NEAR(area_of(footprint_of(standing(Shape::capsule, {1, 0, 5}, kUpright), {})),
              10 + kCircle, 0.1);  // Circles of corners are up to 0.9 % narrower.
}

TEST(Footprint, AWallIsALine) {
  const Footprint wall = footprint_of(standing(Shape::rectangle, {2, 3, 0}, kUpright), {});
  ASSERT_EQ(wall.corners.size(), 2u);
  EXPECT_NEAR(
      std::hypot(wall.corners[1][0] - wall.corners[0][0], wall.corners[1][1] - wall.corners[0][1]),
      2, 1e-9);
  EXPECT_NEAR(wall.top_m, 0.5 + 1.5, 1e-9);
}

TEST(Footprint, AMeshIsTheHullOfItsCorners) {
  render::Assets assets;
  assets.meshes.emplace_back();
  for (const auto& [x, y, z] :
       {std::tuple{0.f, 0.f, 0.f}, {2.f, 0.f, 0.f}, {0.f, 1.f, 3.f}, {0.5f, 0.25f, 1.f}})
    assets.meshes.back().vertices.push_back({{x, y, z}, {}, {}, {}});
  Primitive mesh = standing(Shape::mesh, {4, 0, 0}, kLevel);
  mesh.asset = 1;
  const Footprint footprint = footprint_of(mesh, &assets);
  EXPECT_EQ(footprint.corners.size(), 3u);
  EXPECT_NEAR(area_of(footprint), 1, 1e-6);
  EXPECT_NEAR(footprint.top_m, 3.5, 1e-6);
  EXPECT_NEAR(area_of(footprint_of(mesh, nullptr)), 16 * kCircle, 1e-9);
}

}  // namespace
}  // namespace seam::tools
