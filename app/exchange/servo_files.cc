#include "app/exchange/servo_files.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "effects/questions.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

using effects::Model;
using effects::ModelEffect;
using effects::ServoModel;
using effects::TorqueModel;

// What both formats have no word for.
bool is_simple(const ServoModel& servo) {
  const TorqueModel& t = servo.torque;
  return servo.latency_s == 0 && !std::isfinite(servo.rad_per_s2) && servo.dead_band_rad == 0 &&
         servo.backlash_rad == 0 && servo.sag_rad == 0 && servo.formulas.empty() &&
         t.gravity_rad_per_s2 == 0 && t.stribeck_rad_per_s2 == 0 && t.load_fraction == 0 &&
         t.carried_fraction == 0 && t.asymmetry_rad_per_s2 == 0 && t.cogging_rad_per_s2 == 0;
}

// An XML comment may hold no "--".
std::string in_comment(std::string text) {
  std::replace(text.begin(), text.end(), '-', '_');
  return text;
}

std::string in_attribute(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
    out += plain ? c : '_';
  }
  return out.empty() ? "joint" : out;
}

// The parameters with their sigmas, which neither format has room for elsewhere.
std::string parameters_comment(const Model& model, const std::string& on_gain) {
  std::string text =
      "  <!-- Torques are those of an inertia of 1 kg m^2 (joint and load): multiply "
      "them by yours.\n";
  if (!on_gain.empty()) text += fmt::format("       {}.\n", in_comment(on_gain));
  for (const ModelEffect& effect : model.effects()) {
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      const effects::ParameterValue& value = effect.parameters[i];
      text += fmt::format("       {}.{} = {:.6g}", in_comment(effect.definition->name),
                          in_comment(effect.definition->parameters[i].name), value.value);
      if (value.sigma) text += fmt::format(" (sigma {:.2g})", *value.sigma);
      text += "\n";
    }
  }
  return text + "  -->\n";
}

// The gain of the controller (column kp of the log) that the file's stiffness is for.
double stated_gain(const ServoGains& gains) {
  return gains.values.size() == 1 ? gains.values.front() : 1;
}

// What the stiffness must be multiplied by; the fitted `gain` is for one unit of the log's kp.
std::string gain_words(const ServoGains& gains) {
  if (gains.values.size() == 1)
    return fmt::format("kp is for the controller gain of the set, {:.6g} (column kp)",
                       gains.values.front());
  if (gains.known && gains.values.empty())
    return "kp is for the controller gain of the set, which has no column kp";
  std::string values;
  for (const double value : gains.values)
    values += fmt::format("{}{:.6g}", values.empty() ? ": the set has " : ", ", value);
  return fmt::format(
      "kp is for a controller gain of 1: multiply kp by the gain that the controller runs at "
      "(column "
      "kp of the servo's log{}{})",
      values, gains.known ? "" : "; --data SET reads it");
}

double drive_limit(const TorqueModel& motor) {
  return std::min(motor.stall_rad_per_s2 * motor.max_duty, motor.limit_rad_per_s2);
}

// The largest difference of two servos on a swing and steps, rad.
double most_apart_rad(const ServoModel& a, const ServoModel& b) {
  effects::Servo one(a, 0, 0), other(b, 0, 0);
  double most = 0;
  for (int i = 0; i < 800; ++i) {
    const double t_s = 0.005 * i;
    const double command_rad =
        t_s < 2 ? 0.5 * std::sin(2 * std::numbers::pi * t_s) : (t_s < 3 ? 0.5 : -0.5);
    for (effects::Servo* servo : {&one, &other}) {
      servo->advance_to(t_s);
      servo->command(t_s, command_rad);
    }
    most = std::max(most, std::abs(one.joint_rad() - other.joint_rad()));
  }
  return most;
}

