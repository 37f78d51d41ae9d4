#include "effects/proof/proof.h"

#include <algorithm>
#include <cmath>

#include "effects/catalogue_help.h"
#include "effects/proof/inertial_outcome.h"
#include "effects/proof/sensor_outcome.h"
#include "effects/questions.h"
#include "effects/registry.h"
#include "effects/stages/detector.h"
#include "effects/stages/geometry.h"
#include "effects/stages/inertial/inertial.h"
#include "effects/stages/joint_track.h"
#include "effects/stages/noise.h"
#include "effects/stages/optics.h"
#include "effects/stages/sensor/sensor.h"
#include "effects/stages/servo.h"
#include "effects/stages/target.h"
#include "effects/stages/timing.h"
#include "effects/stages/walk/locomotion.h"
#include "sim_core/base/error.h"

namespace seam::effects {
namespace {

constexpr int kWidth_px = 178, kHeight_px = 144;

std::vector<double> series_of(const Quantities& list, const std::string& name) {
  std::vector<double> series;
  for (const Quantity& quantity : list) {
    if (quantity.name == name) series.push_back(quantity.value);
  }
  return series;
}

void add_effect(Model& model, const std::shared_ptr<const EffectDefinition>& effect,
                const std::vector<double>& numbers) {
  std::vector<ParameterValue> values;
  for (const double value : numbers) values.push_back({.value = value});
  model.set(effect, std::move(values));
}

// The bases that the effect needs beside it.
Model model_around(const std::shared_ptr<const EffectDefinition>& effect) {
  Model model;
  for (const auto& [base, numbers] :
       {std::pair(Base::projection, std::vector<double>{160, 162, 88.5, 71.5}),
        std::pair(Base::response, std::vector<double>{200, 8})}) {
    if (effect->base != base) add_effect(model, find_effect(base_name(base)), numbers);
  }
  const auto& needs = effect->needs;
  if (effect->base != Base::wheels &&
      std::find(needs.begin(), needs.end(), Need::wheels) != needs.end())
    add_effect(model, find_effect(base_name(Base::wheels)), {0.001, 0.2});
  if (effect->needs_base == Base::motor)
    add_effect(model, find_effect(base_name(Base::motor)), {200, 10, 0.5, 0, 1});
  return model;
}

Quantities timing_outcome(const Model& model, const Quantities& given) {
  const Timing timing = timing_of(model);
  const double stamp_s = value_of(given, "stamp_s"), row = value_of(given, "row");
  const double taken_s = timing.in_lock(stamp_s, value_of(given, "cycle_s")) +
                         timing.per_exposure * value_of(given, "frame_exposure_s");
  const double start_s = taken_s + timing.row_start_after_stamp_s(row, stamp_s);
  constexpr uint64_t kFrames = 20000;
  double square = 0;
  for (uint64_t frame = 0; frame < kFrames; ++frame) {
    const double own_s = timing.own_latency_s(RandomStream{.seed = 1}, frame);
    square += own_s * own_s / kFrames;
  }
  return {{"start_s", start_s},
          {"middle_s", taken_s + timing.row_middle_after_stamp_s(row, stamp_s)},
          {"end_s", start_s + timing.exposure_s},
          {"own_latency_rms_s", std::sqrt(square)}};
}

double covariance_of(const std::vector<Wander>& wanders, double lag_s) {
  double sum = 0;
  for (const Wander& wander : wanders) sum += wander.covariance(lag_s);
  return sum;
}

Quantities joint_outcome(const Model& model, const Quantities& given) {
  Quantities out;
  const std::pair<std::string, JointRole> roles[] = {
      {"tilt", JointRole::tilt}, {"pan", JointRole::pan}, {"roll", JointRole::roll}};
  JointTrack track;
  for (const auto& [name, role] : roles) {
    const std::vector<double> logged = series_of(given, "logged_" + name + "_rad");
    if (!logged.empty()) track.joints.push_back({.name = name, .role = role, .q_rad = logged});
  }
  apply_encoder_effects(model, track);
  for (const JointSeries& joint : track.joints)
    out.push_back({joint.name + "_rad", joint.q_rad.back()});
  out.push_back({"rounding_sigma_rad", track.quantisation_step_rad / std::sqrt(12.0)});
  for (const auto& [name, role] : roles) {
    const std::vector<double> actual = series_of(given, "true_" + name + "_rad");
    if (actual.empty()) continue;
    double logged = actual.back();
    for (const ModelEffect& effect : model.effects()) {
      if (effect.definition->logged)
        logged = effect.definition->logged(effect.values(), role, logged);
    }
    out.push_back({"logged_" + name + "_rad", logged});
  }
  const std::vector<double> times = series_of(given, "command_s"),
                            commands = series_of(given, "command_rad");
  ServoModel moving = servo_of(model);
  moving.rad_per_s = std::min(moving.rad_per_s, value_of(given, "limit_radps", INFINITY));
  Servo servo(std::move(moving), 0, value_of(given, "start_rad"));
  for (size_t i = 0; i < commands.size(); ++i) servo.command(times.at(i), commands[i]);
  servo.set_warmer(value_of(given, "warmer_k"));
  servo.advance_to(value_of(given, "at_s"));
  out.push_back({"joint_rad", servo.joint_rad()});
  const EffortReading& effort = servo.model().effort;
  const double inertia_kg_m2 = value_of(given, "inertia_kg_m2", effort.inertia_kg_m2);
  out.push_back({"effort_nm", effort.of_torque(inertia_kg_m2 * servo.drive_rad_per_s2())});
  out.push_back(
      {"joint_covariance_rad2", covariance_of(noise_of(model).joint, value_of(given, "lag_s"))});
  out.push_back({"command_sigma_s", noise_of(model).command_sigma_s});
  return out;
}

Quantities image_outcome(const Model& model, const Quantities& given) {
  const Vec3 p_C(value_of(given, "x_m"), value_of(given, "y_m"), value_of(given, "z_m"));
  const Vec3 p_L = mount_of(model) * p_C;
  const FurtherColumns further{{"temperature_c"}, {{value_of(given, "temperature_c", kFocalAt_c)}}};
  const ImagePoint point =
      Projection(model, kWidth_px, kHeight_px, Reaches::detector)
          .project(p_C, value_of(given, "t_s"), 0, static_cast<int>(value_of(given, "channel", 1)),
                   {further, 0});
  const Few scatter = noise_of(model).point_scatter;
  return {{"link_x_m", p_L.x},
          {"link_y_m", p_L.y},
          {"link_z_m", p_L.z},
          {"u_px", point.u},
          {"v_px", point.v},
          {"u_focus_sigma_px", target_of(model).focus_sigma * std::abs(point.u - point.cx)},
          {"v_focus_sigma_px", target_of(model).focus_sigma * std::abs(point.v - point.cy)},
          {"scatter_variance_px2", scatter.fraction * scatter.size * scatter.size}};
}

Quantities light_outcome(const Model& model, const Quantities& given) {
  const Optics optics = optics_of(model);
  double gain = 1;
  for (const Stage stage : {Stage::radiometry, Stage::light}) {
    gain *= GainField(model, stage, kWidth_px, kHeight_px)
                .at(value_of(given, "u_px"), value_of(given, "v_px"));
  }
  const double light = value_of(given, "light"), mean = value_of(given, "mean_light");
  const double sigmas = value_of(given, "edge_px") / std::max(optics.blur_sigma_px, 1e-9);
  return {
      {"gain", gain},
      {"lamp", lamp_brightness(model, {.start_s = value_of(given, "start_s"),
                                       .exposure_s = value_of(given, "exposure_s")})},
      {"seen_light", (1 - optics.glare_fraction) * light + optics.glare_fraction * mean},
      {"own_light",
       OwnLight(model, kWidth_px, kHeight_px).at(value_of(given, "u_px"), value_of(given, "v_px"))},
      {"lamp_sigma", sensor_of(model).lamp_sigma},
      {"edge_light", 0.5 * std::erfc(-sigmas / std::sqrt(2.0))}};
}

Quantities detector_outcome(const Model& model, const Quantities& given) {
  Detection seen{.range_m = value_of(given, "range_m"),
                 .bearing_rad = value_of(given, "bearing_rad"),
                 .above_m = value_of(given, "above_m"),
                 .x_m = value_of(given, "x_m"),
                 .y_m = value_of(given, "y_m")};
  apply_detector(model, seen);
  const Noise noise = noise_of(model);
  const double lag_s = value_of(given, "lag_s");
  return {{"range_m", seen.range_m},
          {"bearing_rad", seen.bearing_rad},
          {"range_sigma_m", std::sqrt(seen.range_variance)},
          {"bearing_sigma_rad", std::sqrt(seen.bearing_variance)},
          {"place_sigma_m", std::sqrt(noise.place_variance)},
          {"delay_sigma_m", std::sqrt(noise.delay_variance)},
          {"range_covariance_m2", covariance_of(noise.range, lag_s) + noise.range_bias_variance},
          {"bearing_covariance_rad2",
           covariance_of(noise.bearing, lag_s) + noise.bearing_bias_variance},
          {"heading_covariance_rad2", covariance_of(noise.heading, lag_s)},
          {"tail_mean_m", noise.range_tail.fraction * noise.range_tail.size},
          {"tail_variance_m2", noise.range_tail.fraction * (2 - noise.range_tail.fraction) *
                                   noise.range_tail.size * noise.range_tail.size}};
}

// A way by legs, and the last command.
struct Way {
  struct Leg {
    BodyVelocity velocity;
    double for_s = 0;
  };
  std::vector<Leg> legs;
  BodyVelocity command;
};

Way way_of(const Locomotion& walk, const Quantities& given) {
  Way way;
  BodyVelocity& command = way.command;
  double left = 0, right = 0;
  bool counts = false;
  std::vector<double> left_ticks = {0}, right_ticks = {0}, time_s = {0};
  for (const Quantity& quantity : given) {
    if (quantity.name == "left_ticks") left = quantity.value;
    if (quantity.name == "right_ticks") right = quantity.value;
    if (quantity.name == "vx_mps") command.vx_mps = quantity.value;
    if (quantity.name == "vy_mps") command.vy_mps = quantity.value;
    if (quantity.name == "omega_radps") command.omega_radps = quantity.value;
    if (quantity.name != "for_s") continue;
    left_ticks.push_back(left), right_ticks.push_back(right);
    time_s.push_back(time_s.back() + quantity.value);
    counts = counts || left != 0 || right != 0;
    way.legs.push_back({command, quantity.value});
  }
  if (!counts) return way;
  right_ticks = read_in_time(right_ticks, time_s, walk.tracker.right_late_s);
  for (size_t i = 0; i < way.legs.size(); ++i) {
    Way::Leg& leg = way.legs[i];
    leg.velocity = walk.wheels.velocity_of_ticks(left_ticks[i + 1], right_ticks[i + 1], leg.for_s);
  }
  return way;
}

Quantities walk_outcome(const Model& model, const Quantities& given) {
  const Locomotion walk = locomotion_of(model);
  WalkState state;
  const auto [legs, command] = way_of(walk, given);
  for (const Way::Leg& leg : legs) advance_walk(walk, leg.velocity, leg.for_s, state);
  const double root = std::sqrt(state.path_m);
  double xy2 = 0, theta2 = 0;
  for (const MovingNoise& pose : noise_of(model).pose) {
    const double growth =
        pose.growth(std::hypot(command.vx_mps, command.vy_mps), command.omega_radps);
    xy2 += growth * growth * pose.xy_sigma_m * pose.xy_sigma_m;
    theta2 += growth * growth * pose.theta_sigma_rad * pose.theta_sigma_rad;
  }
  const Place seen = walk.tracker.seen(state);
  return {{"x_m", seen.x_m},
          {"y_m", seen.y_m},
          {"theta_rad", seen.theta_rad},
          {"xy_sigma_m", walk.xy_sigma * root},
          {"theta_sigma_rad", walk.theta_sigma * root},
          {"pose_xy_sigma_m", std::sqrt(xy2)},
          {"pose_theta_sigma_rad", std::sqrt(theta2)}};
}

// A board that reaches half_m from its middle on each side.
Quantities target_outcome(const Model& model, const Quantities& given) {
  const TargetShape shape = target_of(model);
  const double half_m = value_of(given, "half_m", 1);
  const Vec3 p_B(value_of(given, "x_m"), value_of(given, "y_m"), value_of(given, "z_m"));
  const Vec3 placed_B =
      shape.placed(p_B, p_B.x / half_m, p_B.y / half_m, value_of(given, "flex_m")) +
      swayed_by(p_B, {value_of(given, "shift_x_m"), 0, 0}, {0, 0, value_of(given, "turn_z_rad")});
  return {{"x_m", placed_B.x},
          {"y_m", placed_B.y},
          {"z_m", placed_B.z},
          {"scatter_m", shape.scatter_sigma_m},
          {"flex_sigma_m", shape.flex_sigma_m},
          {"motion_sigma_rad", shape.motion_sigma_rad},
          {"sway_shift_sigma_m", shape.sway_shift_sigma_m},
          {"sway_turn_sigma_rad", shape.sway_turn_sigma_rad}};
}

Quantities outcome(Stage stage, const Model& model, const Quantities& given) {
  if (stage == kInertial) return inertial_outcome(model, given);
  switch (stage) {
    case Stage::timing:
      return timing_outcome(model, given);
    case Stage::joint:
      return joint_outcome(model, given);
    case Stage::mount:
    case Stage::geometry:
    case Stage::corner_detector:
      return image_outcome(model, given);
    case Stage::radiometry:
    case Stage::light:
      return light_outcome(model, given);
    case Stage::sensor:
      return sensor_outcome(model, given);
    case Stage::detector:
      return detector_outcome(model, given);
    case Stage::locomotion:
      return walk_outcome(model, given);
    case Stage::target:
      return target_outcome(model, given);
    case Stage::scenario:
      break;  // Of whole runs: nothing to work out by itself.
  }
  return {};
}

// What the model gives for the quantities that the example expects.
Quantities expected_of(const EffectDefinition& effect, const Model& model, const Proof& proof) {
  const Quantities all = outcome(effect.stage, model, proof.given);
  Quantities found;
  for (const Quantity& expected : proof.expected) {
    const auto same = [&](const Quantity& quantity) { return quantity.name == expected.name; };
    const auto place = std::find_if(all.begin(), all.end(), same);
    if (place == all.end()) {
      throw InputError(fmt::format("effect '{}': stage {} has no quantity '{}' to expect",
                                   effect.name, to_string(effect.stage), expected.name));
    }
    found.push_back(*place);
  }
  return found;
}

// The first quantity that the effect at its neutral values changes, in words; empty: none, or the
// effect is a base, which has no neutral values.
std::string not_absent(const std::shared_ptr<const EffectDefinition>& effect) {
  if (!effect->has_neutral || effect->base != Base::none) return "";
  const Model without = model_around(effect);
  Model with = without;
  with.add_neutral(effect);
  for (const Proof& proof : effect->proof) {
    const Quantities before = expected_of(*effect, without, proof),
                     after = expected_of(*effect, with, proof);
    for (size_t i = 0; i < before.size(); ++i) {
      if (before[i].value == after[i].value) continue;
      return fmt::format(
          "not absent at its neutral values: {} is {:.17g}, without the effect {:.17g}",
          after[i].name, after[i].value, before[i].value);
    }
  }
  return "";
}

}  // namespace

std::vector<Quantity> worked(const std::shared_ptr<const EffectDefinition>& effect,
                             const Proof& proof) {
  Model model = model_around(effect);
  add_effect(model, effect, proof.values);
  return expected_of(*effect, model, proof);
}

std::string failed_proof(const std::shared_ptr<const EffectDefinition>& effect) {
  for (const Proof& proof : effect->proof) {
    const std::vector<Quantity> found = worked(effect, proof);
    for (size_t i = 0; i < found.size(); ++i) {
      const double expected = proof.expected[i].value;
      const double apart = std::abs(found[i].value - expected);
      if (apart <= proof.tolerance * std::max(std::abs(expected), 1e-3)) continue;
      return fmt::format("{}: found {} {:.17g}", proof_text(*effect, proof), found[i].name,
                         found[i].value);
    }
  }
  return "";
}

std::vector<std::string> open_proofs(const std::shared_ptr<const EffectDefinition>& effect) {
  std::vector<std::string> open;
  if (effect->proof.size() < 2) {
    open.push_back(fmt::format("{} worked examples, expected two or more with other values",
                               effect->proof.size()));
  }
  if (const std::string failed = failed_proof(effect); !failed.empty()) open.push_back(failed);
  for (size_t i = 0; i < effect->parameters.size(); ++i) {
    const Parameter& parameter = effect->parameters[i];
    // A number that says how a thing is computed need not be noticed.
    if (parameter.integer && effect->parameters.size() > 1) continue;
    auto other = std::make_shared<EffectDefinition>(*effect);
    for (Proof& proof : other->proof)
      proof.values.at(i) += parameter.integer ? 1 : 0.1 * parameter.scale;
    if (failed_proof(other).empty())
      open.push_back(fmt::format("no worked example notices another {}", parameter.name));
  }
  if (const std::string found = not_absent(effect); !found.empty()) open.push_back(found);
  return open;
}

}  // namespace seam::effects
