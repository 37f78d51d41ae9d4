// What the kind `ranges` needs of a robot that stands and looks at a ball: where its camera is, and
// what its behaviour measures in a frame. app/ supplies it from sim_core's robot, render/'s
// colour detection and the SDK's own detector.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "effects/model.h"
#include "sim_core/base/pose.h"

namespace seam::measurement {

struct PixelWindow {
  int u = 0, v = 0;  // First column and row.
  int width_px = 0, height_px = 0;
};

// A head at rest. World: the robot stands on z = 0 at the origin and looks along +x.
struct Gaze {
  Pose X_WL;                            // The camera's last link, before mount effects.
  std::array<double, 3> encoder_rad{};  // Tilt, pan, roll as the behaviour reads them.
};

struct RangeSighting {
  double distance_m = 0;
  double bearing_rad = 0;
};

// May be used from several threads at once.
class RangeDetector {
 public:
  virtual ~RangeDetector() = default;

  // Where the head rests after the behaviour has turned it to a ball at this distance.
  virtual Gaze gaze(const effects::Model& model, double true_m) const = 0;

  // The colour image of a frame of 8-bit rgb.
  virtual std::vector<uint8_t> colours(std::span<const uint8_t> rgb) const = 0;
  // The least window that holds this one, as far as it lies in the frame, and whose colours follow
  // from its own pixels alone.
  virtual PixelWindow whole(const PixelWindow& window) const = 0;
  // Puts the colours of such a window into those of the frame.
  virtual void recolour(const PixelWindow& window, std::span<const uint8_t> rgb,
                        std::vector<uint8_t>& colours) const = 0;

  // What the behaviour reports; nothing where it sees no ball.
  virtual std::optional<RangeSighting> measure(std::span<const uint8_t> colours,
                                               const Gaze& gaze) const = 0;
};

struct RangeDetectorSpec {
  std::string name;  // Of the behaviour.
  int width_px = 0;  // Of a frame.
  int height_px = 0;
  std::string colour_table;  // A seam-colour-table/1 file; empty: that of the field of 2002.
};

}  // namespace seam::measurement
