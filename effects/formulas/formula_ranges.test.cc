#include "effects/formulas/formula_ranges.h"

#include <gtest/gtest.h>

#include "effects/stages/detector.h"
#include "effects/stages/geometry.h"
#include "effects/stages/optics.h"
#include "effects/stages/robots/robot_parts.h"
#include "effects/stages/sensor/sensor.h"
#include "sim_core/base/error.h"

namespace seam::effects {
namespace {

Model ranged_model(const std::string& effects) {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects:\n" + effects, "test.yaml"));
}

std::string formula(const std::string& stage, const std::string& output, const std::string& text,
                    const std::string& k = "{value: 1, neutral: 0, min: -1, max: 1}") {
  return "  mine: {stage: " + stage + ", " + output + ": \"" + text + "\", parameters: {k: " + k +
         "}}\n";
}

template <class Task>
std::string error_of(Task task) {
  try {
    task();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

ModelParts parts_of(const std::string& effects) {
  return ModelParts({{"red1", ranged_model(effects)}});
}

RobotSpec red1() {
  RobotSpec robot;
  robot.id = "red1";
  return robot;
}

TEST(NotANumber, AJointsFormulaIsAnErrorWithRobotAndTime) {
  for (const char* text : {"q + k*sqrt(rate - 1)", "q/(k-k)", "q + 1e300*k"}) {
    const auto joint = parts_of(formula("joint", "q", text)).joint(red1(), 0, 0.1, RandomStream{});
    const std::string error = error_of([&] { joint->angle(SimTime::from_ns(1'250'000'000)); });
    EXPECT_NE(error.find("robot 'red1' at 1.25 s: effect 'mine' gives q ="), std::string::npos)
        << text << ": " << error;
  }
}

TEST(NotANumber, AWalksFormulaIsAnErrorWithRobotAndTime) {
  for (const char* text : {"vx + 1e300*k", "vx + k*sqrt(-1-t)", "vx/(k-k)"}) {
    const auto walk = parts_of(formula("locomotion", "vx", text)).locomotion(red1(), {});
    const std::string error = error_of([&] {
      walk->velocity({0.1, 0, 0}, SimTime::from_ns(500'000'000), SimDuration::from_s(0.008));
    });
    EXPECT_NE(error.find("robot 'red1' at 0.5 s: effect 'mine' gives vx ="), std::string::npos)
        << text << ": " << error;
  }
}

TEST(NotANumber, AFormulaThatHoldsChangesNothing) {
  const auto joint =
      parts_of(formula("joint", "q", "q + k*t")).joint(red1(), 0, 0.5, RandomStream{});
  EXPECT_EQ(joint->angle(SimTime::from_ns(2'000'000'000)), 2.5);
}

TEST(NotANumber, StagesOfTheCameraNameTheEffect) {
  const std::string pinhole = "  pinhole: {fx_px: 160, fy_px: 162, cx_px: 15.5, cy_px: 11.5}\n";
  const Model lens = ranged_model(pinhole + formula("geometry", "u", "u + k*sqrt(-1-r2)"));
  const std::string ray = error_of([&] { Projection(lens, 32, 24).check_at(3, 4, 2.5, 1); });
  EXPECT_NE(ray.find("pixel (3, 4) at 2.5 s: effect 'mine' gives u ="), std::string::npos) << ray;
  const Model glass = ranged_model(formula("radiometry", "gain", "1 + k*log(-1-rho)"));
  const GainField field(glass, Stage::radiometry, 32, 24);
  const std::string gain = error_of([&] { field.check_at(3, 4); });
  EXPECT_NE(gain.find("pixel (3, 4): effect 'mine' gives gain ="), std::string::npos) << gain;
}

TEST(NotANumber, ASensorsFormulaIsAnErrorWhereItIsAskedFor) {
  const SensorChain chain =
      sensor_of(ranged_model(formula("sensor", "mean", "mean + k*sqrt(-1-t)")));
  const FixedPattern pattern = fixed_pattern(chain, 4, 2, 1, {});
  const std::vector<float> light(8, 0.5f);
  SensorExposure exposure{.exposure_s = 0.01, .t_s = 3};
  EXPECT_EQ(error_of([&] { expose(chain, pattern, light, exposure, {}); }), "no error");
  exposure.numbers_only = true;
  const std::string error = error_of([&] { expose(chain, pattern, light, exposure, {}); });
  EXPECT_NE(error.find("at 3 s: effect 'mine' gives mean ="), std::string::npos) << error;
}

TEST(NotANumber, ADetectorsFormulaIsAnErrorWithTheTime) {
  const Model model = ranged_model(formula("detector", "range", "range + k*log(-range)"));
  Detection seen{.range_m = 2, .t_s = 7};
  const std::string error = error_of([&] { apply_detector(model, seen, true); });
  EXPECT_NE(error.find("at 7 s: effect 'mine' gives range ="), std::string::npos) << error;
}

TEST(FormulaRanges, FindsWhereAFormulaGivesNoNumber) {
  const auto found = [](const std::string& effects) {
    return troubles_of_formulas(ranged_model(effects));
  };
  for (const std::string& bad :
       {formula("joint", "q", "q + k*sqrt(rate)"), formula("joint", "q", "q/(k-k)"),
        formula("locomotion", "vx", "vx + 1e300*k"), formula("geometry", "u", "u + k/(x*0)"),
        formula("radiometry", "gain", "1 + k*log(0*rho)"),
        formula("sensor", "mean", "mean + k*log(mean)"),
        formula("detector", "range", "range + k*sqrt(bearing)")}) {
    const auto troubles = found(bad);
    ASSERT_EQ(troubles.size(), 1) << bad;
    EXPECT_TRUE(troubles[0].certain) << troubles[0].text;
    EXPECT_NE(troubles[0].text.find("effects.mine: the formula gives"), std::string::npos);
  }
  EXPECT_TRUE(found(formula("joint", "q", "q + k*sqrt(rate*rate)")).empty());
  // Well at its own value, not at a bound that the file allows.
  const auto possible =
      found(formula("joint", "q", "q + k*sqrt(rate)", "{value: 0, neutral: 0, min: 0, max: 1}"));
  ASSERT_EQ(possible.size(), 1);
  EXPECT_FALSE(possible[0].certain);
}

}  // namespace
}  // namespace seam::effects
