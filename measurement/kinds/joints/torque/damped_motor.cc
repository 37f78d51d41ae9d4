#include "measurement/kinds/joints/torque/damped_motor.h"

#include <algorithm>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <utility>

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

// The model with these parts of its equation; none where it lacks one, or its bounds forbid it.
std::optional<Model> with_parts(
    const Model& model, std::initializer_list<std::pair<double TorqueModel::*, double>> parts) {
  const TorqueModel motor = effects::servo_of(model).torque;
  Model other = model;
  for (const auto& [part, value] : parts) {
    if (motor.*part != value && !set_part(other, place_of(model, part), value)) return std::nullopt;
  }
  return other;
}

// The duty cuts off the drive where the model's limit or duty did, with this share of the back-EMF
// in the controller.
std::optional<Model> damped(const Model& model, double share, double outside_per_s,
                            double viscous_per_s) {
  const TorqueModel motor = effects::servo_of(model).torque;
  const double strength = std::min(motor.stall_rad_per_s2, motor.limit_rad_per_s2 / motor.max_duty);
  const double stronger = motor.stall_rad_per_s2 / strength;
  const double inside_s = motor.damping_s * stronger + share * motor.back_emf_per_s / strength;
  return with_parts(model,
                    {{&TorqueModel::stall_rad_per_s2, strength},
                     {&TorqueModel::gain, motor.gain * stronger},
                     {&TorqueModel::damping_s, inside_s},
                     {&TorqueModel::back_emf_per_s, outside_per_s},
                     {&TorqueModel::viscous_per_s, viscous_per_s},
                     {&TorqueModel::limit_rad_per_s2, std::numeric_limits<double>::infinity()}});
}

// Of motor and controller, where nothing saturates.
double drag_of(const TorqueModel& motor) {
  return motor.back_emf_per_s + motor.damping_s * motor.stall_rad_per_s2;
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
  return with_parts(model,
                    {{&TorqueModel::damping_s, 0}, {&TorqueModel::back_emf_per_s, drag_of(motor)}});
}

std::vector<Model> limited_otherwise(const Model& model) {
  std::vector<Model> others;
  const TorqueModel motor = effects::servo_of(model).torque;
  if (!motor.present || !(motor.damping_s > 0) || is_limited(motor)) return others;
  for (const double stronger : {1.1, 1.25, 1.5, 2.0}) {
    for (const double limit : {0.7, 0.8, 0.9}) {
      const double most = motor.stall_rad_per_s2 * motor.max_duty;
      auto other =
          with_parts(model, {{&TorqueModel::stall_rad_per_s2, stronger * motor.stall_rad_per_s2},
                             {&TorqueModel::gain, motor.gain / stronger},
                             {&TorqueModel::damping_s, 0},
                             {&TorqueModel::back_emf_per_s, drag_of(motor)},
                             {&TorqueModel::limit_rad_per_s2, limit * most}});
      if (other) others.push_back(*std::move(other));
    }
  }
  return others;
}

bool keeps_back_emf(const Fit& fit, const std::vector<Unknown>& unknowns) {
  constexpr double kLeastShare = 0.1, kClearly = 5;  // Of the drag; errors.
  const TorqueModel motor = effects::servo_of(fit.model).torque;
  if (motor.back_emf_per_s >= kLeastShare * drag_of(motor)) return true;
  const auto back_emf = place_of(fit.model, &TorqueModel::back_emf_per_s);
  const auto i = back_emf ? index_of(unknowns, *back_emf) : std::nullopt;
  return i && fit.sigma[*i] > 0 && motor.back_emf_per_s > kClearly * fit.sigma[*i];
}

}  // namespace seam::measurement
