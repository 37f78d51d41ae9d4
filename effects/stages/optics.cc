#include "effects/stages/optics.h"

#include <cmath>

#include "effects/not_a_number.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::effects {

Optics optics_of(const Model& model) {
  Optics optics;
  for (const ModelEffect& effect : model.effects()) {
    if (effect.definition->optics) effect.definition->optics(effect.values(), optics);
  }
  return optics;
}

GainField::GainField(const Model& model, Stage stage, int width_px, int height_px)
    : width_px_(width_px), height_px_(height_px) {
  for (const ModelEffect& effect : model.effects()) {
    if (effect.definition->gain && effect.definition->stage == stage) effects_.push_back(effect);
  }
}

ImagePoint GainField::point_at(double u, double v, double t_s, int channel) const {
  return {.u = u,
          .v = v,
          .t_s = t_s,
          .row = v,
          .channel = channel,
          .width_px = width_px_,
          .height_px = height_px_};
}

void GainField::check_at(double u, double v, double t_s, int channel) const {
  const ImagePoint point = point_at(u, v, t_s, channel);
  for (const ModelEffect& effect : effects_) {
    const double gain = effect.definition->gain(effect.values(), point);
    if (!usable(gain, kLargestOfImage))
      fail_with(effect.definition->name, "gain", gain, fmt::format("pixel ({:g}, {:g})", u, v));
  }
}

double GainField::at(double u, double v, double t_s, int channel) const {
  const ImagePoint point = point_at(u, v, t_s, channel);
  double gain = 1;
  for (const ModelEffect& effect : effects_) {
    gain *= effect.definition->gain(effect.values(), point);
  }
  return gain;
}

OwnLight::OwnLight(const Model& model, int width_px, int height_px)
    : width_px_(width_px), height_px_(height_px) {
  for (const ModelEffect& effect : model.effects()) {
    if (effect.definition->own_light) effects_.push_back(effect);
  }
}

double OwnLight::at(double u, double v) const {
  const ImagePoint point{.u = u, .v = v, .row = v, .width_px = width_px_, .height_px = height_px_};
  double light = 0;
  for (const ModelEffect& effect : effects_)
    light += effect.definition->own_light(effect.values(), point);
  return light;
}

double lamp_brightness(const Model& model, const LightWindow& window) {
  double light = 1;
  for (const ModelEffect& effect : model.effects()) {
    if (effect.definition->light) light *= effect.definition->light(effect.values(), window);
  }
  return light;
}

bool lamps_flicker(const Model& model) {
  for (const ModelEffect& effect : model.effects()) {
    if (effect.definition->light) return true;
  }
  return false;
}

double sinc(double x) {
  return std::abs(x) < 1e-8 ? 1.0 : maths::sin(x) / x;
}

}  // namespace seam::effects
