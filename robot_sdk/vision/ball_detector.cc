#include "robot_sdk/vision/ball_detector.h"

#include <algorithm>
#include <cmath>

namespace seam::sdk {
namespace {

constexpr float kPi = 3.14159265f;

// The distance at which a sphere of radius R has an image of this area, given the angle theta
// between its centre and the optical axis. A sphere of angular radius alpha images as an ellipse
// of area pi f^2 s^2 cos(theta) / (cos^2(theta) - s^2)^(3/2) with s = sin(alpha) = R / d.
float distance_of_radius(float radius_px, float focal_px, float cos_theta) {
  const float target = radius_px * radius_px / (focal_px * focal_px * cos_theta);
  float s2 = 0;
  for (int i = 0; i < 12; ++i) {
    const float base = std::max(cos_theta * cos_theta - s2, 1e-3f);
    s2 = std::min(target * base * std::sqrt(base), 0.9f);
  }
  return kBallRadius_m / std::sqrt(s2);
}

struct Circle {
  float u, v, radius;
};

// Algebraic least squares (Kasa): u^2 + v^2 = 2 a u + 2 b v + c, about the region's centre.
std::optional<Circle> fit_circle(const Region& region, const ColourMask& mask) {
  double n = 0, su = 0, sv = 0, suu = 0, svv = 0, suv = 0, sw = 0, suw = 0, svw = 0;
  const auto add = [&](double u, double v) {
    u -= region.u_mean, v -= region.v_mean;
    const double w = u * u + v * v;
    n += 1, su += u, sv += v, suu += u * u, svv += v * v, suv += u * v, sw += w, suw += u * w,
        svw += v * w;
  };
  int last_v = -1;
  for (size_t i = 0; i < region.runs.size(); ++i) {
    const Run& run = region.runs[i];
    if (run.v == last_v) continue;
    last_v = run.v;
    int u_last = run.u_last;
    for (size_t j = i + 1; j < region.runs.size() && region.runs[j].v == run.v; ++j)
      u_last = region.runs[j].u_last;
    if (run.u_first > 0) add(run.u_first - 0.5, run.v);
    if (u_last < mask.width_px - 1) add(u_last + 0.5, run.v);
  }
  if (n < 6) return std::nullopt;
  // Normal equations of (a, b, c) by Cramer's rule.
  const double A[3][3] = {{2 * suu, 2 * suv, su}, {2 * suv, 2 * svv, sv}, {2 * su, 2 * sv, n}};
  const double y[3] = {suw, svw, sw};
  const auto det3 = [](const double m[3][3]) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  };
  const double determinant = det3(A);
  if (std::abs(determinant) < 1e-6) return std::nullopt;
  double solution[3];
  for (int k = 0; k < 3; ++k) {
    double replaced[3][3];
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) replaced[r][c] = c == k ? y[r] : A[r][c];
    }
    solution[k] = det3(replaced) / determinant;
  }
  const double r2 = solution[2] + solution[0] * solution[0] + solution[1] * solution[1];
  if (!(r2 > 0)) return std::nullopt;
  return Circle{static_cast<float>(solution[0]) + region.u_mean,
                static_cast<float>(solution[1]) + region.v_mean, static_cast<float>(std::sqrt(r2))};
}

constexpr float kElevationSigma_rad = 0.02f;  // Of the body's and the camera's pitch together.

float distance_between(const Vector3& a, const Vector3& b) {
  const Vector3 d{a.x - b.x, a.y - b.y, a.z - b.z};
  return std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
}

// The radius in pixels of a ball on the ground where this ray, turned up by an angle, meets it; 0
// above the horizon.
float radius_on_ground(const BodyRay& ray, float up_rad, float focal_px, const NeckBelief& neck) {
  const float elevation = ray.elevation_rad() + up_rad;
  const float down_m = neck.body_height_m + ray.origin_m.z - kBallRadius_m;
  return elevation < 0 ? focal_px * kBallRadius_m * -std::sin(elevation) / down_m : 0;
}

}  // namespace

