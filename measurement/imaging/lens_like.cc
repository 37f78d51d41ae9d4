#include "measurement/imaging/lens_like.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "effects/questions.h"
#include "effects/stages/geometry.h"
#include "effects/stages/spline_grid.h"
#include "measurement/numerics/damped_step.h"
#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {
namespace {

// Directions up to this angle from the axis, to all sides.
std::vector<Vec3> directions_within(double most_rad) {
  constexpr int kAngles = 40, kSides = 3;
  std::vector<Vec3> directions;
  for (int i = 1; i <= kAngles; ++i) {
    for (int side = 0; side < kSides; ++side) {
      const double theta = most_rad * i / kAngles, phi = 2 * std::numbers::pi * side / kSides;
      directions.emplace_back(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                              std::cos(theta));
    }
  }
  return directions;
}

// The images of the directions in turn, u then v; nothing where one has none.
std::optional<Eigen::VectorXd> images_of(const effects::Projection& projection,
                                         const std::vector<Vec3>& directions) {
  Eigen::VectorXd images(2 * static_cast<Eigen::Index>(directions.size()));
  Eigen::Index at = 0;
  for (const Vec3& direction : directions) {
    const effects::ImagePoint image = projection.project(direction);
    if (!image.has_place() || !std::isfinite(image.u) || !std::isfinite(image.v))
      return std::nullopt;
    images[at++] = image.u, images[at++] = image.v;
  }
  return images;
}

// The values of `in` with which the rest of the model maps the directions most nearly to `wanted`.
std::optional<std::vector<double>> nearest_lens(effects::Model rest,
                                                const effects::EffectDefinition& in, int width_px,
                                                int height_px, const std::vector<Vec3>& directions,
                                                const Eigen::VectorXd& wanted) {
  std::vector<double> values;
  for (const effects::Parameter& parameter : in.parameters) values.push_back(parameter.neutral);
  const auto definition = std::make_shared<const effects::EffectDefinition>(in);
  const auto left_at = [&](const std::vector<double>& there) -> std::optional<Eigen::VectorXd> {
    std::vector<effects::ParameterValue> set;
    for (const double value : there) set.push_back({.value = value});
    rest.set(definition, std::move(set));
    auto images = images_of({rest, width_px, height_px}, directions);
    if (images) *images -= wanted;
    return images;
  };
  auto here = left_at(values);
  if (!here) return std::nullopt;
  constexpr int kMost = 300;
  constexpr double kStep = 1e-6, kEnough = 1e-6;  // Of a parameter; pixels squared.
  const auto look = [&] {
    Eigen::MatrixXd slopes(here->size(), static_cast<Eigen::Index>(values.size()));
    for (size_t p = 0; p < values.size(); ++p) {
      std::vector<double> there = values;
      there[p] += kStep;
      const auto moved = left_at(there);
      const auto column = static_cast<Eigen::Index>(p);
      if (moved)
        slopes.col(column) = (*moved - *here) / kStep;
      else
        slopes.col(column).setZero();
    }
    return parabola_of(slopes, *here);
  };
  const auto move = [&](const Eigen::VectorXd& by) {
    std::vector<double> there = values;
    for (size_t p = 0; p < values.size(); ++p) {
      const effects::Parameter& parameter = in.parameters[p];
      there[p] =
          std::clamp(there[p] + by[static_cast<Eigen::Index>(p)], parameter.min, parameter.max);
    }
    const auto moved = left_at(there);
    if (!moved || !(moved->squaredNorm() < here->squaredNorm())) return false;
    values = there, here = moved;
    return true;
  };
  descend({.look = look,
           .move = move,
           .height = [&] { return 0.5 * here->squaredNorm(); },
           .worth = [&] { return Worth{.promise = kEnough}; }},
          {.start = 1e-3, .attempts = 12}, kMost);
  return values;
}

// The rays of a grid of pixels from border to border, those that the lens has.
std::vector<Vec3> rays_of_image(const effects::Projection& projection) {
  constexpr int kColumns = 29, kRows = 25;
  std::vector<Vec3> rays;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const double u = (projection.width_px() - 1.0) * column / (kColumns - 1);
      const double v = (projection.height_px() - 1.0) * row / (kRows - 1);
      if (const auto ray = projection.unproject(u, v)) rays.push_back(*ray);
    }
  }
  constexpr double kFilled = 0.7;  // Of the image; fewer say nothing of the others.
  if (static_cast<double>(rays.size()) < kFilled * kColumns * kRows) rays.clear();
  return rays;
}

