// Beacons and goals from colour regions: bearings, and ranges from apparent heights.
#pragma once

#include <vector>

#include "robot_sdk/vision/ball_detector.h"

namespace seam::sdk {

// Landmarks of the 2002/2003 field. A beacon is named by its other colour and by whether pink is
// its upper band (y = -1.45 m) or its lower one (y = +1.45 m).
enum class LandmarkKind : uint8_t {
  beacon_yellow_pink_low,
  beacon_yellow_pink_high,
  beacon_skyblue_pink_low,
  beacon_skyblue_pink_high,
  beacon_green_pink_low,
  beacon_green_pink_high,
  goal_yellow,
  goal_skyblue,
};
inline constexpr int kLandmarkKinds = 8;

struct LandmarkSighting {
  LandmarkKind kind{};
  float bearing_rad = 0;  // In the body frame, left positive.
  float range_m = 0;      // On the ground from the body's origin; 0 where it is not determined.
  float bearing_sigma_rad = 0;
  float range_sigma_m = 0;
  float row = 0;  // Where in the image it was seen.
  // Of a goal: from its middle to the middle of the widest part that nobody stands before, left
  // positive.
  float free_offset_rad = 0;
  float height_m = 0;  // Above the ground, of the place where a beacon's bands meet; 0 where it is
                       // not determined.
};

// Where a beacon's bands meet, above the ground.
inline constexpr float kBeaconMiddle_m = 0.3f;

// False for what only looks like a beacon (a uniform before the goal): its bands meet too low or
// too high. The slack upwards grows with the range, since the body sways while it walks; what
// robots and the ball look like is never much higher than a beacon's lower band, so that the slack
// downwards is narrow.
bool has_plausible_height(const LandmarkSighting& sighting);

std::vector<LandmarkSighting> find_landmarks(const ColourMask& mask, const HeadAtRow& head,
                                             const CameraBelief& camera, const NeckBelief& neck,
                                             int min_area_px = 12);

}  // namespace seam::sdk