bool could_be_ball(const Region& region, const HeadAtRow& head, const CameraBelief& camera,
                   const NeckBelief& neck, float rim_px, int mask_width_px) {
  // A disc fills pi/4 of its box; a ball cut by the image's border or by a leg still fills half of
  // it.
  constexpr float kLeastFill = 0.5f, kMostRatio = 2.2f, kSlack_px = 0.8f;
  const float wide = region.width_px(), high = region.height_px();
  if (static_cast<float>(region.area_px) < kLeastFill * wide * high) return false;
  const float focal = 0.5f * (camera.fx_px + camera.fy_px);
  const BodyRay ray = ray_of(region.u_mean, region.v_mean, head(region.v_mean), camera, neck);
  const float radius = std::sqrt(static_cast<float>(region.area_px) / kPi) + rim_px;
  const float most = radius_on_ground(ray, -3 * kElevationSigma_rad, focal, neck);
  if (radius > 1.3f * most + kSlack_px) return false;
  // What lies beyond the image's border can only make a region narrow across that border.
  const bool cut_aside = region.u_min == 0 || region.u_max == mask_width_px - 1;
  const bool cut_above = region.at_border && !cut_aside;
  if (!cut_above && wide > kMostRatio * high) return false;
  if (!cut_aside && high > kMostRatio * wide) return false;
  return region.at_border ||
         radius > 0.5f * radius_on_ground(ray, 3 * kElevationSigma_rad, focal, neck) - kSlack_px;
}

std::optional<BallSighting> find_ball(const ColourMask& mask, const HeadAtRow& head,
                                      const CameraBelief& camera, const NeckBelief& neck,
                                      const BallOptions& options) {
  const auto regions = find_regions(mask, Colour::orange, options.min_area_px);
  const auto chosen = std::find_if(regions.begin(), regions.end(), [&](const Region& region) {
    return !options.check ||
           could_be_ball(region, head, camera, neck, options.rim_px, mask.width_px);
  });
  if (chosen == regions.end()) return std::nullopt;
  BallSighting ball{.region = *chosen};
  const float focal = 0.5f * (camera.fx_px + camera.fy_px);
  const auto circle = fit_circle(ball.region, mask);

  // The centre: of the circle where the ball is cut by the border, else of the area.
  float u = ball.region.u_mean, v = ball.region.v_mean;
  if (ball.region.at_border && circle) u = circle->u, v = circle->v;
  const BodyRay ray = ray_of(u, v, head(v), camera, neck);

  const float xd = (u - camera.cx_px) / camera.fx_px, yd = (v - camera.cy_px) / camera.fy_px;
  const float cos_theta = 1 / std::sqrt(1 + xd * xd + yd * yd);

  // Estimates with their spreads: half a pixel of radius, a quarter of a degree of elevation.
  float weight_sum = 0, weighted = 0;
  const auto take = [&](float distance, float sigma) {
    if (!(distance > 0.05f) || !(distance < 10)) return 0.0f;
    weight_sum += 1 / (sigma * sigma), weighted += distance / (sigma * sigma);
    return distance;
  };
  float centre_sigma = 0;
  if (const auto ground = ray.at_height(kBallRadius_m, neck.body_height_m)) {
    const float distance = distance_between(*ground, ray.origin_m);
    // d(distance)/d(elevation) = distance^2 / height for a camera at this height over the plane.
    centre_sigma = std::max(
        0.005f, distance * distance / std::abs(ground->z - ray.origin_m.z) * kElevationSigma_rad);
    ball.from_centre_m = take(distance, centre_sigma);
  }
  const auto take_size = [&](float distance, float sigma) {
    constexpr float kMostSigmas = 2.5f;
    const float apart = std::abs(distance - ball.from_centre_m);
    const float both_sigmas = std::sqrt(sigma * sigma + centre_sigma * centre_sigma);
    const bool agrees = ball.from_centre_m == 0 || apart < kMostSigmas * both_sigmas;
    return !options.check || agrees ? take(distance, sigma) : distance;
  };
  if (!ball.region.at_border) {
    const float radius = std::sqrt(static_cast<float>(ball.region.area_px) / kPi) + options.rim_px;
    const float distance = distance_of_radius(radius, focal, cos_theta);
    ball.from_area_m = take_size(distance, distance * 0.4f / radius);
  }
  if (circle) {
    const float radius = circle->radius + options.rim_px;
    const float distance = distance_of_radius(radius, focal, cos_theta);
    ball.from_edge_m = take_size(distance, distance * 0.6f / radius);
  }
  if (weight_sum == 0) return std::nullopt;
  const float distance = weighted / weight_sum;
  const float x = ray.origin_m.x + distance * ray.direction.x;
  const float y = ray.origin_m.y + distance * ray.direction.y;
  ball.distance_m = std::sqrt(x * x + y * y);
  ball.bearing_rad = std::atan2(y, x);
  return ball;
}

std::optional<BallSighting> find_ball_in_frame(const ColourMask& colours, int frame_width_px,
                                               int frame_height_px, const HeadAtRow& head,
                                               const CameraBelief& frame_camera,
                                               const NeckBelief& neck, BallOptions options) {
  options.min_area_px = colour_factor(frame_width_px, colours.width_px) > 1 ? 3 : 6;
  return find_ball(
      colours, head,
      frame_camera.of_colours(frame_width_px, frame_height_px, colours.width_px, colours.height_px),
      neck, options);
}

}  // namespace seam::sdk
