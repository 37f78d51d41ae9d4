// The detectors against masks made here by casting a ray for each pixel.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>

#include "robot_sdk/vision/ball_detector.h"
#include "robot_sdk/vision/landmark_detector.h"

namespace seam::sdk {
namespace {

constexpr int kWidth = 178, kHeight = 144;
const CameraBelief kCamera;
const NeckBelief kNeck;

struct World {
  std::vector<uint8_t> bits = std::vector<uint8_t>(kWidth * kHeight);
  ColourMask mask() const { return {kWidth, kHeight, bits}; }
};

// Colours every pixel by what its ray meets; positions are in the body frame, z above the ground.
World cast(const HeadAngles& head,
           const std::function<std::optional<Colour>(const BodyRay&)>& colour_of) {
  World world;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const auto colour = colour_of(ray_of(u, v, head, kCamera, kNeck));
      if (colour) world.bits[v * kWidth + u] = static_cast<uint8_t>(1 << static_cast<int>(*colour));
    }
  }
  return world;
}

bool hits_ball(const BodyRay& ray, float x, float y) {
  const float cx = x - ray.origin_m.x, cy = y - ray.origin_m.y;
  const float cz = kBallRadius_m - kNeck.body_height_m - ray.origin_m.z;
  const float along = cx * ray.direction.x + cy * ray.direction.y + cz * ray.direction.z;
  return cx * cx + cy * cy + cz * cz - along * along < kBallRadius_m * kBallRadius_m && along > 0;
}

// The height above the ground at which a ray meets an upright cylinder of radius 5 cm.
std::optional<float> height_on_post(const BodyRay& ray, float x, float y) {
  const float px = ray.origin_m.x - x, py = ray.origin_m.y - y;
  const float a = ray.direction.x * ray.direction.x + ray.direction.y * ray.direction.y;
  const float b = px * ray.direction.x + py * ray.direction.y;
  const float c = px * px + py * py - 0.05f * 0.05f;
  const float root = b * b - a * c;
  if (root < 0) return std::nullopt;
  const float t = (-b - std::sqrt(root)) / a;
  if (t < 0) return std::nullopt;
  return ray.origin_m.z + t * ray.direction.z + kNeck.body_height_m;
}

TEST(ColourRegions, ConnectsDiagonalsAndSortsBySize) {
  // A "U" whose arms join only at the bottom, beside a single pixel.
  std::vector<uint8_t> bits(8 * 5);
  const auto set = [&](int u, int v) { bits[v * 8 + u] = 1; };
  for (int v = 0; v < 4; ++v) set(0, v), set(3, v);
  set(1, 4), set(2, 4), set(6, 0);
  const auto regions = find_regions({8, 5, bits}, Colour::orange, 1);
  ASSERT_EQ(regions.size(), 2u);
  EXPECT_EQ(regions[0].area_px, 10);
  EXPECT_FLOAT_EQ(regions[0].u_mean, 1.5f);
  EXPECT_TRUE(regions[0].at_border);
  EXPECT_EQ(regions[1].area_px, 1);
  EXPECT_TRUE(find_regions({8, 5, bits}, Colour::pink, 1).empty());
}

class BallAt : public testing::TestWithParam<std::pair<float, float>> {};

TEST_P(BallAt, DistanceAndBearingAreRightWithinThePixels) {
  const auto [x, y] = GetParam();
  const HeadAngles head{-0.25f, std::atan2(y, x - 0.1f) * 0.8f, 0};
  const World world = cast(head, [&, x = x, y = y](const BodyRay& ray) -> std::optional<Colour> {
    if (hits_ball(ray, x, y)) return Colour::orange;
    return std::nullopt;
  });
  const auto ball = find_ball(
      world.mask(), [&](float) { return head; }, kCamera, kNeck);
  ASSERT_TRUE(ball.has_value());
  const float truth = std::sqrt(x * x + y * y);
  // Half a pixel of radius is the limit of a binary mask.
  const float radius_px = 162 * kBallRadius_m / truth;
  EXPECT_NEAR(ball->distance_m, truth, truth * 0.5f / radius_px);
  EXPECT_NEAR(ball->bearing_rad, std::atan2(y, x), 1.0f / 162);
}

