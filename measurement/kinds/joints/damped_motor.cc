#include "measurement/kinds/joints/damped_motor.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>

#include "effects/stages/servo.h"

namespace seam::measurement {
namespace {

using effects::Model;
using effects::TorqueModel;

// Which parameter of the model is this part of the motor's equation: the one that moves it.
std::optional<Unknown> place_of(const Model& model, double TorqueModel::*part) {
  const double here = effects::servo_of(model).torque.*part;
  for (const effects::ModelEffect& effect : model.effects()) {
    if (!effect.definition->servo) continue;
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      const effects::Parameter& parameter = effect.definition->parameters[i];
      Model moved = model;
      const double value = effect.parameters[i].value;
      moved.set_value(effect.definition->name, i,
                      value < parameter.max ? std::min(parameter.max, value + parameter.scale)
                                            : parameter.max - parameter.scale);
      if (effects::servo_of(moved).torque.*part != here) return Unknown{effect.definition->name, i};
    }
  }
  return std::nullopt;
}

// Sets a part of the equation; false where the model has no such parameter, or its bounds forbid
// the value.
bool set_part(Model& model, const std::optional<Unknown>& place, double value) {
  if (!place) return false;
  const effects::Parameter& parameter =
      model.find(place->effect)->definition->parameters[place->parameter];
  if (value != parameter.neutral && (value < parameter.min || value > parameter.max)) return false;
  model.set_value(place->effect, place->parameter, value);
  return true;
}

// The duty cuts off the drive where the model's limit or duty did, with this share of the back-EMF
// in the controller.
std::optional<Model> damped(const Model& model, double share, double outside_per_s,
                            double viscous_per_s) {
  const TorqueModel motor = effects::servo_of(model).torque;
  const double strength = std::min(motor.stall_rad_per_s2, motor.limit_rad_per_s2 / motor.max_duty);
  const double stronger = motor.stall_rad_per_s2 / strength;
  const double inside_s = motor.damping_s * stronger + share * motor.back_emf_per_s / strength;
  Model other = model;
  bool fits = true;
  const auto set = [&](double TorqueModel::*part, double value) {
    if (motor.*part != value) fits = fits && set_part(other, place_of(model, part), value);
  };
  set(&TorqueModel::stall_rad_per_s2, strength);
  set(&TorqueModel::gain, motor.gain * stronger);
  set(&TorqueModel::damping_s, inside_s);
  set(&TorqueModel::back_emf_per_s, outside_per_s);
  set(&TorqueModel::viscous_per_s, viscous_per_s);
  set(&TorqueModel::limit_rad_per_s2, std::numeric_limits<double>::infinity());
  if (!fits) return std::nullopt;
  return other;
}

bool is_limited(const TorqueModel& motor) {
  return motor.present && motor.limit_rad_per_s2 < motor.stall_rad_per_s2 * motor.max_duty;
}

}  // namespace

std::optional<Model> damped_alike(const Model& model) {
  const TorqueModel motor = effects::servo_of(model).torque;
  if (!is_limited(motor) || !(motor.viscous_per_s > 0)) return std::nullopt;
  return damped(model, 1, motor.viscous_per_s, 0);
}

std::vector<Model> damped_otherwise(const Model& model) {
  std::vector<Model> others;
  const TorqueModel motor = effects::servo_of(model).torque;
  if (!motor.present || !(motor.back_emf_per_s > 0)) return others;
  for (const double share : {0.3, 0.6, 0.9}) {
    if (auto other = damped(model, share, (1 - share) * motor.back_emf_per_s, motor.viscous_per_s))
      others.push_back(std::move(*other));
  }
  return others;
}

std::vector<Model> damped_within_limit(const Model& model) {
  return is_limited(effects::servo_of(model).torque) ? damped_otherwise(model)
                                                     : std::vector<Model>();
}

std::optional<Model> undamped(const Model& model, const std::vector<Unknown>& unknowns) {
  const TorqueModel motor = effects::servo_of(model).torque;
  const auto free = [&](double TorqueModel::*part) {
    const auto parameter = place_of(model, part);
    return parameter && index_of(unknowns, *parameter);
  };
  if (!motor.present || !(motor.damping_s > 0) || !free(&TorqueModel::damping_s) ||
      !free(&TorqueModel::back_emf_per_s))
    return std::nullopt;
  Model other = model;
  const bool fits = set_part(other, place_of(model, &TorqueModel::damping_s), 0) &&
                    set_part(other, place_of(model, &TorqueModel::back_emf_per_s),
                             motor.back_emf_per_s + motor.damping_s * motor.stall_rad_per_s2);
  if (!fits) return std::nullopt;
  return other;
}

bool keeps_back_emf(const Fit& fit, const std::vector<Unknown>& unknowns) {
  constexpr double kLeastShare = 0.1, kClearly = 5;  // Of the drag; errors.
  const TorqueModel motor = effects::servo_of(fit.model).torque;
  const double inside_per_s = motor.damping_s * motor.stall_rad_per_s2;
  if (motor.back_emf_per_s >= kLeastShare * (inside_per_s + motor.back_emf_per_s)) return true;
  const auto back_emf = place_of(fit.model, &TorqueModel::back_emf_per_s);
  const auto i = back_emf ? index_of(unknowns, *back_emf) : std::nullopt;
  return i && fit.sigma[*i] > 0 && motor.back_emf_per_s > kClearly * fit.sigma[*i];
}

}  // namespace seam::measurement
