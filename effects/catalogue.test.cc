// One test for every effect of the catalogue: adding one brings it here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "effects/catalogue_help.h"
#include "effects/proof/proof.h"
#include "effects/questions.h"
#include "effects/registry.h"
#include "effects/stages/detector.h"
#include "effects/stages/geometry.h"
#include "effects/stages/joint_track.h"
#include "effects/stages/noise.h"
#include "effects/stages/optics.h"
#include "effects/stages/sensor/sensor.h"
#include "effects/stages/servo.h"
#include "effects/stages/target.h"
#include "effects/stages/timing.h"
#include "effects/stages/walk/locomotion.h"
#include "sim_core/base/config.h"

namespace seam::effects {
namespace {

Model model_of(const std::string& effects) {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects:\n" + effects, "test.yaml"));
}

const char* const kBase =
    "  pinhole: {fx_px: 160, fy_px: 162, cx_px: 88.5, cy_px: 71.5}\n  linear_response: {gain_dn: "
    "200, black_dn: 8}\n";

// Everything that a model predicts, as one list of numbers.
std::vector<double> everything(const Model& model) {
  std::vector<double> all;
  const Timing timing = timing_of(model);
  for (const double row : {0.0, 71.0, 143.0})
    all.push_back(timing.row_middle_after_stamp_s(row, 12.5));
  all.push_back(timing.jitter_sigma_s);
  JointTrack track{.time_s = {0, 0.1, 0.2, 0.3}};
  for (const JointRole role : {JointRole::tilt, JointRole::pan, JointRole::roll}) {
    track.joints.push_back({.name = "j", .role = role, .q_rad = {0.1, 0.3, -0.2, 0.25}});
  }
  apply_encoder_effects(model, track);
  for (const JointSeries& joint : track.joints)
    all.insert(all.end(), joint.q_rad.begin(), joint.q_rad.end());
  all.push_back(track.quantisation_step_rad);
  Servo servo(servo_of(model), 0, 0.1);
  for (int k = 0; k < 20; ++k) {
    servo.advance_to(0.008 * k);
    all.push_back(servo.joint_rad());
    servo.command(0.008 * k, k % 7 < 3 ? 0.4 + 0.004 * k : -0.1 * k);
  }
  const Pose X_LC = mount_of(model);
  for (const Vec3& p : {Vec3{0.1, 0.2, 0.3}, Vec3{-1, 0.5, 0.2}}) {
    const Vec3 q = X_LC * p;
    all.insert(all.end(), {q.x, q.y, q.z});
  }
  const Projection camera(model, 178, 144);
  for (const int channel : {0, 1, 2}) {
    const ImagePoint point = camera.project({0.21, -0.13, 1.1}, 3.0, 40, channel);
    all.insert(all.end(), {point.u, point.v});
  }
  const Optics optics = optics_of(model);
  all.insert(all.end(), {optics.blur_sigma_px, optics.glare_fraction});
  for (const Stage stage : {Stage::radiometry, Stage::light})
    all.push_back(GainField(model, stage, 178, 144).at(20, 130, 2.0));
  all.push_back(lamp_brightness(model, {.start_s = 0.123, .exposure_s = 0.005}));
  const SensorChain chain = sensor_of(model);
  for (int channel = 0; channel < 3; ++channel) {
    const SensorExposure exposure{.exposure_s = 0.005};
    for (const double light : {0.4, 1.2}) {
      const Moments moments =
          response_moments(chain, signal_dn(chain, light, exposure), channel, exposure);
      const Moments file = file_moments(chain, moments, 8);
      all.insert(all.end(),
                 {moments.mean_dn, moments.variance_dn2, file.mean_dn, file.variance_dn2});
    }
  }
  all.insert(all.end(),
             {chain.pixel_gain_sigma, chain.pixel_offset_sigma_dn, chain.column_sigma_dn,
              chain.row_sigma_dn, chain.read_sigma_dn, chain.hot_fraction, chain.weak_fraction,
              chain.dark_sigma_dn_per_s, chain.lamp_sigma, chain.wave.amplitude_dn});
  Detection detection{.range_m = 1.7, .bearing_rad = -0.3, .t_s = 4};
  apply_detector(model, detection);
  all.insert(all.end(), {detection.range_m, detection.bearing_rad, detection.range_variance,
                         detection.bearing_variance});
  const Noise noise = noise_of(model);
  all.insert(all.end(), {static_cast<double>(noise.hangs_together()), noise.range_tail.fraction,
                         noise.point_scatter.fraction, static_cast<double>(noise.pose.size())});
  const Locomotion walk = locomotion_of(model);
  WalkState state;
  for (const BodyVelocity& v : {BodyVelocity{0.2, 0.05, 0.4}, BodyVelocity{-0.1, 0, 0}})
    advance_walk(walk, v, 0.7, state);
  all.insert(all.end(), {state.x_m, state.y_m, state.theta_rad, walk.xy_sigma, walk.theta_sigma});
  const TargetShape target = target_of(model);
  const Vec3 corner = target.placed({0.1, -0.2, 0.01}, 0.5, -0.7, 1e-3 * target.flex_sigma_m);
  all.insert(all.end(), {corner.x, corner.y, corner.z, target.scatter_sigma_m,
                         target.sway_shift_sigma_m, target.sway_turn_sigma_rad});
  return all;
}

class Catalogue : public testing::TestWithParam<std::string> {};

TEST_P(Catalogue, NeutralIsAbsentBitForBit) {
  const auto effect = find_effect(GetParam());
  if (!effect->has_neutral) GTEST_SKIP() << GetParam() << " is a base or a replacement";
  Model with = model_of(kBase);
  if (with.has(effect->name)) GTEST_SKIP() << GetParam() << " is part of the base";
  const std::vector<double> before = everything(with);
  with.add_neutral(effect);
  EXPECT_EQ(everything(with), before);
}

TEST_P(Catalogue, HelpAndExampleAreWhole) {
  const auto effect = find_effect(GetParam());
  for (const std::string& text :
       {effect->help, effect->formula, effect->signature, effect->example})
    EXPECT_FALSE(text.empty());
  EXPECT_NE(effect->kinds, 0u);
  std::string base;
  if (effect->needs_base != Base::none)
    base = "  " + find_effect(base_name(effect->needs_base))->example + "\n";
  const Model example = model_of(base + "  " + effect->example + "\n");
  ASSERT_TRUE(example.has(effect->name));
  EXPECT_EQ(Model::from_config(ConfigNode::from_text(example.to_yaml(), "again")).to_yaml(),
            example.to_yaml());
  for (const Parameter& parameter : effect->parameters) {
    EXPECT_FALSE(parameter.help.empty()) << parameter.name;
    EXPECT_LT(parameter.min, parameter.max) << parameter.name;
    EXPECT_GT(parameter.scale, 0) << parameter.name;
    const bool inside = parameter.neutral >= parameter.min && parameter.neutral <= parameter.max;
    // The neutral value of a count (bits: as many as the file has) is no count itself. Where a gap
    // lies between absent and the least size that there is, the record has starts of fits.
    EXPECT_TRUE(parameter.required || parameter.integer || inside ||
                std::isinf(parameter.neutral) || !effect->starts.empty())
        << parameter.name;
    EXPECT_NE(effect_help(*effect).find(parameter.name), std::string::npos);
    const Plausible& plausible = parameter.plausible;
    if (plausible.source.empty()) continue;
    // Narrower than what has a meaning, and the effect may be absent.
    EXPECT_LT(plausible.min, plausible.max) << parameter.name;
    EXPECT_TRUE(plausible.min > parameter.min || plausible.max < parameter.max) << parameter.name;
    EXPECT_GE(plausible.min, parameter.min) << parameter.name;
    EXPECT_LE(plausible.max, parameter.max) << parameter.name;
    if (std::isfinite(parameter.neutral) && inside) {
      EXPECT_TRUE(plausible.min <= parameter.neutral || !effect->starts.empty()) << parameter.name;
      EXPECT_GE(plausible.max, parameter.neutral) << parameter.name;
    }
  }
}

// Numbers that were computed outside SEAM (scripts/effect_proofs.py). Every parameter matters in
// one of the examples: another value fails it.
TEST_P(Catalogue, WorkedExamplesAreMetAndNoticeEachParameter) {
  EXPECT_THAT(open_proofs(find_effect(GetParam())), testing::IsEmpty());
}

// Records that refer to others refer to effects that exist, and promise no hook that is missing.
TEST_P(Catalogue, AnswersAreWhole) {
  const auto effect = find_effect(GetParam());
  for (const Advice& advice : effect->advice) {
    EXPECT_FALSE(advice.text.empty());
    for (const std::string& other : advice.from) {
      ASSERT_NE(find_effect(other), nullptr) << other;
      EXPECT_EQ(advice_between(effect->name, other, advice.kinds), advice.text);
      EXPECT_EQ(advice_between(other, effect->name, advice.kinds), advice.text);
    }
  }
  for (const std::string& name : effect->companions) EXPECT_NE(find_effect(name), nullptr) << name;
  for (const StartRule& rule : effect->starts) {
    EXPECT_EQ(rule.kinds & ~effect->kinds, 0u);
    const bool lists = rule.search == StartSearch::listed ||
                       rule.search == StartSearch::best_listed ||
                       rule.search == StartSearch::shapes || rule.search == StartSearch::motion;
    EXPECT_EQ(lists, !rule.values.empty());
    EXPECT_TRUE(rule.search != StartSearch::excess || effect->start_from_excess);
    for (const auto& values : rule.values) EXPECT_EQ(values.size(), effect->parameters.size());
  }
}

INSTANTIATE_TEST_SUITE_P(AllEffects, Catalogue, testing::ValuesIn(effect_names()),
                         [](const auto& info) { return info.param; });

// Causes that people have say between which values they lie there: beyond it a result is doubted.
TEST(PlausibleSizes, AreKnownOfCausesThatPeopleHave) {
  // Where a wave or a light is, and what is counted in a unit of the set's own, may be anything.
  const auto is_free = [](const Parameter& parameter) {
    return testing::Matches(testing::ContainsRegex(
        "phase|level|direction|angle|period_px|per_turn|^[uv]0$|^at_m$|^light$"))(parameter.name);
  };
  for (const char* name :
       {"view_motion",         "focus_variation",   "focal_drift",    "flat_port",
        "mount_sag",           "backlash",          "tracker_offset", "tracker_turn",
        "turn_asymmetry",      "encoder_skew",      "wheel_growth",   "wheel_load",
        "landmark_delay",      "landmark_height",   "wall_excess",    "mount_offset",
        "elastic_joint",       "gear_ripple",       "command_jitter", "friction_asymmetry",
        "load_friction",       "torque_cogging",    "motor_heating",  "effort_scale",
        "exposure_stamp",      "amplifier_glow",    "tap_gain",       "periodic_pattern",
        "dark_current_spread", "focal_temperature", "noise_filter"}) {
    const auto effect = find_effect(name);
    ASSERT_NE(effect, nullptr) << name;
    EXPECT_FALSE(effect->advice.empty()) << name;
    for (const Parameter& parameter : effect->parameters)
      EXPECT_TRUE(is_free(parameter) || !parameter.plausible.source.empty())
          << name << "." << parameter.name << ": no plausible range with a source";
  }
}

TEST(CataloguePage, AndListHaveEveryEffect) {
  for (const std::string& name : effect_names()) {
    EXPECT_NE(catalogue_markdown().find("### `" + name + "`"), std::string::npos) << name;
    EXPECT_NE(catalogue_list().find("\n  " + name + " "), std::string::npos) << name;
  }
}

TEST(CataloguePage, IsTheProgramsOwn) {
  const std::string path = SEAM_SOURCE_DIR "/docs/reference/effects.md";
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  if (text.str() == catalogue_markdown()) return;
  std::ofstream(path + ".new") << catalogue_markdown();
  ADD_FAILURE() << path << " differs from the program; the right page is " << path
                << ".new (or: seam effects --markdown > docs/reference/effects.md)";
}

}  // namespace
}  // namespace seam::effects
