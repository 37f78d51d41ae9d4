// Stages `radiometry` and `light`: what happens to linear light before the sensor counts it, in
// this order: lamps (flicker, uneven lighting of a flat field), lens blur, gain field, veiling
// glare, the camera's own light.
#pragma once

#include <vector>

#include "effects/model.h"
#include "effects/stages/geometry.h"
#include "effects/stages/timing.h"

namespace seam::effects {

// What radiometry effects add up to besides the gain field.
struct Optics {
  double blur_sigma_px = 0;   // Gaussian point spread, one sigma.
  int blur_window_px = 0;     // Width of the convolution's square; 0: to at least 4 sigma.
  double glare_fraction = 0;  // The image's light becomes (1 - f) L + f mean(L).
};

Optics optics_of(const Model& model);

// A row's exposure, in seconds of the set's time (what the flicker's phase counts from).
struct LightWindow {
  double start_s = 0;
  double exposure_s = 0;  // 0: an instant.
  double middle_s() const { return start_s + 0.5 * exposure_s; }
};

// The effects of stage `radiometry` (lens, in every image) or `light` (uneven lighting, which
// belongs to flat fields: scenes have their lamps in the world) whose product is the gain field.
class GainField {
 public:
  GainField(const Model& model, Stage stage, int width_px, int height_px);
  bool uniform() const { return effects_.empty(); }
  // Gain at an image point (pixels) and time (seconds since the set's reference).
  double at(double u, double v, double t_s = 0, int channel = 1) const;
  // Throws InputError with the effect's name where the gain there cannot be used.
  void check_at(double u, double v, double t_s = 0, int channel = 1) const;

 private:
  ImagePoint point_at(double u, double v, double t_s, int channel) const;

  std::vector<ModelEffect> effects_;
  int width_px_;
  int height_px_;
};

// Light that falls on the sensor whether the scene is lit or not.
class OwnLight {
 public:
  OwnLight(const Model& model, int width_px, int height_px);
  bool none() const { return effects_.empty(); }
  // At an image point (pixels), in units of the illumination at the first frame's exposure.
  double at(double u, double v) const;

 private:
  std::vector<ModelEffect> effects_;
  int width_px_;
  int height_px_;
};

// Mean brightness of the lamps over a row's window, 1 for steady lamps.
double lamp_brightness(const Model& model, const LightWindow& window);
bool lamps_flicker(const Model& model);

// sin(x) / x.
double sinc(double x);

}  // namespace seam::effects