bool is_listed(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

void check_drops(const Model& model, const ExportOptions& options) {
  std::vector<std::string> names;
  for (const ModelEffect& effect : model.effects()) names.push_back(effect.definition->name);
  for (const std::string& name : options.drop) {
    if (name == "all") continue;
    const ModelEffect* effect = model.find(name);
    if (effect == nullptr)
      throw InputError(fmt::format("--drop {}: the model has no such effect{}", name,
                                   suggestion_for(name, names)));
    if (!effect->definition->has_neutral)
      throw InputError(fmt::format("--drop {}: the file is nothing without it", name));
  }
}

bool mjcf_holds(const ServoModel& servo) {
  return is_simple(servo) && !std::isfinite(servo.rad_per_s);
}

bool urdf_holds(const ServoModel& servo) {
  return is_simple(servo) && servo.tau_s == 0;
}

std::string mjcf_text(const Model& model, const ServoModel& servo, const ServoGains& gains) {
  const TorqueModel& t = servo.torque;
  std::string joint, actuator;
  if (t.present) {
    joint = fmt::format(" damping=\"{:.9g}\" frictionloss=\"{:.9g}\"",
                        t.viscous_per_s + t.back_emf_per_s, t.coulomb_rad_per_s2);
    const double limit = drive_limit(t);
    actuator = fmt::format(
        " kp=\"{:.9g}\" kv=\"{:.9g}\" forcelimited=\"true\" "
        "forcerange=\"{:.9g} {:.9g}\"",
        t.stall_rad_per_s2 * t.gain * stated_gain(gains), t.stall_rad_per_s2 * t.damping_s, -limit,
        limit);
  }
  if (servo.tau_s > 0) actuator += fmt::format(" timeconst=\"{:.9g}\"", servo.tau_s);
  return fmt::format(
      "<mujoco model=\"{0}\">\n{1}  <default>\n    <default class=\"{0}\">\n      <joint{2}/>\n"
      "      <position{3}/>\n    </default>\n  </default>\n</mujoco>\n",
      in_attribute(model.name()), parameters_comment(model, t.present ? gain_words(gains) : ""),
      joint, actuator);
}

std::string urdf_text(const Model& model, const ServoModel& servo, const ServoGains&) {
  constexpr double kUnlimited = 1e9;  // Both limits must be said.
  const TorqueModel& t = servo.torque;
  double velocity = servo.rad_per_s, effort = kUnlimited;
  std::string dynamics;
  if (t.present) {
    effort = drive_limit(t);
    if (t.back_emf_per_s > 0)
      velocity = std::min(velocity, t.stall_rad_per_s2 * t.max_duty / t.back_emf_per_s);
    dynamics = fmt::format("    <dynamics damping=\"{:.9g}\" friction=\"{:.9g}\"/>\n",
                           t.viscous_per_s + t.back_emf_per_s, t.coulomb_rad_per_s2);
  }
  return fmt::format(
      "<?xml version=\"1.0\"?>\n<robot name=\"{0}\">\n{1}  <link name=\"base\"/>\n"
      "  <link name=\"arm\"/>\n  <joint name=\"{0}\" type=\"continuous\">\n"
      "    <parent link=\"base\"/>\n    <child link=\"arm\"/>\n    <axis xyz=\"0 0 1\"/>\n{2}"
      "    <limit effort=\"{3:.9g}\" velocity=\"{4:.9g}\"/>\n  </joint>\n</robot>\n",
      in_attribute(model.name()), parameters_comment(model, ""), dynamics, effort,
      std::min(velocity, kUnlimited));
}

Exported export_servo(const Model& model, const ExchangeFormat& format,
                      const ExportOptions& options) {
  if (!effects::has_base(model, effects::Base::servo))
    throw InputError(fmt::format("{} holds a servo, expected a model with '{}'", format.name,
                                 effects::base_name(effects::Base::servo)));
  check_drops(model, options);
  Exported out;
  Model kept = model;
  std::vector<std::string> lost;
  for (const ModelEffect& effect : model.effects()) {
    const std::string& name = effect.definition->name;
    ServoModel alone;
    if (effect.definition->servo) effect.definition->servo(effect.values(), alone);
    const bool base = !effect.definition->has_neutral;
    const bool holds = base || (effect.definition->servo && format.holds_servo(alone));
    if (holds && !is_listed(options.drop, name)) continue;
    if (!is_listed(options.drop, name) && !is_listed(options.drop, "all"))
      throw InputError(
          fmt::format("{} cannot hold effect '{}': export with --drop {} to leave it out and see "
                      "what that costs, or --drop all",
                      format.name, name, name));
    lost.push_back(name);
  }
  for (const std::string& name : lost) {
    Model without = model;
    without.remove(name);
    out.notes.push_back(fmt::format(
        "without {}: up to {:.3g} mrad on a swing of 0.5 rad at 1 Hz and steps of 1 rad", name,
        1e3 * most_apart_rad(servo_of(model), servo_of(without))));
    kept.remove(name);
  }
  const ServoModel servo = effects::servo_of(kept);
  if (servo.torque.present) {
    out.notes.push_back(
        "torques are those of an inertia of 1 kg m^2: multiply them by that of joint "
        "and load");
    if (servo.torque.back_emf_per_s > 0)
      out.notes.push_back(
          "what the motor takes from its supply stands with the joint's damping, "
          "which acts with the torque off, too");
    if (std::isfinite(servo.torque.limit_rad_per_s2))
      out.notes.push_back("the limit of torque stands with that of the motor");
    out.notes.push_back(
        format.holds_gain
            ? gain_words(options.gains)
            : fmt::format("{} has no controller: the gain of {:.6g} for each unit of kp is in the "
                          "comment",
                          format.name, servo.torque.gain));
  }
  out.text = format.text_of_servo(kept, servo, options.gains);
  return out;
}

}  // namespace seam::app