// Whole degrees, as mrcal has them, between the second column of control points and the last but
// one, so that all of these rays lie within, and within the second row and the last but one.
double fov_x_deg_of(const std::vector<Vec3>& rays) {
  constexpr double kAspect = (effects::kSplineColumns - 3.0) / (effects::kSplineRows - 3.0);
  double half = 0;
  for (const Vec3& ray : rays) {
    const double to_plane = 2 / (glm::length(ray) + ray.z);
    half = std::max({half, to_plane * std::abs(ray.x), to_plane * std::abs(ray.y) * kAspect});
  }
  constexpr double kMargin = 1.02;  // Lenses change a little while they are fitted.
  return std::ceil(720 / std::numbers::pi * std::atan(kMargin * half / 2));
}

}  // namespace

std::optional<std::vector<double>> spline_lens_like(const effects::Model& model,
                                                    const effects::EffectDefinition& splines,
                                                    int width_px, int height_px) {
  effects::Model lens;
  for (const effects::ModelEffect& part : model.effects()) {
    if (part.definition->geometry || part.definition->image_map)
      lens.set(part.definition, part.parameters);
  }
  const std::vector<Vec3> rays = rays_of_image({lens, width_px, height_px});
  if (rays.empty()) return std::nullopt;
  const auto wanted = images_of({lens, width_px, height_px}, rays);
  effects::remove_replaced(splines, lens);
  std::vector<double> values(splines.parameters.size(), 0);
  values[effects::kSplineFov] = fov_x_deg_of(rays);
  const effects::Parameter& fov = splines.parameters[effects::kSplineFov];
  if (!(values[effects::kSplineFov] >= fov.min && values[effects::kSplineFov] <= fov.max))
    return std::nullopt;
  const auto definition = std::make_shared<const effects::EffectDefinition>(splines);
  const auto images_at = [&](const std::vector<double>& there) {
    std::vector<effects::ParameterValue> set;
    for (const double value : there) set.push_back({.value = value});
    lens.set(definition, std::move(set));
    return images_of({lens, width_px, height_px}, rays);
  };
  const auto plain = images_at(values);
  if (!wanted || !plain) return std::nullopt;
  // Images are linear in the values.
  const auto count = static_cast<Eigen::Index>(values.size()) - 1;
  constexpr double kStep = 1e-3, kFloor = 1e-6;
  Eigen::MatrixXd slopes(plain->size(), count);
  for (Eigen::Index p = 0; p < count; ++p) {
    std::vector<double> there = values;
    there[static_cast<size_t>(p) + 1] += kStep;
    const auto moved = images_at(there);
    if (!moved) return std::nullopt;
    slopes.col(p) = (*moved - *plain) / kStep;
  }
  Eigen::MatrixXd gram = slopes.transpose() * slopes;
  // Control points at the border that move little stay near zero.
  gram.diagonal().array() += kFloor * gram.diagonal().maxCoeff();
  const Eigen::VectorXd best = solve_symmetric(gram, slopes.transpose() * (*wanted - *plain));
  for (Eigen::Index p = 0; p < count; ++p) {
    const effects::Parameter& parameter = splines.parameters[static_cast<size_t>(p) + 1];
    values[static_cast<size_t>(p) + 1] = std::clamp(best[p], parameter.min, parameter.max);
  }
  return values;
}

std::optional<std::vector<double>> lens_like(const effects::Model& model,
                                             const effects::EffectDefinition& in, int width_px,
                                             int height_px, double most_rad) {
  effects::Model lens, rest;
  for (const effects::ModelEffect& part : model.effects()) {
    if (!part.definition->geometry && !part.definition->image_map &&
        part.definition->base != effects::Base::projection)
      continue;
    lens.set(part.definition, part.parameters);
    const bool in_its_place =
        in.term != effects::Term::none &&
        (effects::replaces(*part.definition, in.term) || part.definition->term == in.term);
    if (!in_its_place) rest.set(part.definition, part.parameters);
  }
  effects::remove_replaced(in, rest);
  std::vector<Vec3> directions = directions_within(most_rad);
  // Points of views that are met badly may lie beyond what the lens sees.
  const effects::Projection seen(lens, width_px, height_px);
  std::erase_if(directions,
                [&](const Vec3& direction) { return !seen.project(direction).visible; });
  if (directions.empty()) return std::nullopt;
  const auto wanted = images_of(seen, directions);
  if (!wanted) return std::nullopt;
  return nearest_lens(rest, in, width_px, height_px, directions, *wanted);
}

double lens_difference_px(const effects::Model& a, const effects::Model& b, int width_px,
                          int height_px) {
  const effects::Projection before(a, width_px, height_px), after(b, width_px, height_px);
  double most = 0;
  for (const double u : {0.0, 0.5, 1.0}) {
    for (const double v : {0.0, 0.5, 1.0}) {
      const auto ray = before.unproject(u * (width_px - 1), v * (height_px - 1));
      if (!ray) continue;
      const effects::ImagePoint here = before.project(*ray), there = after.project(*ray);
      if (there.visible) most = std::max(most, std::hypot(there.u - here.u, there.v - here.v));
    }
  }
  return most;
}

}  // namespace seam::measurement
