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
  float distance_m = 0;   // On the ground, from the body's origin to the ball's centre.
  float bearing_rad = 0;  // Left positive.
  // The three estimates of the distance from the camera to the ball's centre; 0 where one is not
  // to be had (a region cut by the image's border has no trustworthy area).
  float from_area_m = 0;
  float from_centre_m = 0;
  float from_edge_m = 0;
  Region region;
};

struct BallOptions {
  int min_area_px = 6;
  // A region's radius is smaller than the ball's by this: pixels on the rim are half ball, half
  // what is behind it, and blurred, and the colour table takes them for nothing.
  float rim_px = 0;
  // True: regions that no ball makes are left out (see could_be_ball), and the area and the edge
  // count only where they agree with the centre's elevation; a ball half hidden looks too small for
  // where it lies.
  bool check = false;
};

// The largest orange region (of those that could be the ball) as a ball.
std::optional<BallSighting> find_ball(const ColourMask& mask, const HeadAtRow& head,
                                      const CameraBelief& camera, const NeckBelief& neck,
                                      const BallOptions& options = {});

// False for what is orange and no ball: the lines where a yellow goal meets red or the ground (too
// long, too empty), and regions of a size that a ball on the ground does not have where they are
// seen.
bool could_be_ball(const Region& region, const HeadAtRow& head, const CameraBelief& camera,
                   const NeckBelief& neck, float rim_px, int mask_width_px);

// The same in the colour image of a frame of this size, for a camera of the whole frame: what
// `Perception`, and with it `ball_ranger`, measures. The least area follows from the colour image's
// size.
std::optional<BallSighting> find_ball_in_frame(const ColourMask& colours, int frame_width_px,
                                               int frame_height_px, const HeadAtRow& head,
                                               const CameraBelief& frame_camera,
                                               const NeckBelief& neck, BallOptions options = {});

}  // namespace seam::sdk
