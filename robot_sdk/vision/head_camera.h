// Where a pixel looks: from image points to directions in the robot's body frame (x forward,
// y left, z up), through the ERS-210's neck. Single precision throughout: its functions give the
// same bits on all machines, so a behaviour's decisions do too.
#pragma once

#include <optional>

namespace seam::sdk {

struct Vector3 {
  float x = 0, y = 0, z = 0;
};

struct HeadAngles {
  float tilt_rad = 0;  // Up positive.
  float pan_rad = 0;   // Left positive.
  float roll_rad = 0;
};

// The camera as the behaviour believes it to be (nominal ERS-210 values).
struct CameraBelief {
  float fx_px = 161.9f, fy_px = 162.5f, cx_px = 88.5f, cy_px = 71.5f;
  float kappa = 0;  // Radial distortion, eq. 2 of the founding paper; undone exactly.

  // The same camera for a colour image that is smaller than its frame by a whole factor and taken
  // about the frame's centre.
  CameraBelief of_colours(int frame_width_px, int frame_height_px, int width_px,
                          int height_px) const;
};

// By how much a frame is larger than its colour image.
int colour_factor(int frame_width_px, int colours_width_px);

// Neck geometry in metres (robot_facts: Tekkotsu ERS-210.kin) and the body's height when walking.
struct NeckBelief {
  float tilt_axis_forward_m = 0.075f;
  float tilt_axis_up_m = 0.050f;
  float neck_m = 0.048f;
  float camera_forward_m = 0.0666f;
  float body_height_m = 0.1354f;  // Body origin above the ground.
};

// A ray in the body frame: the camera's position and a unit direction.
struct BodyRay {
  Vector3 origin_m;
  Vector3 direction;

  float bearing_rad() const;    // Left positive, about the body's z-axis.
  float elevation_rad() const;  // Up positive.
  // Where it meets the plane z = height above the ground, or nothing when it points away.
  std::optional<Vector3> at_height(float height_above_ground_m, float body_height_m) const;
};

BodyRay ray_of(float u_px, float v_px, const HeadAngles& head, const CameraBelief& camera,
               const NeckBelief& neck);

}  // namespace seam::sdk
