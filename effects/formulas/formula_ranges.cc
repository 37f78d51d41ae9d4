#include "effects/formulas/formula_ranges.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "effects/not_a_number.h"
#include "effects/stages/detector.h"
#include "effects/stages/geometry.h"
#include "effects/stages/joint_track.h"
#include "effects/stages/sensor/sensor.h"
#include "effects/stages/servo.h"
#include "effects/stages/target.h"
#include "effects/stages/walk/locomotion.h"
#include "sim_core/base/random.h"

namespace seam::effects {
namespace {

constexpr uint64_t kTries = 2000;
constexpr double kUnstatedBound = 1e6;  // Of a formula's parameter (docs/reference/models.md).

// A quantity that a formula reads, with what a robot on a field may give it.
struct Quantity {
  const char* name;
  double min, max;
};

struct Output {
  const char* name;
  double value;
};

// What the effects of one stage read, and how one of them is called there.
struct Trial {
  Stage stage;
  std::vector<Quantity> reads;
  double largest;
  std::vector<Output> (*run)(const ModelEffect&, const std::vector<double>& at);
};

constexpr Quantity kTime = {"t", 0, 3600};
// An image of the size for which most cameras of robots were made.
constexpr double kWidth_px = 208, kHeight_px = 160, kFocal_px = 200;

std::vector<Output> run_joint(const ModelEffect& effect, const std::vector<double>& at) {
  const JointSample sample{
      .q_rad = at[0], .rate_rad_per_s = at[1], .command_rad = at[2], .t_s = at[3]};
  return {{"q", effect.definition->joint_map(effect.values(), sample)}};
}

std::vector<Output> run_push(const ModelEffect& effect, const std::vector<double>& at) {
  ServoModel servo;
  effect.definition->servo(effect.values(), servo);
  if (servo.pushes.empty()) return {};
  const PushedMotor motor{.q_rad = at[0],
                          .w_radps = at[1],
                          .command_rad = at[2],
                          .t_s = at[3],
                          .drive_rad_per_s2 = at[4]};
  return {{"torque", servo.pushes.front()(motor)}};
}

ImagePoint image_point(double u, double v, double t_s) {
  ImagePoint point{.t_s = t_s,
                   .row = v,
                   .width_px = static_cast<int>(kWidth_px),
                   .height_px = static_cast<int>(kHeight_px)};
  point.fx = point.fy = kFocal_px;
  point.cx = 0.5 * (kWidth_px - 1), point.cy = 0.5 * (kHeight_px - 1);
  point.u = u, point.v = v;
  point.x = point.xd = (u - point.cx) / kFocal_px;
  point.y = point.yd = (v - point.cy) / kFocal_px;
  return point;
}

std::vector<Output> run_geometry(const ModelEffect& effect, const std::vector<double>& at) {
  ImagePoint point = image_point(at[0], at[1], at[2]);
  const EffectDefinition& definition = *effect.definition;
  (definition.image_map ? definition.image_map : definition.corner_detector)(effect.values(),
                                                                             point);
  return {{"u", point.u}, {"v", point.v}};
}

std::vector<Output> run_gain(const ModelEffect& effect, const std::vector<double>& at) {
  return {{"gain", effect.definition->gain(effect.values(), image_point(at[0], at[1], at[2]))}};
}

std::vector<Output> run_sensor(const ModelEffect& effect, const std::vector<double>& at) {
  SensorChain chain;
  effect.definition->sensor(effect.values(), chain);
  if (chain.maps.empty()) return {};
  return {{"mean", chain.maps.front()(at[0], at[1])}};
}

std::vector<Output> run_detector(const ModelEffect& effect, const std::vector<double>& at) {
  Detection seen{.range_m = at[0],
                 .bearing_rad = at[1],
                 .speed_mps = at[2],
                 .turn_radps = at[3],
                 .t_s = at[4]};
  effect.definition->detector(effect.values(), seen);
  return {{"range", seen.range_m}, {"bearing", seen.bearing_rad}};
}

std::vector<Output> run_target(const ModelEffect& effect, const std::vector<double>& at) {
  TargetShape shape;
  effect.definition->target(effect.values(), shape);
  const Vec3 p = shape.placed({at[0], at[1], at[2]}, 0, 0);
  return {{"x", p.x}, {"y", p.y}, {"z", p.z}};
}

std::vector<Output> run_locomotion(const ModelEffect& effect, const std::vector<double>& at) {
  VelocitySample sample{.velocity = {at[0], at[1], at[2]},
                        .x_m = at[3],
                        .y_m = at[4],
                        .theta_rad = at[5],
                        .path_m = at[6],
                        .t_s = at[7]};
  effect.definition->velocity_map(effect.values(), sample);
  const BodyVelocity& v = sample.velocity;
  return {{"vx", v.vx_mps}, {"vy", v.vy_mps}, {"omega", v.omega_radps}};
}

bool is_push(const ModelEffect& effect) {
  return effect.definition->stage == Stage::joint && effect.definition->servo;
}

const std::vector<Trial>& trials() {
  constexpr Quantity kU = {"u", 0, kWidth_px - 1}, kV = {"v", 0, kHeight_px - 1};
  static const std::vector<Trial> all = {
      {Stage::joint,
       {{"q", -1.6, 1.6}, {"rate", -6, 6}, {"command", -1.6, 1.6}, kTime},
       kLargestOutput,
       run_joint},
      {Stage::joint,
       {{"q", -1.6, 1.6}, {"rate", -6, 6}, {"command", -1.6, 1.6}, kTime, {"drive", -300, 300}},
       kLargestOutput,
       run_push},
      {Stage::geometry, {kU, kV, kTime}, kLargestOfImage, run_geometry},
      {Stage::corner_detector, {kU, kV, kTime}, kLargestOfImage, run_geometry},
      {Stage::target,
       {{"x", -0.5, 0.5}, {"y", -0.5, 0.5}, {"z", -0.5, 0.5}},
       kLargestOutput,
       run_target},
      {Stage::radiometry, {kU, kV, kTime}, kLargestOfImage, run_gain},
      {Stage::light, {kU, kV, kTime}, kLargestOfImage, run_gain},
      {Stage::sensor, {{"mean", 0, 255}, kTime}, kLargestOfImage, run_sensor},
      {Stage::detector,
       {{"range", 0.05, 10}, {"bearing", -1.6, 1.6}, {"speed", -0.5, 0.5}, {"turn", -3, 3}, kTime},
       kLargestOutput,
       run_detector},
      {Stage::locomotion,
       {{"vx", -0.5, 0.5},
        {"vy", -0.5, 0.5},
        {"omega", -3, 3},
        {"x", -5, 5},
        {"y", -5, 5},
        {"theta", -3.2, 3.2},
        {"way", 0, 100},
        kTime},
       kLargestOutput,
       run_locomotion},
  };
  return all;
}

// The first tries are the corners and the middle, where most poles and edges are; then points drawn
// at random.
std::vector<double> point_of(const std::vector<Quantity>& reads, uint64_t number) {
  const RandomStream stream = RandomStream{.seed = 1}.child("formula_ranges");
  const uint64_t corners = uint64_t{1} << reads.size();
  std::vector<double> at;
  for (size_t i = 0; i < reads.size(); ++i) {
    const Quantity& q = reads[i];
    double part = uniform(stream, number * reads.size() + i);
    if (number == 0) part = q.min < 0 ? -q.min / (q.max - q.min) : 0;
    if (number > 0 && number <= corners) part = ((number - 1) >> i) & 1 ? 1 : 0;
    at.push_back(q.min + part * (q.max - q.min));
  }
  return at;
}

std::optional<std::string> trouble_of(const ModelEffect& effect, const Trial& trial,
                                      double largest) {
  for (uint64_t number = 0; number < kTries; ++number) {
    const std::vector<double> at = point_of(trial.reads, number);
    for (const Output& out : trial.run(effect, at)) {
      if (usable(out.value, largest)) continue;
      std::vector<std::string> places;
      for (size_t i = 0; i < at.size(); ++i)
        places.push_back(fmt::format("{} = {:.4g}", trial.reads[i].name, at[i]));
      for (size_t i = 0; i < effect.parameters.size(); ++i)
        places.push_back(fmt::format("{} = {:.4g}", effect.definition->parameters[i].name,
                                     effect.parameters[i].value));
      return fmt::format(
          "effects.{}: the formula gives {} = {} at {}, expected a number that "
          "can be used",
          effect.definition->name, out.name, number_shown(out.value), fmt::join(places, ", "));
    }
  }
  return std::nullopt;
}

// The same effect with each parameter alone at a bound that its author gave. What is merely too
// large there is left to whoever goes there.
std::optional<std::string> trouble_at_bounds(const ModelEffect& effect, const Trial& trial) {
  for (size_t i = 0; i < effect.parameters.size(); ++i) {
    const Parameter& parameter = effect.definition->parameters[i];
    for (const double value : {parameter.min, parameter.max}) {
      if (std::abs(value) == kUnstatedBound) continue;
      ModelEffect other = effect;
      other.set(i, {.value = value});
      if (const auto trouble = trouble_of(other, trial, 1e300)) return trouble;
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<FormulaTrouble> troubles_of_formulas(const Model& model) {
  std::vector<FormulaTrouble> all;
  for (const ModelEffect& effect : model.effects()) {
    if (effect.definition->source.empty()) continue;  // No formula.
    const auto trial = std::find_if(trials().begin(), trials().end(), [&](const Trial& t) {
      return t.stage == effect.definition->stage && (t.run == run_push) == is_push(effect);
    });
    if (trial == trials().end()) continue;
    // Further columns of a log are 0 here, which a log's own numbers may not be.
    const bool certain = effect.definition->columns.empty();
    if (const auto trouble = trouble_of(effect, *trial, trial->largest))
      all.push_back({*trouble, certain});
    else if (const auto possible = trouble_at_bounds(effect, *trial))
      all.push_back({*possible, false});
  }
  return all;
}

}  // namespace seam::effects