INSTANTIATE_TEST_SUITE_P(Places, BallAt,
                         testing::Values(std::pair{0.4f, 0.0f}, std::pair{0.7f, 0.2f},
                                         std::pair{1.0f, -0.5f}, std::pair{1.6f, 0.3f}));

TEST(BallDetector, SaysNothingWithoutABall) {
  const World world;
  EXPECT_FALSE(find_ball(
                   world.mask(), [](float) { return HeadAngles{}; }, kCamera, kNeck)
                   .has_value());
}

// A mask in which a rectangle of pixels is orange.
World orange_box(int u_min, int u_max, int v_min, int v_max) {
  World world;
  for (int v = v_min; v <= v_max; ++v) {
    for (int u = u_min; u <= u_max; ++u) world.bits[v * kWidth + u] = 1;
  }
  return world;
}

std::optional<BallSighting> checked_ball(const World& world, const HeadAngles& head,
                                         float rim_px = 0) {
  return find_ball(world.mask(), [&](float) { return head; }, kCamera, kNeck,
                   {.rim_px = rim_px, .check = true});
}

TEST(BallDetector, LeavesOutLinesAndSizesThatNoBallHas) {
  const HeadAngles head{-0.1f, 0, 0};
  EXPECT_FALSE(checked_ball(orange_box(60, 80, 80, 80), head));    // The foot of a yellow goal.
  EXPECT_FALSE(checked_ball(orange_box(0, 30, 80, 81), head));     // The same, cut by the border.
  EXPECT_FALSE(checked_ball(orange_box(90, 93, 120, 123), head));  // Far too small for where it is.
  EXPECT_FALSE(checked_ball(orange_box(60, 110, 40, 80), head));   // Far too large for the horizon.
  EXPECT_TRUE(find_ball(
      orange_box(60, 110, 40, 80).mask(), [&](float) { return head; }, kCamera, kNeck));
}

TEST(BallDetector, TakesTheBallBesideALargerPatchThatIsNone) {
  const HeadAngles head{-0.25f, 0, 0};
  World world = cast(head, [&](const BodyRay& ray) -> std::optional<Colour> {
    if (hits_ball(ray, 1.0f, 0.1f)) return Colour::orange;
    return std::nullopt;
  });
  for (int u = 100; u < 178; ++u) world.bits[20 * kWidth + u] = world.bits[21 * kWidth + u] = 1;
  const auto ball = checked_ball(world, head);
  ASSERT_TRUE(ball);
  EXPECT_NEAR(ball->distance_m, std::sqrt(1.01f), 0.06f);
}

TEST(BallDetector, APartlyHiddenBallIsWhereItsCentreSays) {
  // Two fifths of it are behind a leg: the area says a quarter farther.
  const HeadAngles head{-0.4f, 0, 0};
  const World world = cast(head, [&](const BodyRay& ray) -> std::optional<Colour> {
    if (hits_ball(ray, 0.5f, 0) && ray.direction.y > -0.02f * ray.direction.x)
      return Colour::orange;
    return std::nullopt;
  });
  const auto ball = checked_ball(world, head);
  ASSERT_TRUE(ball);
  EXPECT_GT(ball->from_area_m, 1.1f * ball->from_centre_m);
  EXPECT_NEAR(ball->distance_m, 0.5f, 0.02f);
}

