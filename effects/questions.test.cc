// Questions to records: that those who ask need no names, and that effects from elsewhere answer.
#include "effects/questions.h"

#include <gtest/gtest.h>

#include "effects/proof/proof.h"
#include "effects/registry.h"
#include "effects/stages/row_schedule.h"
#include "effects/stages/servo.h"
#include "sim_core/base/config.h"

namespace seam::effects {
namespace {

Model asked_model(const std::string& effects) {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects:\n" + effects, "test.yaml"));
}

const char* const kPinhole = "  pinhole: {fx_px: 160, fy_px: 162, cx_px: 88.5, cy_px: 71.5}\n";

EffectDefinition plugin(Stage stage) {
  return {.name = "of_a_plugin",
          .stage = stage,
          .kinds = kPoints | kRanges,
          .parameters = {{.name = "size", .min = -1, .max = 1}}};
}

TEST(Questions, AnUnknownLensThatDeclaresItsTermIsPushedOutAsThoseOfTheCatalogueAre) {
  EffectDefinition lens = plugin(Stage::geometry);
  lens.term = Term::radial;
  Model model = asked_model(kPinhole);
  EXPECT_FALSE(is_excluded(lens, model));
  model.set(std::make_shared<const EffectDefinition>(lens), {{.value = 0.1}});
  const auto fisheye = find_effect("fisheye");
  remove_replaced(*fisheye, model);
  EXPECT_FALSE(model.has("of_a_plugin"));
  EXPECT_TRUE(model.has("pinhole"));
  model.add_neutral(fisheye);
  EXPECT_TRUE(is_excluded(lens, model));
  EXPECT_FALSE(is_excluded(plugin(Stage::geometry), model));
}

TEST(Questions, BasesAreFoundByWhatTheyAre) {
  EXPECT_EQ(base_name(Base::projection), "pinhole");
  EXPECT_EQ(base_name(Base::response), "linear_response");
  EXPECT_TRUE(has_base(asked_model(kPinhole), Base::projection));
  EXPECT_TRUE(has_base(asked_model("  fisheye: {}\n"), Base::projection));
  EXPECT_EQ(base_of(asked_model("  fisheye: {}\n"), Base::projection), nullptr);
  EXPECT_FALSE(has_base(asked_model("  exposure: {}\n"), Base::projection));
}

TEST(Questions, WhatASetLacksDecides) {
  const SetFacts rest{
      .kind = kRanges,
      .lacks = {{Need::moving_view, "all rests"}, {Need::moving_joint, "no servo"}}};
  EXPECT_EQ(reason_against(plugin(Stage::timing), 0, rest), "all rests");
  EXPECT_EQ(reason_against(plugin(Stage::detector), 0, rest), "");
  EffectDefinition servo = plugin(Stage::joint);
  servo.servo = [](Values, ServoModel&) {};
  EXPECT_EQ(reason_against(servo, 0, rest), "no servo");
  servo.shows_at_rest = true;
  EXPECT_EQ(reason_against(servo, 0, rest), "");
  // A lack without a reason: no candidate at all.
  EffectDefinition colours = plugin(Stage::geometry);
  colours.needs = {Need::colour};
  EXPECT_TRUE(acts_on(colours, rest));
  EXPECT_FALSE(acts_on(colours, {.kind = kRanges, .lacks = {{Need::colour, ""}}}));
  EXPECT_FALSE(acts_on(colours, {.kind = kOdometry}));
}

TEST(Questions, AFormulaAnswersFromItsStage) {
  const Model model =
      asked_model("  swing:\n    stage: joint\n    q: q + a * sin(q)\n    parameters: {a: 0}\n");
  const EffectDefinition& formula = *model.find("swing")->definition;
  const SetFacts unknown{.kind = kPoints, .lacks = {{Need::joints, "no joint"}}};
  EXPECT_EQ(reason_against(formula, 0, unknown), "no joint");
  EXPECT_EQ(start_rule(formula, kPoints).search, StartSearch::slope);
  EXPECT_EQ(advice_between("swing", "exposure", kPoints), "");
}

TEST(Questions, AdviceIsFoundFromBothSidesAndFirstForThePair) {
  EXPECT_EQ(advice_between("exposure", "frame_latency", kPoints),
            advice_between("frame_latency", "exposure", kPoints));
  EXPECT_NE(advice_between("exposure", "frame_latency", kPoints), "");
  EXPECT_EQ(advice_between("exposure", "frame_latency", kRanges), "");
  EXPECT_EQ(advice_between("heading_drift", "odometry_scale", kOdometry),
            "straight walks without turning, and turns on the spot");
  EXPECT_EQ(advice_between("heading_drift", "walk_lag", kOdometry),
            "many changes of command within a run");
}

TEST(Questions, AnExampleThatIsNotMetIsReported) {
  EffectDefinition late = plugin(Stage::timing);
  late.timing = [](Values p, Timing& timing) { timing.latency_s += p[0]; };
  late.proof = {{.values = {0.01}, .given = {{"stamp_s", 1}}, .expected = {{"start_s", 1.02}}}};
  const auto effect = std::make_shared<const EffectDefinition>(late);
  EXPECT_NE(failed_proof(effect).find("found start_s 1.01"), std::string::npos);
  late.proof[0].expected = {{"speed", 1}};
  EXPECT_ANY_THROW(worked(std::make_shared<const EffectDefinition>(late), late.proof[0]));
}

TEST(Questions, WhatExamplesLeaveOpenIsReported) {
  EffectDefinition late = plugin(Stage::timing);
  late.timing = [](Values p, Timing& timing) { timing.latency_s += p[0] + 0.5; };
  late.proof = {{.values = {0.01}, .given = {{"stamp_s", 1}}, .expected = {{"end_s", 1.51}}}};
  auto open = open_proofs(std::make_shared<const EffectDefinition>(late));
  ASSERT_EQ(open.size(), 2u);
  EXPECT_EQ(open[0], "1 worked examples, expected two or more with other values");
  EXPECT_NE(open[1].find("not absent at its neutral values: end_s is 1.5, without"),
            std::string::npos);
  late.timing = [](Values, Timing&) {};
  late.proof = {2, {.values = {0.01}, .given = {{"stamp_s", 1}}, .expected = {{"end_s", 1}}}};
  open = open_proofs(std::make_shared<const EffectDefinition>(late));
  EXPECT_EQ(open, std::vector<std::string>{"no worked example notices another " +
                                           late.parameters[0].name});
}

TEST(Lock, StampsMoveToTheNearestInstantOfTheCycle) {
  const Timing timing{.sync_period_frames = 25};
  const auto at = [](int64_t ns) { return SimTime() + SimDuration::from_ns(ns); };
  const HeadCycle cycle{.start = at(500'000'000), .length = SimDuration::from_ns(2'000'000'000)};
  // Slots of 80 ms from 0.5 s on: 0.5 + 7 * 0.08 is 1.06 s.
  EXPECT_EQ(stamp_in_lock(timing, at(1'030'000'000), cycle), at(1'060'000'000));
  EXPECT_EQ(stamp_in_lock({}, at(1'030'000'000), cycle), at(1'030'000'000));
  EXPECT_EQ(timing.in_lock(0.3, 0), 0.3);  // Nothing that repeats.
}

}  // namespace
}  // namespace seam::effects
