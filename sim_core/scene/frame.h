// What passes between the loop, the renderer and the camera: row windows, light-sampling instants,
// and the finished frame.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim_core/base/random.h"
#include "sim_core/base/time.h"
#include "sim_core/scene/scene.h"

namespace seam {

// The interval over which one row collects light.
struct RowWindow {
  SimTime start;
  SimTime end;  // Equal to start for an instantaneous shutter.
};

// When a frame samples light. All rows share one ascending list of instants; each row integrates
// over the instants inside its window with weights of its own, which make the quadrature exact for
// linear motion (sum of weights 1, weighted mean time = the window's middle).
struct RowSchedule {
  std::vector<SimTime> instants;
  std::vector<RowWindow> rows;
  std::vector<int> first_instant;  // For each row, where its weights start.
  std::vector<std::vector<double>>
      weights;  // For each row; weights[row][k] is of instant first + k.
};

// Everything a renderer needs to make one frame, and nothing of the live world but its figures,
// which do not change and must outlive the job.
struct FrameJob {
  std::string robot;         // Whose camera, and with it which model.
  uint64_t frame_index = 0;  // By the camera's clock.
  SimTime stamp;             // Start of row 0 by the camera's clock.
  RowSchedule schedule;
  std::vector<Primitive> scenery;      // What stands still, in front of the instants' primitives.
  std::vector<SceneInstant> instants;  // One for each of schedule.instants, in that order.
  std::vector<Pose>
      row_cameras;  // X_WC at the middle of each row's window; empty unless asked for.
  Rgb background{0, 0, 0};
  Lighting lighting;
  RandomStream camera_noise;  // Of this camera: fixed patterns are drawn from it alone.
  RandomStream frame_noise;   // Of this frame: camera_noise.child("frame").child(frame_index).
};

// All primitives of one of the job's instants in their order: scenery, primitives, figures' parts.
std::vector<Primitive> all_primitives(const FrameJob& job, const SceneInstant& instant);
// The same job with all of them in its instants' primitives.
FrameJob with_all_primitives(FrameJob job);

struct Frame {
  std::string robot;
  uint64_t frame_index = 0;
  SimTime stamp;
  int width_px = 0;
  int height_px = 0;
  std::vector<RowWindow> rows;
  std::vector<uint8_t> rgb;    // Row-major, interleaved, 8 bits: what the sensor's ADC gives.
  std::vector<uint8_t> ycrcb;  // The same as OPEN-R's Y, Cr, Cb.
  // The colour detection table's output, a bit a channel; empty where the camera has no table.
  std::vector<uint8_t> colours;
  int colours_width_px = 0;
  int colours_height_px = 0;
  uint64_t fingerprint = 0;  // Over size, stamp, row windows and rgb, in that order.
};

}  // namespace seam
