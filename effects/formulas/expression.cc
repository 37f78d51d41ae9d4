// Expression effects: formulas over a stage's variables with named parameters, written in a
// model's YAML. Variables and outputs by stage: docs/reference/models.md, "Formulas".
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "effects/formulas/formula.h"
#include "effects/formulas/formula_parameter.h"
#include "effects/formulas/formula_stages.h"
#include "effects/formulas/scenario_effect.h"
#include "effects/model.h"
#include "effects/registry.h"
#include "effects/stages/detector.h"
#include "effects/stages/geometry.h"
#include "effects/stages/joint_track.h"
#include "effects/stages/sensor/sensor.h"
#include "effects/stages/servo.h"
#include "effects/stages/target.h"
#include "effects/stages/walk/locomotion.h"
#include "sim_core/base/error.h"

namespace seam::effects {
namespace {

struct StageVariables {
  Stage stage;
  std::vector<std::string> variables;
  // Each is a variable too, but for gain, which multiplies, and torque, which adds.
  std::vector<std::string> outputs;
  unsigned kinds;
  bool reads_columns = false;  // Of the row that it acts on.

  bool has(const std::string& output) const {
    return std::find(outputs.begin(), outputs.end(), output) != outputs.end();
  }
};

constexpr const char *kTorque = "torque", *kGain = "gain";

const std::vector<StageVariables>& stages() {
  static const std::vector<std::string> of_image = {"x",  "y",  "r2", "u", "v",  "cx",
                                                    "cy", "fx", "fy", "t", "row"};
  static const std::vector<StageVariables> all = {
      {Stage::joint,
       {"q", "rate", "command", "t"},
       {"q"},
       kJoints | kPoints | kFrames | kRanges,
       true},
      {Stage::joint, {"q", "rate", "command", "t", "drive"}, {kTorque}, kJoints | kRanges},
      {Stage::geometry, of_image, {"u", "v"}, kPoints | kFrames | kRanges, true},
      {Stage::corner_detector, of_image, {"u", "v"}, kPoints, true},
      {Stage::target, {"x", "y", "z"}, {"x", "y", "z"}, kPoints},
      {Stage::radiometry, {"u", "v", "rho", "t"}, {kGain}, kPhotometry | kFrames | kRanges},
      {Stage::light, {"u", "v", "rho", "t"}, {kGain}, kPhotometry | kFrames | kRanges},
      {Stage::sensor, {"mean", "t"}, {"mean"}, kPhotometry | kFrames | kRanges},
      {Stage::detector,
       {"range", "bearing", "speed", "turn", "t"},
       {"range", "bearing"},
       kLandmarks | kRanges,
       true},
      {Stage::locomotion,
       {"vx", "vy", "omega", "x", "y", "theta", "way", "t"},
       {"vx", "vy", "omega"},
       kOdometry | kRanges,
       true},
  };
  return all;
}

// What the formulas of an effect may be about: of two ways to act at a stage the one whose output
// is given.
const StageVariables& stage_of(const ConfigNode& effect) {
  std::vector<std::string> names;
  for (const StageVariables& s : stages()) {
    const std::string name = to_string(s.stage);
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  names.push_back(to_string(Stage::scenario));  // For the list in an error's message.
  const std::string& name = names[effect.at("stage").choice(names)];
  const StageVariables* found = nullptr;
  for (const StageVariables& s : stages()) {
    if (to_string(s.stage) != name) continue;
    const bool given = std::any_of(s.outputs.begin(), s.outputs.end(),
                                   [&](const std::string& output) { return effect.has(output); });
    if (found != nullptr && given && effect.has(found->outputs.front()))
      effect.fail(fmt::format("{} and {} act at different places, expected two effects",
                              found->outputs.front(), s.outputs.front()));
    if (found == nullptr || given) found = &s;
  }
  return *found;
}

// No stage maps more than three quantities.
using Outputs = std::array<double, 3>;

// The compiled formulas of one effect: variables of the stage, then extra columns, then parameters.
struct Program {
  std::vector<Formula> formulas;
  std::vector<int> output;      // By formula: which of the stage's outputs it gives.
  std::vector<double> neutral;  // Of the parameters: there the effect does nothing, bit for bit.
  std::vector<std::string> columns;

  bool absent(Values p) const {
    return std::equal(p.begin(), p.end(), neutral.begin(), neutral.end());
  }

  // Runs every formula on the same inputs, then hands out the results.
  void run(std::span<const double> variables, Values p, Outputs& outputs) const {
    if (absent(p)) return;
    std::array<double, kMostInputs> inputs;
    const size_t count = variables.size() + p.size();
    std::copy(variables.begin(), variables.end(), inputs.begin());
    std::copy(p.begin(), p.end(), inputs.begin() + static_cast<std::ptrdiff_t>(variables.size()));
    for (size_t i = 0; i < formulas.size(); ++i)
      outputs[output[i]] = formulas[i]({inputs.data(), count});
  }
  void run(std::span<const double> variables, const RowColumns& row, Values p,
           Outputs& outputs) const {
    if (columns.empty()) return run(variables, p, outputs);
    std::array<double, kMostInputs> both;
    auto end = std::copy(variables.begin(), variables.end(), both.begin());
    for (const std::string& column : columns) *end++ = row.value(column);
    run({both.data(), variables.size() + columns.size()}, p, outputs);
  }
};

void set_map_of_sensor(EffectDefinition& effect, const std::shared_ptr<const Program>& program) {
  effect.sensor = [program, name = effect.name](Values p, SensorChain& chain) {
    if (program->absent(p)) return;
    chain.maps.push_back({name, [program, values = std::vector<double>(p.begin(), p.end())](
                                    double mean_dn, double t_s) {
                            Outputs out = {mean_dn};
                            program->run(std::array{mean_dn, t_s}, values, out);
                            return out[0];
                          }});
  };
}

void set_push(EffectDefinition& effect, const std::shared_ptr<const Program>& program) {
  effect.needs_base = Base::motor;
  effect.servo = [program](Values p, ServoModel& servo) {
    if (program->absent(p)) return;
    servo.pushes.push_back([program, values = std::vector<double>(p.begin(), p.end())](
                               const PushedMotor& at) {
      Outputs out = {0};
      program->run(std::array{at.q_rad, at.w_radps, at.command_rad, at.t_s, at.drive_rad_per_s2},
                   values, out);
      return out[0];
    });
  };
}

// Hooks of one stage that run the program.
void set_hook(EffectDefinition& effect, const StageVariables& stage,
              const std::shared_ptr<const Program>& program) {
  switch (effect.stage) {
    case Stage::geometry:
    case Stage::corner_detector:
      (effect.stage == Stage::geometry ? effect.image_map : effect.corner_detector) =
          [program](Values p, ImagePoint& at) {
            Outputs out = {at.u, at.v};
            const double r2 = at.x * at.x + at.y * at.y;
            program->run(
                std::array{at.x, at.y, r2, at.u, at.v, at.cx, at.cy, at.fx, at.fy, at.t_s, at.row},
                at.columns, p, out);
            at.u = out[0], at.v = out[1];
          };
      break;
    case Stage::joint:
      if (stage.has(kTorque))
        set_push(effect, program);
      else
        effect.joint_map = [program](Values p, const JointSample& at) {
          Outputs out = {at.q_rad};
          program->run(std::array{at.q_rad, at.rate_rad_per_s, at.command_rad, at.t_s}, at.columns,
                       p, out);
          return out[0];
        };
      break;
    case Stage::target:
      effect.target = [program](Values p, TargetShape& shape) {
        if (program->absent(p)) return;
        shape.maps.push_back([program, values = std::vector<double>(p.begin(), p.end())](Vec3& at) {
          Outputs out = {at.x, at.y, at.z};
          program->run(std::array{at.x, at.y, at.z}, values, out);
          at = {out[0], out[1], out[2]};
        });
      };
      break;
    case Stage::radiometry:
    case Stage::light:
      effect.gain = [program](Values p, const ImagePoint& at) {
        Outputs out = {1};
        program->run(std::array{at.u, at.v, rho(at.u, at.v, at.width_px, at.height_px), at.t_s}, p,
                     out);
        return out[0];
      };
      break;
    case Stage::sensor:
      set_map_of_sensor(effect, program);
      break;
    case Stage::detector:
      effect.detector = [program](Values p, Detection& at) {
        Outputs out = {at.range_m, at.bearing_rad};
        program->run(std::array{at.range_m, at.bearing_rad, at.speed_mps, at.turn_radps, at.t_s},
                     at.columns, p, out);
        at.range_m = out[0], at.bearing_rad = out[1];
      };
      break;
    case Stage::locomotion:
      effect.velocity_map = [program](Values p, VelocitySample& at) {
        Outputs out = {at.velocity.vx_mps, at.velocity.vy_mps, at.velocity.omega_radps};
        program->run(
            std::array{out[0], out[1], out[2], at.x_m, at.y_m, at.theta_rad, at.path_m, at.t_s},
            at.columns, p, out);
        at.velocity = {out[0], out[1], out[2]};
      };
      break;
    default:
      break;
  }
}

// Whether the formulas give back their variables (a gain of 1, no torque) at neutral parameters, at
// a few points: an effect that does not is a replacement, and has no neutral value.
bool is_neutral(const Program& program, const StageVariables& stage, size_t columns) {
  for (const double at : {0.3, 1.7, -0.9}) {
    std::vector<double> inputs;
    for (size_t i = 0; i < stage.variables.size() + columns; ++i)
      inputs.push_back(at + 0.37 * static_cast<double>(i));
    const std::vector<double> variables = inputs;
    inputs.insert(inputs.end(), program.neutral.begin(), program.neutral.end());
    for (size_t i = 0; i < program.formulas.size(); ++i) {
      const std::string& output = stage.outputs[program.output[i]];
      const auto place = std::find(stage.variables.begin(), stage.variables.end(), output);
      const double expected = place == stage.variables.end()
                                  ? std::stod(formula_without_change(output))
                                  : variables[place - stage.variables.begin()];
      const double value = program.formulas[i](inputs);
      if (std::isfinite(value) &&
          std::abs(value - expected) > 1e-9 * std::max(1.0, std::abs(expected)))
        return false;
    }
  }
  return true;
}

std::vector<Parameter> parameters_of(const ConfigNode& effect, const StageVariables& stage) {
  std::vector<Parameter> found;
  const auto parameters = effect.find("parameters");
  if (!parameters) return found;
  for (const std::string& key : parameter_keys(*parameters)) {
    if (std::find(stage.variables.begin(), stage.variables.end(), key) != stage.variables.end()) {
      parameters->fail(fmt::format("'{}' is a variable of the stage, expected another name", key));
    }
    found.push_back(formula_parameter(key, parameters->at(key)));
  }
  return found;
}

}  // namespace

std::vector<FormulaStage> formula_stages() {
  std::vector<FormulaStage> all;
  for (const StageVariables& stage : stages())
    all.push_back({to_string(stage.stage), stage.variables, stage.outputs, stage.kinds});
  return all;
}

std::string formula_without_change(const std::string& output) {
  return output == kTorque ? "0" : output == kGain ? "1" : output;
}

std::shared_ptr<const EffectDefinition> expression_effect(const std::string& name,
                                                          const ConfigNode& node) {
  if (find_effect(name))
    node.fail(fmt::format("'{}' is an effect of the catalogue, expected a new name", name));
  if (node.at("stage").text() == to_string(Stage::scenario)) return scenario_effect(name, node);
  const StageVariables& stage = stage_of(node);
  auto effect = std::make_shared<EffectDefinition>();
  effect->name = name;
  effect->stage = stage.stage;
  effect->kinds = stage.kinds;
  effect->help = node.text_or("help", "An effect given by a formula.");
  effect->signature = node.text_or("signature", "");
  effect->source = "    stage: " + to_string(stage.stage) + "\n";
  if (node.has("help")) effect->source += "    help: " + yaml_quoted(effect->help) + "\n";
  if (node.has("signature"))
    effect->source += "    signature: " + yaml_quoted(effect->signature) + "\n";
  auto program = std::make_shared<Program>();
  std::vector<std::string> inputs = stage.variables, parameter_names;
  effect->parameters = parameters_of(node, stage);
  for (const Parameter& parameter : effect->parameters) {
    program->neutral.push_back(parameter.neutral);
    parameter_names.push_back(parameter.name);
  }
  // What a formula names besides is a column of the set.
  std::vector<std::pair<int, std::string>> texts;
  try {
    for (size_t i = 0; i < stage.outputs.size(); ++i) {
      if (!node.has(stage.outputs[i])) continue;
      texts.emplace_back(static_cast<int>(i), node.at(stage.outputs[i]).text());
      if (!stage.reads_columns) continue;
      for (const std::string& used : Formula::names_in(texts.back().second)) {
        const auto known = [&](const std::vector<std::string>& list) {
          return std::find(list.begin(), list.end(), used) != list.end();
        };
        // What is nearly a variable's name is that one misspelt, of which Formula reports.
        const bool misspelt = !stage.has("q") && near_name(used, inputs) != nullptr;
        if (!known(inputs) && !known(parameter_names) && !misspelt)
          effect->columns.push_back(used), inputs.push_back(used);
        if (inputs.size() > kMostInputs)
          node.fail(fmt::format("more than {} variables and columns", kMostInputs));
      }
    }
    if (texts.empty())
      node.fail(fmt::format("no formula, expected one for {}", fmt::join(stage.outputs, " or ")));
    inputs.insert(inputs.end(), parameter_names.begin(), parameter_names.end());
    if (inputs.size() > kMostInputs) {
      node.fail(fmt::format("{} variables and parameters, at most {}", inputs.size(), kMostInputs));
    }
    for (const auto& [output, text] : texts) {
      program->formulas.emplace_back(text, inputs);
      program->output.push_back(output);
      effect->source += "    " + stage.outputs[output] + ": " + yaml_quoted(text) + "\n";
      effect->formula +=
          (effect->formula.empty() ? "" : ", ") + stage.outputs[output] + " = " + text;
    }
  } catch (const InputError& error) {
    const std::string what = error.what();
    if (what.starts_with(node.file())) throw;
    node.fail(what);
  }
  node.finish();
  program->columns = effect->columns;
  effect->has_neutral = is_neutral(*program, stage, effect->columns.size());
  // Nothing switches off a formula that is no identity at neutral values.
  if (!effect->has_neutral) program->neutral = {NAN};
  set_hook(*effect, stage, program);
  return effect;
}

std::vector<ParameterValue> expression_values(const EffectDefinition& definition,
                                              const ConfigNode& node) {
  std::vector<ParameterValue> values;
  for (const Parameter& parameter : definition.parameters) {
    const ConfigNode given = node.at("parameters").at(parameter.name);
    ParameterValue value{.value = parameter.neutral};
    const Range bounds{std::min(parameter.min, parameter.neutral),
                       std::max(parameter.max, parameter.neutral)};
    if (given.is_map()) {
      value.value = given.number_or("value", parameter.neutral, bounds);
      if (const auto sigma = given.find("sigma")) value.sigma = sigma->number({0, 1e300});
      value.free = given.boolean_or("free", false);
      value.spread = given.number_or("spread", 0, {0, 1e300});
    } else {
      value.value = given.number(bounds);
    }
    values.push_back(value);
  }
  return values;
}

std::string expression_source(const EffectDefinition& definition) {
  return definition.source;
}

}  // namespace seam::effects
