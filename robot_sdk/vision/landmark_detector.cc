#include "robot_sdk/vision/landmark_detector.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace seam::sdk {
namespace {

constexpr float kBandHeight_m = 0.100f;
constexpr float kGoalHeight_m = 0.300f;
constexpr float kEdgeSigma_px = 0.7f;  // How well a colour region's edge is known.

struct Rays {
  const HeadAtRow& head;
  const CameraBelief& camera;
  const NeckBelief& neck;
  BodyRay at(float u, float v) const { return ray_of(u, v, head(v), camera, neck); }
};

// Ground range of an upright object from the elevations of its upper and lower end.
float range_of_height(const BodyRay& top, const BodyRay& bottom, float height_m) {
  const float slope = std::tan(top.elevation_rad()) - std::tan(bottom.elevation_rad());
  return slope > 1e-4f ? height_m / slope : 0.0f;
}

// The position seen from the camera, turned into range and bearing from the body's origin.
void set_polar(LandmarkSighting& sighting, const BodyRay& ray, float range_from_camera_m) {
  const float bearing = ray.bearing_rad();
  if (range_from_camera_m == 0) {
    sighting.bearing_rad = bearing;
    return;
  }
  const float x = ray.origin_m.x + range_from_camera_m * std::cos(bearing);
  const float y = ray.origin_m.y + range_from_camera_m * std::sin(bearing);
  sighting.range_m = std::sqrt(x * x + y * y);
  sighting.bearing_rad = std::atan2(y, x);
}

// Two bands of a beacon: above each other, of about the same width.
bool are_bands(const Region& upper, const Region& lower) {
  const float size = std::max(upper.width_px(), lower.width_px());
  const float gap = static_cast<float>(lower.v_min - upper.v_max - 1);
  const float ratio = upper.width_px() / lower.width_px();
  return std::abs(upper.u_mean - lower.u_mean) < 0.5f * size &&
         std::abs(gap) <= 1.0f + 0.35f * size && upper.v_mean < lower.v_mean && ratio > 0.5f &&
         ratio < 2.0f;
}

LandmarkSighting beacon_of(LandmarkKind kind, const Region& upper, const Region& lower,
                           const ColourMask& mask, const Rays& rays) {
  LandmarkSighting sighting{.kind = kind};
  const float area = static_cast<float>(upper.area_px + lower.area_px);
  const float u = (upper.u_mean * upper.area_px + lower.u_mean * lower.area_px) / area;
  const float v = 0.5f * static_cast<float>(upper.v_max + lower.v_min);
  sighting.row = v;
  const bool whole = upper.v_min > 0 && lower.v_max < mask.height_px - 1;
  const float height_px = static_cast<float>(lower.v_max - upper.v_min + 1);
  float range = 0;
  if (whole) {
    range = range_of_height(rays.at(u, upper.v_min - 0.5f), rays.at(u, lower.v_max + 0.5f),
                            2 * kBandHeight_m);
  }
  const BodyRay middle = rays.at(u, v);
  set_polar(sighting, middle, range);
  if (range > 0) {
    sighting.height_m =
        rays.neck.body_height_m + middle.origin_m.z + range * std::tan(middle.elevation_rad());
  }
  sighting.range_sigma_m = sighting.range_m * std::sqrt(2.0f) * kEdgeSigma_px / height_px;
  // A region cut at its side has its middle displaced by up to half of what is missing.
  const bool cut = upper.u_min == 0 || upper.u_max == mask.width_px - 1;
  sighting.bearing_sigma_rad =
      (kEdgeSigma_px + (cut ? 0.5f * upper.width_px() : 0)) / rays.camera.fx_px;
  return sighting;
}

void find_beacons(const ColourMask& mask, const Rays& rays, int min_area_px,
                  std::vector<LandmarkSighting>& out, std::vector<Region>& used) {
  struct Other {
    Colour colour;
    LandmarkKind pink_low;
  };
  static constexpr std::array<Other, 3> kOthers = {
      {{Colour::yellow, LandmarkKind::beacon_yellow_pink_low},
       {Colour::skyblue, LandmarkKind::beacon_skyblue_pink_low},
       {Colour::green, LandmarkKind::beacon_green_pink_low}}};
  const auto pinks = find_regions(mask, Colour::pink, min_area_px);
  for (const Other& other : kOthers) {
    const auto regions = find_regions(mask, other.colour, min_area_px);
    for (const Region& pink : pinks) {
      for (const Region& band : regions) {
        const bool pink_low = are_bands(band, pink);
        if (!pink_low && !are_bands(pink, band)) continue;
        const auto kind =
            static_cast<LandmarkKind>(static_cast<int>(other.pink_low) + (pink_low ? 0 : 1));
        out.push_back(beacon_of(kind, pink_low ? band : pink, pink_low ? pink : band, mask, rays));
        used.push_back(band);
        break;
      }
    }
  }
}

// The middle of the widest stretch of columns in which a goal is seen down to its foot: no robot
// stands there.
float free_middle(const Region& goal, const ColourMask& mask) {
  const int half = (goal.v_min + goal.v_max + 1) / 2;
  int best_first = goal.u_min, best_last = goal.u_min - 1, first = goal.u_min;
  for (int u = goal.u_min; u <= goal.u_max; ++u) {
    int seen = 0;
    for (int v = half; v <= goal.v_max; ++v) seen += mask.has(u, v, goal.colour) ? 1 : 0;
    if (2 * seen < goal.v_max - half + 1) {
      first = u + 1;
    } else if (u - first > best_last - best_first) {
      best_first = first, best_last = u;
    }
  }
  return 0.5f * static_cast<float>(best_last < best_first ? goal.u_min + goal.u_max
                                                          : best_first + best_last);
}

void find_goal(const ColourMask& mask, Colour colour, LandmarkKind kind, const Rays& rays,
               int min_area_px, const std::vector<Region>& used,
               std::vector<LandmarkSighting>& out) {
  for (const Region& region : find_regions(mask, colour, 4 * min_area_px)) {
    const bool is_band = std::any_of(used.begin(), used.end(), [&](const Region& band) {
      return band.colour == colour && band.u_min == region.u_min && band.v_min == region.v_min;
    });
    // A goal is wider than high; its middle is known only where both sides are in the image.
    if (is_band || region.width_px() < 1.2f * region.height_px()) continue;
    if (region.u_min == 0 || region.u_max == mask.width_px - 1) continue;
    LandmarkSighting sighting{.kind = kind, .row = region.v_mean};
    const float u = 0.5f * static_cast<float>(region.u_min + region.u_max);
    float range = 0;
    if (region.v_min > 0 && region.v_max < mask.height_px - 1) {
      range = range_of_height(rays.at(u, region.v_min - 0.5f), rays.at(u, region.v_max + 0.5f),
                              kGoalHeight_m);
    }
    const BodyRay middle = rays.at(u, region.v_mean);
    set_polar(sighting, middle, range);
    sighting.free_offset_rad =
        rays.at(free_middle(region, mask), region.v_mean).bearing_rad() - middle.bearing_rad();
    // Obliquely seen, a goal's visible middle is not its mouth's: a tenth of its width is allowed
    // for.
    sighting.bearing_sigma_rad = (kEdgeSigma_px + 0.1f * region.width_px()) / rays.camera.fx_px;
    sighting.range_sigma_m = sighting.range_m * (0.15f + kEdgeSigma_px / region.height_px());
    out.push_back(sighting);
    return;
  }
}

}  // namespace

bool has_plausible_height(const LandmarkSighting& sighting) {
  constexpr float kSlack_m = 0.06f, kSway_rad = 0.03f;
  if (sighting.height_m == 0) return true;
  const float above_m = sighting.height_m - kBeaconMiddle_m;
  return above_m > -kSlack_m && above_m < kSlack_m + kSway_rad * sighting.range_m;
}

std::vector<LandmarkSighting> find_landmarks(const ColourMask& mask, const HeadAtRow& head,
                                             const CameraBelief& camera, const NeckBelief& neck,
                                             int min_area_px) {
  std::vector<LandmarkSighting> found;
  std::vector<Region> used;
  const Rays rays{head, camera, neck};
  find_beacons(mask, rays, min_area_px, found, used);
  find_goal(mask, Colour::yellow, LandmarkKind::goal_yellow, rays, min_area_px, used, found);
  find_goal(mask, Colour::skyblue, LandmarkKind::goal_skyblue, rays, min_area_px, used, found);
  return found;
}

}  // namespace seam::sdk
