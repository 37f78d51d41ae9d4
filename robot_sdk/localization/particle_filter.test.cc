#include "robot_sdk/localization/particle_filter.h"

#include <gtest/gtest.h>

#include <cmath>

namespace seam::sdk {
namespace {

std::vector<LandmarkSighting> sightings_from(const FieldPose& pose, float bearing_error = 0) {
  std::vector<LandmarkSighting> all;
  for (const LandmarkPosition& landmark : standard_landmarks()) {
    const float dx = landmark.x_m - pose.x_m, dy = landmark.y_m - pose.y_m;
    const float bearing = std::remainder(std::atan2(dy, dx) - pose.theta_rad, 6.2831853f);
    if (std::abs(bearing) > 1.8f) continue;  // The head turns so far.
    all.push_back({.kind = landmark.kind,
                   .bearing_rad = bearing + bearing_error,
                   .range_m = std::sqrt(dx * dx + dy * dy),
                   .bearing_sigma_rad = 0.005f,
                   .range_sigma_m = 0.03f});
  }
  return all;
}

TEST(ParticleFilter, FindsThePoseFromExactSightings) {
  for (const FieldPose truth :
       {FieldPose{1.0f, 0.5f, 0.78f}, FieldPose{-1.5f, -1.0f, -2.3f}, FieldPose{0, 0, 2.3f}}) {
    ParticleFilter filter({.particles = 2000, .seed = 7}, standard_landmarks());
    const auto sightings = sightings_from(truth);
    for (int i = 0; i < 60; ++i) {
      filter.move(0, 0, 0);
      filter.observe({sightings[i % sightings.size()]});
    }
    const PoseEstimate estimate = filter.estimate();
    EXPECT_NEAR(estimate.mean.x_m, truth.x_m, 0.12f);
    EXPECT_NEAR(estimate.mean.y_m, truth.y_m, 0.12f);
    EXPECT_NEAR(std::remainder(estimate.mean.theta_rad - truth.theta_rad, 6.2831853f), 0, 0.08f);
    EXPECT_LT(estimate.low.x_m, truth.x_m);
    EXPECT_GT(estimate.high.x_m, truth.x_m);
  }
}

TEST(ParticleFilter, FollowsMotionAndIsTheSameEveryTime) {
  const auto run = [] {
    ParticleFilter filter({.particles = 1000, .seed = 3}, standard_landmarks());
    FieldPose truth{-1.0f, 0, 0};
    for (int i = 0; i < 150; ++i) {
      truth.x_m += 0.01f;
      filter.move(0.01f, 0, 0);
      const auto sightings = sightings_from(truth);
      filter.observe({sightings[i % sightings.size()]});
    }
    return filter.estimate();
  };
  const PoseEstimate first = run(), second = run();
  EXPECT_NEAR(first.mean.x_m, 0.5f, 0.12f);
  EXPECT_EQ(first.mean.x_m, second.mean.x_m);
  EXPECT_EQ(first.mean.theta_rad, second.mean.theta_rad);
}

TEST(ParticleFilter, RecoversWhenCarriedAway) {
  ParticleFilter filter({.particles = 2000, .seed = 5}, standard_landmarks());
  const auto settle = [&](const FieldPose& truth, int steps) {
    const auto sightings = sightings_from(truth);
    for (int i = 0; i < steps; ++i) {
      filter.move(0, 0, 0);
      filter.observe({sightings[i % sightings.size()]});
    }
  };
  settle({1.2f, 0.8f, 0.5f}, 60);
  settle({-1.2f, -0.6f, 2.6f}, 300);
  EXPECT_NEAR(filter.estimate().mean.x_m, -1.2f, 0.2f);
  EXPECT_NEAR(filter.estimate().mean.y_m, -0.6f, 0.2f);
}

const ParticleFilterOptions kAugmented{.particles = 400,
                                       .seed = 5,
                                       .range_outlier_probability = 0.2f,
                                       .slow_rate = 0.02f,
                                       .fast_rate = 0.2f,
                                       .blocked_share = 0.2f};

// Sees two landmarks in turn, as a robot does that looks from one to the other.
void look(ParticleFilter& filter, const FieldPose& truth, int steps) {
  const auto sightings = sightings_from(truth);
  for (int i = 0; i < steps; ++i) {
    filter.move(0, 0, 0);
    filter.observe({sightings[i % 2]});
  }
}

TEST(AugmentedParticleFilter, RecoversWithinHalfASecondWhenCarriedAway) {
  ParticleFilter filter(kAugmented, standard_landmarks());
  look(filter, {1.2f, 0.8f, 0.5f}, 100);
  EXPECT_NEAR(filter.densest().mean.x_m, 1.2f, 0.15f);
  look(filter, {-1.2f, -0.6f, 2.6f}, 13);
  const FieldPose found = filter.densest().mean;
  EXPECT_NEAR(found.x_m, -1.2f, 0.2f);
  EXPECT_NEAR(found.y_m, -0.6f, 0.2f);
  EXPECT_NEAR(std::remainder(found.theta_rad - 2.6f, 6.2831853f), 0, 0.15f);
}

TEST(AugmentedParticleFilter, StaysWhereItIsWhileAFalseLandmarkIsSeenAmongTrueOnes) {
  ParticleFilter filter(kAugmented, standard_landmarks());
  const FieldPose truth{0.5f, -0.3f, 0.2f};
  look(filter, truth, 100);
  const auto sightings = sightings_from(truth);
  for (int i = 0; i < 60; ++i) {
    filter.move(0, 0, 0);
    LandmarkSighting seen = sightings[0];
    if (i % 3 == 0)
      seen = {.kind = LandmarkKind::beacon_yellow_pink_low,
              .bearing_rad = 0.3f,
              .range_m = 1.1f,
              .bearing_sigma_rad = 0.005f,
              .range_sigma_m = 0.05f};
    filter.observe({seen});
    EXPECT_LT(std::abs(filter.densest().mean.x_m - truth.x_m), 0.3f) << i;
    EXPECT_LT(std::abs(filter.densest().mean.y_m - truth.y_m), 0.3f) << i;
  }
}

TEST(AugmentedParticleFilter, AWrongRangeWithARightBearingMovesNothing) {
  ParticleFilter filter(kAugmented, standard_landmarks());
  const FieldPose truth{0.5f, -0.3f, 0.2f};
  look(filter, truth, 100);
  auto seen = sightings_from(truth)[0];
  seen.range_m *= 1.4f;  // A band half hidden.
  for (int i = 0; i < 30; ++i) {
    filter.move(0, 0, 0);
    filter.observe({seen});
  }
  EXPECT_NEAR(filter.densest().mean.x_m, truth.x_m, 0.3f);
  EXPECT_NEAR(filter.densest().mean.y_m, truth.y_m, 0.3f);
}

TEST(ParticleFilter, SaysThePlaceOfMostSamplesRatherThanOneBetweenTwo) {
  ParticleFilter filter({.particles = 400, .seed = 9}, standard_landmarks());
  filter.place({{-1, 0.5f, 0}}, 1, 0.05f, 0.05f);
  filter.place({{1, -0.5f, 1}}, 0.4f, 0.05f, 0.05f);
  EXPECT_NEAR(filter.estimate().mean.x_m, -0.2f, 0.02f);
  EXPECT_NEAR(filter.densest().mean.x_m, -1, 0.02f);
  EXPECT_NEAR(filter.densest().mean.y_m, 0.5f, 0.02f);
}

TEST(ParticleFilter, SomeSamplesStayWhenTheRobotIsHeldUp) {
  ParticleFilter filter({.particles = 400, .seed = 9, .blocked_share = 0.2f}, standard_landmarks());
  filter.place({{0, 0, 0}}, 1, 0, 0);
  for (int i = 0; i < 50; ++i) filter.move(0.01f, 0, 0);
  float least = 1, most = 0;
  for (const FieldPose& pose : filter.samples())
    least = std::min(least, pose.x_m), most = std::max(most, pose.x_m);
  EXPECT_LT(least, 0.35f);
  EXPECT_GT(most, 0.45f);
}

}  // namespace
}  // namespace seam::sdk
