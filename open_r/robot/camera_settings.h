// Shutter, gain and white balance that a program asks of the camera. The renderer's exposure stays:
// images are made brighter, darker, warmer or colder behind it, so that noise and blur are those of
// the camera's model.
#pragma once

#include <OPENR/OPrimitiveControl.h>

#include <array>

namespace seam::open_r {

class CameraSettings {
 public:
  // False: the request or its parameter is none of the camera's.
  bool set(OPrimitiveRequest request, longword parameter);
  // Whether images stay as they are: 1/100 s, 0 dB, 5000 K.
  bool are_default() const { return red_ == 1 && green_ == 1 && blue_ == 1; }
  // A pixel (Y, Cr, Cb) with these settings.
  std::array<byte, 3> applied(std::array<byte, 3> pixel) const;

 private:
  void update();

  double shutter_ = 1, gain_ = 1, temperature_K_ = 5000;  // The first two against the default.
  double red_ = 1, green_ = 1, blue_ = 1;
};

}  // namespace seam::open_r
