#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "effects/formulas/formula.h"
#include "effects/model.h"
#include "effects/stages/detector.h"
#include "effects/stages/geometry.h"
#include "effects/stages/joint_track.h"
#include "effects/stages/servo.h"
#include "effects/stages/target.h"
#include "effects/stages/walk/locomotion.h"
#include "sim_core/base/config.h"
#include "sim_core/base/error.h"

namespace seam::effects {
namespace {

Model model_of(const std::string& effects) {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects:\n" + effects, "test.yaml"));
}

double value_of(const std::string& text) {
  return Formula(text, {"x"})(std::array{2.0});
}

TEST(Formula, ArithmeticIsThatOfMathematics) {
  EXPECT_EQ(value_of("1 + 2 * 3 ^ 2 - 4 / 2"), 17);
  EXPECT_EQ(value_of("2 ^ 3 ^ 2"), 512);
  EXPECT_EQ(value_of("-x ^ 2"), -4);
  EXPECT_EQ(value_of("(1 - x) * -3"), 3);
  EXPECT_EQ(value_of("x > 1 && x <= 2 ? 5 : 6"), 5);
  EXPECT_EQ(value_of("if(x < 0, 1, max(x, 7)) + sign(-x) + abs(-1) + floor(1.5)"), 8);
  EXPECT_NEAR(
      value_of("sin(pi / 6) + exp(log(x)) + sqrt(x + 2) + atan2(1, 1) + tanh(0.5) + pow(x, 0.5)"),
      0.5 + 2 + 2 + std::atan(1.0) + std::tanh(0.5) + std::sqrt(2.0), 1e-14);
}

TEST(Formula, ErrorsNameWhatIsWrong) {
  for (const char* text : {"", "1 +", "sin(", "y + 1", "foo(x)", "x = 3", "\"a\"", "1 2"}) {
    EXPECT_ANY_THROW(Formula(text, {"x"})) << text;
  }
}

std::string error_of_model(const std::string& effects) {
  try {
    model_of(effects);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Formula, ACommaIsNoDecimalPoint) {
  EXPECT_THAT(error_of_model("  e: {stage: geometry, u: 'u + k * 0,5', parameters: {k: 0}}"),
              testing::HasSubstr("found 2 formulas with commas between, expected one"));
  EXPECT_EQ(Formula("max(x, 2) + min(1, x)", {"x"})(std::array{3.0}), 4);
}

TEST(Formula, ControlCharactersAndEndlessTextsAreRefused) {
  EXPECT_THROW(Formula(std::string("x\0+1", 4), {"x"}), InputError);
  EXPECT_THROW(Formula("x + \x1b 1", {"x"}), InputError);
  EXPECT_EQ(Formula("x +\n\t1", {"x"})(std::array{2.0}), 3);
  std::string sum = "x";
  for (int i = 0; i < 10'000; ++i) sum += "+x";
  EXPECT_THROW(Formula(sum, {"x"}), InputError);
}

// An evaluation takes as long as it has parts, and a fit makes millions of them.
TEST(Formula, AFormulaOfMoreThanAThousandPartsIsRefused) {
  const auto sum_of = [](int powers) {
    std::string sum = "x";
    for (int i = 1; i < powers; ++i) sum += " + (x ^ 1e-3)";
    return sum;
  };
  EXPECT_EQ(Formula(sum_of(250), {"x"})(std::array{1.0}), 250);  // 1 + 4 * 249 parts.
  EXPECT_THAT(error_of_model("  e: {stage: joint, q: 'q + " + std::string(1000, '-') + "q'}\n"),
              testing::HasSubstr("formula of 1003 numbers, names and operators, expected 1000"));
  EXPECT_THROW(Formula(sum_of(251), {"x"}), InputError);
  EXPECT_THROW(Formula("x" + std::string(500, ' ') + sum_of(251), {"x"}), InputError);
}

TEST(Expression, WordsThatFormulasDoNotHaveAreExplained) {
  const auto error_of = [](const std::string& u, const std::string& parameter) {
    return error_of_model("  e: {stage: geometry, u: '" + u + "', parameters: {" + parameter +
                          ": 0}}");
  };
  EXPECT_THAT(error_of("u + pi", "pi"),
              testing::HasSubstr("a name that formulas have already (pi,"));
  EXPECT_THAT(error_of("u > 0 and v > 0", "k"), testing::HasSubstr("write && for 'and'"));
  EXPECT_THAT(error_of(" ", "k"), testing::HasSubstr("the formula is empty"));
  const std::string error = error_of(std::string(900, '-') + "q", "k");
  EXPECT_LT(error.size(), 400u);
}

// Each of these took a minute, or did not end.
TEST(Expression, ManyFormulasAndParametersAreCountedFirst) {
  std::string formulas, parameters, settings;
  for (int i = 0; i < 300; ++i) {
    formulas += fmt::format("  e{}: {{stage: geometry, u: u, parameters: {{k: 0}}}}\n", i);
    settings += fmt::format("{}p{}: k", i > 0 ? ", " : "", i);
  }
  for (int i = 0; i < 100; ++i) parameters += fmt::format("{}k{}: 0", i > 0 ? ", " : "", i);
  EXPECT_EQ(error_of_model(formulas),
            "test.yaml:3: effects: found 300 formulas, expected 200 at most");
  EXPECT_EQ(error_of_model("  e: {stage: scenario, parameters: {k: 0}, set: {" + settings + "}}"),
            "test.yaml:3: effects: found 300 formulas, expected 200 at most");
  for (const char* rest : {"stage: geometry, u: u", "stage: scenario, set: {seed: k1}"}) {
    EXPECT_EQ(error_of_model(fmt::format("  e: {{{}, parameters: {{{}}}}}", rest, parameters)),
              "test.yaml:3: effects.e.parameters: found 100 parameters, expected 64 at most");
  }
  std::string effects;
  for (int i = 0; i < 1001; ++i) effects += fmt::format("  e{}: {{}}\n", i);
  EXPECT_EQ(error_of_model(effects),
            "test.yaml:3: effects: found 1001 effects, expected 1000 at most");
  std::string columns = "q";
  for (int i = 0; i < 400; ++i) columns += fmt::format("+c{}", i);
  EXPECT_THAT(error_of_model("  e: {stage: joint, q: " + columns + "}"),
              testing::HasSubstr("more than 64 variables and columns"));
}

TEST(Expression, ActsOnTheImageAndIsAbsentAtNeutral) {
  const std::string base = "  pinhole: {fx_px: 160, fy_px: 162, cx_px: 88.5, cy_px: 71.5}\n";
  const auto with = [&](double k) {
    return model_of(base +
                    "  thermal: {stage: geometry, u: \"cx + (u - cx) * (1 + k * t)\", parameters: "
                    "{k: {value: " +
                    std::to_string(k) + ", neutral: 0, min: -0.1, max: 0.1}}}");
  };
  const Vec3 point{0.2, -0.1, 2.0};
  const auto plain = Projection(model_of(base), 178, 144).project(point, 3.0);
  const auto neutral = Projection(with(0), 178, 144).project(point, 3.0);
  const auto warm = Projection(with(0.01), 178, 144).project(point, 3.0);
  EXPECT_EQ(plain.u, neutral.u);
  EXPECT_EQ(plain.v, neutral.v);
  EXPECT_NEAR(warm.u, 88.5 + 16 * 1.03, 1e-12);
  EXPECT_TRUE(with(0).find("thermal")->definition->has_neutral);
}

TEST(Expression, FileRoundTripKeepsTheFormula) {
  const Model model = model_of(
      "  friction: {stage: joint, help: \"a test\", q: \"q + k * load_nm * sign(rate)\", "
      "parameters: {k: {value: 0.5, sigma: 0.01, neutral: 0, min: -1, max: 1}}}");
  const std::string yaml = model.to_yaml();
  const Model again = Model::from_config(ConfigNode::from_text(yaml, "again"));
  EXPECT_EQ(again.to_yaml(), yaml);
  const auto& effect = *again.find("friction");
  EXPECT_EQ(effect.definition->columns, std::vector<std::string>{"load_nm"});
  const std::vector<std::string> names = {"other", "load_nm"};
  const std::vector<std::vector<double>> values = {{9}, {2}};
  const JointSample sample{.q_rad = 1, .rate_rad_per_s = -3, .columns = {names, values, 0}};
  EXPECT_EQ(effect.definition->joint_map(effect.values(), sample), 1 - 0.5 * 2);
}

TEST(Expression, FormulasReadColumnsOfTheRowThatTheyActOn) {
  const Model model = model_of(
      "  warm: {stage: geometry, u: \"u + k * temperature_c\", parameters: {k: {value: 2}}}\n"
      "  tired: {stage: detector, range: \"range + k * volts\", parameters: {k: {value: 3}}}\n"
      "  slips: {stage: locomotion, vx: \"vx * (1 + k * load)\", parameters: {k: {value: 4}}}");
  const FurtherColumns columns{{"volts", "temperature_c", "load"}, {{1, 10}, {2, 20}, {3, 30}}};
  const auto& warm = *model.find("warm");
  ImagePoint point{.u = 5, .columns = {columns, 1}};
  warm.definition->image_map(warm.values(), point);
  EXPECT_EQ(point.u, 5 + 2 * 20);
  const auto& tired = *model.find("tired");
  Detection seen{.range_m = 5, .columns = {columns, 1}};
  tired.definition->detector(tired.values(), seen);
  EXPECT_EQ(seen.range_m, 5 + 3 * 10);
  const auto& slips = *model.find("slips");
  VelocitySample sample{.velocity = {.vx_mps = 1}, .columns = {columns, 0}};
  slips.definition->velocity_map(slips.values(), sample);
  EXPECT_EQ(sample.velocity.vx_mps, 1 + 4 * 3);
}

TEST(Expression, FileRoundTripKeepsAnyName) {
  for (const char* name : {"a: {b} #", "</script>", "- slip", "a b", "12", "'"}) {
    const Model model = model_of(fmt::format(
        "  \"{}\": {{stage: sensor, mean: \"mean + k * t\", parameters: {{k: {{value: 0.5}}}}}}",
        name));
    const Model again = Model::from_config(ConfigNode::from_text(model.to_yaml(), "again"));
    ASSERT_EQ(again.effects().size(), 1u) << name;
    EXPECT_EQ(again.effects()[0].definition->name, model.effects()[0].definition->name);
  }
}

TEST(Expression, FileRoundTripKeepsWhatIsSaidOfAValue) {
  const Model model = model_of(
      "  warm: {stage: sensor, mean: \"mean + k * t\", parameters: {k: {value: 0.5, sigma: 0.01, "
      "free: true, spread: 0.2}}}");
  const Model again = Model::from_config(ConfigNode::from_text(model.to_yaml(), "again"));
  const ParameterValue& value = again.find("warm")->parameters[0];
  EXPECT_EQ(value.value, 0.5);
  EXPECT_EQ(value.sigma, 0.01);
  EXPECT_TRUE(value.free);
  EXPECT_EQ(value.spread, 0.2);
}

TEST(Expression, EachStageHasItsVariables) {
  EXPECT_NO_THROW(
      model_of("  a: {stage: radiometry, gain: \"1 - k * rho^2\", parameters: {k: 0.1}}"));
  EXPECT_NO_THROW(
      model_of("  a: {stage: light, gain: \"1 + k * sin(t)\", parameters: {k: {value: 0.1}}}"));
  EXPECT_NO_THROW(
      model_of("  a: {stage: sensor, mean: \"mean + k * mean^2\", parameters: {k: {value: 0.1}}}"));
  EXPECT_NO_THROW(
      model_of("  a: {stage: detector, range: \"range * (1 + k * bearing)\", parameters: {k: "
               "{value: 0.1}}}"));
  EXPECT_NO_THROW(model_of(
      "  a: {stage: locomotion, omega: \"omega + k * vx\", parameters: {k: {value: 0.1}}}"));
  EXPECT_ANY_THROW(model_of(
      "  a: {stage: locomotion, omega: \"omega + k * v\", parameters: {k: {value: 0.1}}}"));
  EXPECT_ANY_THROW(model_of("  a: {stage: timing, omega: \"1\"}"));
  EXPECT_ANY_THROW(model_of("  a: {stage: detector, omega: \"1\"}"));
  EXPECT_ANY_THROW(model_of("  a: {stage: detector}"));
  EXPECT_ANY_THROW(model_of("  pinhole: {stage: detector, range: \"range\"}"));
}

TEST(Expression, ATargetFormulaMovesItsPoints) {
  const Model model = model_of(
      "  fold: {stage: target, z: \"z + k * abs(x)\", x: \"x + k * y\", parameters: {k: {value: "
      "0.01}}}");
  const TargetShape shape = target_of(model);
  EXPECT_FALSE(shape.is_plan());
  const Vec3 p = shape.placed({-0.2, 0.1, 0.03}, -1, 1);
  EXPECT_NEAR(p.x, -0.2 + 0.001, 1e-15);
  EXPECT_EQ(p.y, 0.1);
  EXPECT_NEAR(p.z, 0.03 + 0.002, 1e-15);
  const Model absent =
      model_of("  fold: {stage: target, z: \"z + k * abs(x)\", parameters: {k: {value: 0}}}");
  EXPECT_TRUE(target_of(absent).is_plan());
}

TEST(Expression, ADetectorFormulaKnowsHowTheRobotMoves) {
  const Model model = model_of(
      "  lean: {stage: detector, range: \"range + a * speed * speed + b * turn\", parameters: {a: "
      "{value: 0.5}, b: {value: 0.1}}}");
  Detection seen{.range_m = 2, .speed_mps = -0.3, .turn_radps = 1.5};
  apply_detector(model, seen);
  EXPECT_NEAR(seen.range_m, 2 + 0.5 * 0.09 + 0.15, 1e-15);
}

TEST(Expression, ALocomotionFormulaKnowsTheFloor) {
  // A floor that carries the body along its own x: by its speed, whichever way it faces.
  const Model belt = model_of(
      "  belt: {stage: locomotion, vx: \"vx + k * cos(theta)\", vy: \"vy - k * sin(theta)\", "
      "parameters: {k: {value: 0.2}}}");
  WalkState state;
  state.from = {3, 4, 1.1};
  advance_walk(locomotion_of(belt), {}, 2.0, state);
  // On the axes of the start.
  EXPECT_NEAR(state.x_m, 0.4 * std::cos(1.1), 1e-9);
  EXPECT_NEAR(state.y_m, -0.4 * std::sin(1.1), 1e-9);
  // dx/dt = k x: from 3 m on.
  const Model mud =
      model_of("  mud: {stage: locomotion, vx: \"vx + k * x\", parameters: {k: {value: 0.1}}}");
  WalkState goes;
  goes.from = {3, 0, 0};
  advance_walk(locomotion_of(mud), {}, 5.0, goes);
  EXPECT_NEAR(goes.x_m, 3 * (std::exp(0.5) - 1), 1e-8);
  // d(way)/dt = 1 + k way, after 2 m.
  const Model worn = model_of(
      "  worn: {stage: locomotion, vx: \"vx * (1 + k * way)\", parameters: {k: {value: 0.1}}}");
  WalkState rolls;
  rolls.from.path_m = 2;
  advance_walk(locomotion_of(worn), {.vx_mps = 1}, 3.0, rolls);
  EXPECT_NEAR(rolls.path_m, 12 * std::exp(0.3) - 12, 1e-8);
}

TEST(Expression, ALocomotionFormulaIsIntegrated) {
  // A turn in proportion to the heading: theta = exp(k t).
  const Model model = model_of(
      "  spin: {stage: locomotion, omega: \"omega + k * (1 + theta)\", parameters: {k: {value: "
      "0.5}}}");
  WalkState state;
  advance_walk(locomotion_of(model), {}, 2.0, state);
  EXPECT_NEAR(state.theta_rad, std::exp(1.0) - 1, 1e-9);
}

// Formulas that say what effects with names do, against these: of the load, of the winding's
// strength, and of drag against back-EMF.
TEST(TorqueFormula, DoesWhatTheEffectOfItsNameDoes) {
  const auto moved = [](const std::string& more, double stall = 200) {
    const std::string motor = fmt::format(
        "  motor_servo: {{stall_rad_per_s2: {}, back_emf_per_s: 10, gain: 0.1}}\n", stall);
    Servo servo(servo_of(model_of(motor + more)), 0, 0.1);
    std::vector<double> angles;
    servo.command(0.01, 1.2);
    servo.command(0.35, -0.4);
    servo.command(0.55, 0, false);
    for (int k = 1; k <= 80; ++k) servo.advance_to(0.01 * k), angles.push_back(servo.joint_rad());
    return angles;
  };
  const auto apart = [](const std::vector<double>& a, const std::vector<double>& b) {
    double most = 0;
    for (size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
    return most;
  };
  const auto formula = [](const std::string& torque, double k) {
    return fmt::format("  mine: {{stage: joint, torque: \"{}\", parameters: {{k: {}}}}}\n", torque,
                       k);
  };
  const auto load = moved("  gravity_torque: {rad_per_s2: 30, level_rad: 0.4}\n");
  EXPECT_LT(apart(load, moved(formula("-k * cos(q - 0.4)", 30))), 2e-4);
  EXPECT_GT(apart(load, moved("")), 0.1);
  const auto drag = moved("  viscous_friction: {per_s: 6}\n");
  EXPECT_LT(apart(drag, moved(formula("-k * rate", 6))), 2e-4);
  EXPECT_LT(apart(moved("", 260), moved(formula("k * drive", 0.3))), 2e-4);
  EXPECT_EQ(moved(formula("k * drive * t", 0)), moved(""));
}

TEST(TorqueFormula, IsRefusedWhereItCannotAct) {
  const std::string both =
      "  mine: {stage: joint, q: \"q + k\", torque: \"k\", parameters: {k: 0}}\n";
  EXPECT_NE(error_of_model(both).find("expected two effects"), std::string::npos)
      << error_of_model(both);
  const std::string alone = "  mine: {stage: joint, torque: \"k * q\", parameters: {k: 1}}\n";
  EXPECT_NE(error_of_model("  servo_lag: {tau_s: 0.1}\n" + alone).find("motor_servo"),
            std::string::npos)
      << error_of_model("  servo_lag: {tau_s: 0.1}\n" + alone);
  const std::string column = "  mine: {stage: joint, torque: \"k * warmth\", parameters: {k: 1}}\n";
  EXPECT_NE(error_of_model(column).find("warmth"), std::string::npos) << error_of_model(column);
}

}  // namespace
}  // namespace seam::effects