TEST(BallDetector, AllowsForTheRimThatNoColourClaims) {
  const HeadAngles head{-0.1f, 0, 0};
  const auto smaller = [&](const BodyRay& ray) -> std::optional<Colour> {
    // What is left of a ball at 1.5 m whose outermost pixel is lost.
    const float cx = 1.5f - ray.origin_m.x,
                cz = kBallRadius_m - kNeck.body_height_m - ray.origin_m.z;
    const float along =
        cx * ray.direction.x - ray.origin_m.y * ray.direction.y + cz * ray.direction.z;
    const float off2 = cx * cx + ray.origin_m.y * ray.origin_m.y + cz * cz - along * along;
    const float radius = kBallRadius_m - along / 162;
    if (off2 < radius * radius) return Colour::orange;
    return std::nullopt;
  };
  const World world = cast(head, smaller);
  EXPECT_GT(checked_ball(world, head)->distance_m, 1.6f);
  EXPECT_NEAR(checked_ball(world, head, 1)->distance_m, 1.5f, 0.08f);
}

TEST(LandmarkDetector, NamesAndMeasuresABeacon) {
  for (const bool pink_low : {true, false}) {
    const float x = 1.3f, y = 0.45f;
    const HeadAngles head{0.05f, 0.25f, 0};
    const World world = cast(head, [&](const BodyRay& ray) -> std::optional<Colour> {
      const auto height = height_on_post(ray, x, y);
      if (!height || *height < 0 || *height > 0.4f) return std::nullopt;
      if (*height < 0.2f) return std::nullopt;  // White.
      return (*height < 0.3f) == pink_low ? Colour::pink : Colour::skyblue;
    });
    const auto found = find_landmarks(
        world.mask(), [&](float) { return head; }, kCamera, kNeck);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].kind, pink_low ? LandmarkKind::beacon_skyblue_pink_low
                                      : LandmarkKind::beacon_skyblue_pink_high);
    // The near side of the post is 5 cm closer than its axis; one pixel of height is the limit.
    EXPECT_NEAR(found[0].range_m, std::sqrt(x * x + y * y) - 0.05f, 0.09f);
    EXPECT_NEAR(found[0].bearing_rad, std::atan2(y, x), 1.0f / 162);
    EXPECT_NEAR(found[0].height_m, kBeaconMiddle_m, 0.02f);
    EXPECT_TRUE(has_plausible_height(found[0]));
  }
}

TEST(LandmarkDetector, FindsWhereAGoalIsFree) {
  // A goal 2 m ahead, 0.6 m wide and 0.3 m high, with a goalie of 0.2 m before its right half.
  const HeadAngles head{-0.02f, 0, 0};
  const World world = cast(head, [&](const BodyRay& ray) -> std::optional<Colour> {
    const float t = (2 - ray.origin_m.x) / ray.direction.x;
    const float y = t * ray.direction.y,
                z = ray.origin_m.z + t * ray.direction.z + kNeck.body_height_m;
    if (std::abs(y) > 0.3f || z < 0 || z > 0.3f || (y > -0.2f && y < -0.02f && z < 0.2f))
      return std::nullopt;
    return Colour::skyblue;
  });
  const auto found = find_landmarks(
      world.mask(), [&](float) { return head; }, kCamera, kNeck);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].kind, LandmarkKind::goal_skyblue);
  EXPECT_NEAR(found[0].bearing_rad, 0, 0.01f);
  EXPECT_NEAR(found[0].free_offset_rad, 0.14f / (2 - 0.19f), 0.015f);  // From -0.02 m to 0.3 m.
}

TEST(LandmarkDetector, TellsABeaconFromColoursThatLieNearTheGround) {
  // Sky-blue over pink between 0 and 20 cm: what a uniform before the goal looks like.
  const HeadAngles head{-0.05f, 0, 0};
  const World world = cast(head, [&](const BodyRay& ray) -> std::optional<Colour> {
    const auto height = height_on_post(ray, 1.5f, 0);
    if (!height || *height < 0 || *height > 0.2f) return std::nullopt;
    return *height < 0.1f ? Colour::pink : Colour::skyblue;
  });
  const auto found = find_landmarks(
      world.mask(), [&](float) { return head; }, kCamera, kNeck);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].height_m, 0.1f, 0.02f);
  EXPECT_FALSE(has_plausible_height(found[0]));
}

}  // namespace
}  // namespace seam::sdk
