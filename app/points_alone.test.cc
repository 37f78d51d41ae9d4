// What acts on measured points alone (a detector of corners, a target) leaves images, runs and
// files of other programs as they are.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/exchange/exchange.h"
#include "app/simulator.h"
#include "effects/cameras.h"
#include "effects/questions.h"
#include "effects/registry.h"
#include "effects/stages/geometry.h"
#include "effects/stages/timing.h"
#include "render/renderer.h"
#include "render/test_scenes.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

using effects::EffectDefinition;
using effects::ImagePoint;
using effects::Model;
using effects::Values;

const char* const kCamera = "  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}\n";

// As a plugin would write it: with the hook for detectors, or with one of the camera's.
EffectDefinition moves_points(bool by_hook_of_detectors) {
  EffectDefinition effect{.name = "corner_shift",
                          .stage = effects::Stage::geometry,
                          .kinds = effects::kPoints,
                          .parameters = {{.name = "shift_px", .min = -5, .max = 5}}};
  auto& hook = by_hook_of_detectors ? effect.corner_detector : effect.image_map;
  hook = [](Values p, ImagePoint& point) { point.u += p[0]; };
  return effect;
}

Model with(const EffectDefinition& effect, double value) {
  Model model = render::testing::model_of(kCamera);
  model.set(std::make_shared<const EffectDefinition>(effect), {{.value = value}});
  return model;
}

class PointsAlone : public ::testing::TestWithParam<bool> {};

TEST_P(PointsAlone, ReachMeasuredPointsAndNoLight) {
  const Model model = with(moves_points(GetParam()), 1.5);
  const Vec3 p_C(0.2, -0.1, 2);
  const double u = 161.9 * 0.1 + 88.5;
  EXPECT_DOUBLE_EQ(effects::Projection(model, 178, 144).project(p_C).u, u);
  const ImagePoint seen =
      effects::Projection(model, 178, 144, effects::Reaches::detector).project(p_C);
  EXPECT_DOUBLE_EQ(seen.u, u + 1.5);
}

TEST_P(PointsAlone, ChangeNoFrame) {
  const render::testing::MovingScene scene{
      .camera = [](double) { return render::testing::head_camera(0.2, 0, 0, 0); },
      .primitives =
          [](double) {
            return std::vector{render::testing::sphere({0.6, 0, 0.2}, 0.05, {0.9, 0.3, 0.1})};
          }};
  const auto frame = [&](const Model& model) {
    return render::Renderer(model, 178, 144)
        .render(render::testing::job_of(scene, model, 144, 0.0, 1));
  };
  EXPECT_EQ(frame(with(moves_points(GetParam()), 5)).rgb,
            frame(render::testing::model_of(kCamera)).rgb);
}

TEST_P(PointsAlone, ChangeNoExportAndAreNamedThere) {
  for (const ExchangeFormat& format : exchange_formats()) {
    if (format.text == nullptr) continue;
    const ExportOptions size{.width_px = 178, .height_px = 144};
    const Exported plain = export_model(render::testing::model_of(kCamera), format, size);
    const Exported exported = export_model(with(moves_points(GetParam()), 5), format, size);
    EXPECT_EQ(exported.text, plain.text) << format.name;
    ASSERT_EQ(exported.notes.size(), plain.notes.size() + 1) << format.name;
    EXPECT_THAT(exported.notes, ::testing::Contains(::testing::HasSubstr("corner_shift")));
  }
}

TEST_P(PointsAlone, AreNoCandidatesForOutcomes) {
  EXPECT_FALSE(effects::acts_on(moves_points(GetParam()), {.kind = effects::kOutcomes}));
  EXPECT_TRUE(effects::acts_on(moves_points(GetParam()), {.kind = effects::kPoints}));
  EXPECT_FALSE(effects::acts_on(moves_points(GetParam()), {.kind = effects::kFrames}));
}

INSTANTIATE_TEST_SUITE_P(ByEitherHook, PointsAlone, ::testing::Bool());

// What the simulator makes of a robot's model: nothing of points alone is left of it, whatever it
// would do to the time of rows or to the camera's place.
TEST(PointsAloneOfARobot, AreNotInItsRun) {
  Scenario scenario;
  scenario.robots.resize(1);
  RobotSpec& robot = scenario.robots.front();
  robot.id = "red1";
  robot.camera.model_name = "seen";
  robot.camera.model_yaml =
      std::string("format: seam-model/1\neffects:\n") + kCamera +
      "  board_warp: {x_m: 0.001}\n"
      "  found_left: {stage: corner_detector, u: u - d, parameters: {d: {value: 0.4}}}\n";
  const Model model = models_of(scenario).front();
  EXPECT_EQ(model.effects().size(), 1u);
  EXPECT_TRUE(model.has("pinhole"));

  EffectDefinition late = moves_points(true);
  late.corner_detector = nullptr;
  late.timing = [](Values p, effects::Timing& timing) { timing.latency_s += p[0]; };
  EXPECT_FALSE(effects::without_points_own(with(late, 0.1)).has("corner_shift"));
}

// What its own record says no picture shows is refused where a robot's camera has it, with what to
// use instead; at its neutral values, where it is absent, it is not.
TEST(PointsAloneOfARobot, AreRefusedWhereTheyAreTheCameras) {
  size_t refused = 0;
  for (const auto& effect : effects::catalogue()) {
    const std::string why = effects::not_pictured(*effect);
    if (why.empty()) continue;
    ++refused;
    Scenario scenario;
    scenario.robots.resize(1);
    scenario.robots.front().id = "red1";
    CameraSpec& camera = scenario.robots.front().camera;
    camera.model_name = "seen";
    const std::string base =
        std::string("format: seam-model/1\nname: seen\neffects:\n") + kCamera + "  ";
    camera.model_yaml = base + effect->example + "\n";
    try {
      models_of(scenario);
      ADD_FAILURE() << effect->name << " is taken";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr("model 'seen': no picture shows '" +
                                                     effect->name + "': " + why));
    }
    camera.model_yaml = base + effect->name + ": {}\n";
    EXPECT_EQ(models_of(scenario).front().effects().size(), 1u) << effect->name;
  }
  EXPECT_EQ(refused, 4u);
}

TEST(PointsAloneAtTheDoor, ADetectorOfCornersThatSaysToActOnImagesIsRefused) {
  EffectDefinition effect = moves_points(true);
  effect.kinds = effects::kPoints | effects::kFrames;
  EXPECT_THROW(effects::register_effect(effect), InputError);
}

}  // namespace
}  // namespace seam::app
