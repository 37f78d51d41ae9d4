// What rows can see of a job with scenery and figures is what they see where all of it is put in
// its place; and figures out of sight are not.
#include "render/cast/frame_scenes.h"

#include <gtest/gtest.h>

#include <cstring>

#include "render/cast/scene_motion.h"
#include "render/ground_truth.h"
#include "render/renderer.h"
#include "render/test_scenes.h"
#include "sim_core/world/world.h"

namespace seam::render {
namespace {

using namespace testing;

constexpr int kWidth_px = 89, kHeight_px = 72;

// A viewer that walks and swings its head among seven others, some of them behind it.
World walking_robots() {
  const std::string models = std::string(SEAM_SOURCE_DIR) + "/models/";
  std::string yaml =
      "format: seam-scenario/1\nname: t\nduration_s: 100\nfield: '" + models +
      "field_2002.yaml'\nball: {x_m: -0.4, y_m: 0.1, vx_mps: 0.4}\n"
      "objects:\n  - {shape: box, centre_m: [0.6, 0.9, 0.1], size_m: [0.2, 0.2, 0.2], rgb: [1, 0, "
      "0]}\n"
      "  - {shape: sphere, centre_m: [0, 0.5, 0.1], radius_m: 0.1, rgb: [0, 1, 1], velocity_mps: "
      "[0, -1, 0]}\n"
      "  - {shape: box, centre_m: [0.3, -0.9, 0.1], size_m: [0.2, 0.2, 0.2], rgb: [1, 0, 0]}\n";
  yaml += "robots:\n";
  const double places[8][3] = {{-0.9, 0, 0.1},  {-0.6, 0.15, 2}, {0.5, -0.3, 3},  {0, -0.2, 0.5},
                               {1.2, 0.2, 2.5}, {-1.8, 0.3, 1},  {-1.3, 0, -1.7}, {-0.85, 0.45, 0}};
  for (int i = 0; i < 8; ++i)
    yaml += fmt::format(
        "  - {{id: r{}, team: {}, pose: {{x_m: {}, y_m: {}, theta_rad: {}}}, body: "
        "'{}robot_ers210.yaml'}}\n",
        i, i % 2 ? "blue" : "red", places[i][0], places[i][1], places[i][2], models);
  World world(Scenario::from_text(yaml, "test"));
  for (size_t i = 0; i < 8; ++i) {
    RobotCommand command;
    command.walk = BodyVelocity{0.2, 0.05, i % 2 ? 0.4 : -1.5};
    if (i == 0)
      command.joints.push_back(
          {.targets = {{.joint = kPan, .angle_rad = 1.2}, {.joint = kTilt, .angle_rad = -0.6}}});
    world.apply(i, command, SimTime());
  }
  while (world.end() < SimTime::from_s(0.3)) world.step();
  return world;
}

const effects::Model& camera() {
  static const effects::Model model = model_of(
      "  pinhole: {fx_px: 81, fy_px: 81, cx_px: 44, cy_px: 36}\n"
      "  rolling_shutter: {line_delay_s: 5.56e-4}\n  exposure: {exposure_s: 0.005}\n");
  return model;
}

FrameJob job_in(World& world, bool lambert) {
  FrameJob job{.robot = "r0", .stamp = SimTime::from_s(0.31)};
  job.schedule = effects::make_row_schedule(effects::timing_of(camera()), job.stamp, kHeight_px);
  for (const SimTime time : job.schedule.instants) {
    while (world.end() < time) world.step();
    job.instants.push_back(world.view_of(0, time, rotation(link_to_camera_axes())));
  }
  job.scenery = world.scenery();
  job.background = world.background();
  job.lighting = {.lambert = lambert, .direction_W = {0.6, 0, 0.8}, .ambient = 0.4, .diffuse = 0.6};
  job.camera_noise = {.seed = 1, .stream = 2};
  return job;
}

template <typename Values>
void expect_same_bytes(const Values& a, const Values& b, const char* what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])), 0) << what;
}

void expect_same(const PreparedInstant& a, const PreparedInstant& b) {
  expect_same_bytes(a.shapes, b.shapes, "shapes");
  expect_same_bytes(a.kinds, b.kinds, "kinds");
  expect_same_bytes(a.footprints, b.footprints, "footprints");
  expect_same_bytes(a.colours, b.colours, "colours");
  expect_same_bytes(a.signatures, b.signatures, "signatures");
  expect_same_bytes(a.sources, b.sources, "sources");
  expect_same_bytes(a.outline_edges, b.outline_edges, "outlines");
  expect_same_bytes(a.sweeps, b.sweeps, "sweeps");
}

class FrameScenesOf : public ::testing::TestWithParam<bool> {
 protected:
  World world = walking_robots();
  const FrameJob job = job_in(world, GetParam());
  const FrameJob whole = with_all_primitives(job);
  const CameraRays rays =
      make_camera_rays(effects::Projection(camera(), kWidth_px, kHeight_px), "test", 2, 0);
};
INSTANTIATE_TEST_SUITE_P(Lighting, FrameScenesOf, ::testing::Values(false, true));

