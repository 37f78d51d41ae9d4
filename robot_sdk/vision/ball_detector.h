// The ball's distance and bearing from its colour region: from the area, from the centre's
// elevation and from a circle through its edge, as in section 5.1 of the founding paper.
#pragma once

#include <functional>
#include <optional>

#include "robot_sdk/vision/colour_regions.h"
#include "robot_sdk/vision/head_camera.h"

namespace seam::sdk {

inline constexpr float kBallRadius_m = 0.042f;

// The head's angles when a row was exposed (from the encoder log), or one value for the frame.
using HeadAtRow = std::function<HeadAngles(float row)>;

struct BallSighting {
  float distance_m = 0;  // On the ground, from the body's origin to the ball's centre.
  float bearing_rad = 0;  // Left positive.
  // The three estimates of the distance from the camera to the ball's centre; 0 where one is not
  // to be had (a region cut by the image's border has no trustworthy area).
  float from_area_m = 0;
  float from_centre_m = 0;
  float from_edge_m = 0;
  Region region;
};

std::optional<BallSighting> find_ball(const ColourMask& mask, const HeadAtRow& head,
                                      const CameraBelief& camera, const NeckBelief& neck,
                                      int min_area_px = 6);

}  // namespace seam::sdk