TEST_P(FrameScenesOf, RowsSeeWhatTheySeeOfAllPrimitives) {
  FrameScenes scenes(job, rays);
  PreparedInstant found, expected;
  size_t seen = 0;
  for (size_t k = 0; k < job.instants.size(); ++k) {
    const int first = static_cast<int>(k) * rays.rows() / static_cast<int>(job.instants.size());
    for (const RowRange rows :
         {RowRange{first, std::min(first + 9, rays.rows() - 1)}, RowRange{0, rays.rows() - 1}}) {
      scenes.prepare_at(k, rows, found);
      prepare(whole.instants[k], whole, rays, rows, expected);
      expect_same(found, expected);
      seen += found.sources.size();
    }
    if (k + 1 == job.instants.size()) break;
    // Between instants, of which one may lack a robot that is behind the camera.
    for (const int64_t quarter : {1, 2, 3}) {
      const SimTime time =
          job.instants[k].time + (job.instants[k + 1].time - job.instants[k].time) * quarter / 4;
      scenes.prepare_at(time, {first, rays.rows() - 1}, found);
      prepare(interpolate(whole.instants[k], whole.instants[k + 1], time), whole, rays,
              {first, rays.rows() - 1}, expected);
      expect_same(found, expected);
    }
  }
  EXPECT_GT(seen, 40 * job.instants.size());
}

TEST_P(FrameScenesOf, MotionAboveWhatIsEnoughIsThatOfAllPrimitives) {
  for (const double enough_px : {0.0, 0.1, 0.3, 1.0}) {
    FrameScenes scenes(job, rays), all(whole, rays);
    for (size_t k = 0; k + 1 < job.instants.size(); ++k) {
      const double found = scenes.motion_px(k, enough_px), expected = all.motion_px(k, 0);
      EXPECT_LE(found, expected) << k;
      if (expected > enough_px) {
        EXPECT_EQ(found, expected) << k;
      }
    }
  }
}

TEST_P(FrameScenesOf, FramesAreTheSame) {
  for (const double max_motion_px : {1.0, 0.05}) {  // As few instants as can be, and many more.
    const Renderer renderer(camera(), kWidth_px, kHeight_px, {.max_motion_px = max_motion_px});
    EXPECT_EQ(renderer.render(job).fingerprint, renderer.render(whole).fingerprint);
    const GroundTruth a = renderer.ground_truth(job), b = renderer.ground_truth(whole);
    expect_same_bytes(a.object_id, b.object_id, "objects");
    expect_same_bytes(a.depth_m, b.depth_m, "depth");
  }
}

// A ball on a stick, which counts how often it is put in its place.
class CountedFigure final : public Figure {
 public:
  size_t part_count() const override { return 1; }
  void add_parts(const Posture& posture, std::vector<Primitive>& out) const override {
    out.push_back(sphere(posture.p_WB, 0.05, {1, 0, 0}));
    ++placed;
  }
  double radius_m() const override { return 0.05; }
  double motion_bound_m(const Posture& a, const Posture& b) const override {
    return glm::length(b.p_WB - a.p_WB);
  }
  mutable int placed = 0;
};

TEST(FrameScenes, FiguresOutOfSightAreNotPlaced) {
  const CameraRays rays =
      make_camera_rays(effects::Projection(camera(), kWidth_px, kHeight_px), "test", 0, 0);
  CountedFigure ahead, beside, above;
  FrameJob job;
  for (int k = 0; k < 4; ++k) {
    const double moved_m = 0.001 * k;
    job.instants.push_back({.time = SimTime::from_ns(k), .X_WC = head_camera(0.2, 0, 0, 0)});
    job.instants.back().figures = {{&ahead, {.p_WB = {2, moved_m, 0.2}}},
                                   {&beside, {.p_WB = {2, 4 + moved_m, 0.2}}},
                                   {&above, {.p_WB = {2, moved_m, 0.9}}}};
  }
  FrameScenes scenes(job, rays);
  PreparedInstant out;
  for (size_t k = 0; k < 4; ++k) {
    scenes.prepare_at(k, {kHeight_px / 2 - 3, kHeight_px / 2 + 3}, out);
    EXPECT_EQ(out.sources, std::pmr::vector<int>{0});
    // At 2 m a millimetre is 0.04 px; what moves less than is enough need not be placed either.
    if (k > 0) {
      EXPECT_LT(scenes.motion_px(k - 1, 0.5), 0.5);
    }
  }
  EXPECT_EQ(ahead.placed, 4);
  EXPECT_EQ(above.placed, 0);
  EXPECT_GT(scenes.motion_px(0, 0.01), 0.03);
  EXPECT_GT(above.placed, 0);
  EXPECT_EQ(beside.placed, 0);
}

// At 2 m a metre is 40 px and more: instants need not be taken for what no row can see.
TEST(FrameScenes, WhatIsOutOfSightMovesAsItLikes) {
  const CameraRays rays =
      make_camera_rays(effects::Projection(camera(), kWidth_px, kHeight_px), "test", 0, 0);
  const auto motion_px = [&](double y_m, bool as_figure) {
    CountedFigure figure;
    FrameJob job;
    for (int k = 0; k < 2; ++k) {
      job.instants.push_back({.time = SimTime::from_ns(k), .X_WC = head_camera(0.2, 0, 0, 0)});
      const Vec3 p_W(2, y_m + k, 0.2);
      if (as_figure)
        job.instants.back().figures = {{&figure, {.p_WB = p_W}}};
      else
        job.instants.back().primitives = {sphere(p_W, 0.05, {1, 1, 1})};
    }
    return FrameScenes(job, rays).motion_px(0, 0);
  };
  for (const bool as_figure : {false, true}) {
    EXPECT_EQ(motion_px(4, as_figure), 0);
    EXPECT_GT(motion_px(0, as_figure), 25);
    // Seen at the one instant, and at the other.
    EXPECT_GT(motion_px(1, as_figure), 25);
    EXPECT_GT(motion_px(-2, as_figure), 25);
  }
}

}  // namespace
}  // namespace seam::render
