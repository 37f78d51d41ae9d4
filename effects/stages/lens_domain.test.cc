#include "effects/stages/lens_domain.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim_core/base/config.h"

namespace seam::effects {
namespace {

constexpr int kWidth_px = 640, kHeight_px = 480;

Model lens_model(const std::string& lens, const std::string& centre = "cx_px: 320, cy_px: 240") {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects: {pinhole: {fx_px: 530, fy_px: 530, " +
                                centre + "}" + lens + "}\n",
                            "seen"));
}

std::optional<LensFault> fault_of(const std::string& lens, int directions = 48) {
  return lens_fault(Projection(lens_model(lens), kWidth_px, kHeight_px), directions);
}

std::vector<std::string> doubts_of(const Model& model) {
  return lens_doubts(model, kWidth_px, kHeight_px);
}

TEST(LensFault, StandsWhereTheRadiusNoLongerGrows) {
  // r + k1 r^3 grows up to r = 1 / sqrt(-3 k1), of which the image is at 2/3 of that.
  const double k1 = -0.6, r = 1 / std::sqrt(-3 * k1);
  const auto fault = fault_of(", radial_polynomial: {k1: -0.6}");
  ASSERT_TRUE(fault);
  EXPECT_FALSE(fault->pole);
  EXPECT_NEAR(fault->radius_px, 530 * 2 * r / 3, 0.01);
  EXPECT_NEAR(fault->angle_rad, std::atan(r), 1e-3);
  // The image ends before the fold: 530 x 2/3 x 1.29 = 456 px, and the corner is 400 px away.
  EXPECT_FALSE(fault_of(", radial_polynomial: {k1: -0.2}"));
}

TEST(LensFault, StandsAtAPole) {
  // (1 - 6.9 r^4) / (1 - 7 r^4) has its pole at r = 7^(-1/4).
  const double r = std::pow(7.0, -0.25);
  const auto fault = fault_of(", rational_lens: {k2: -6.9, k5: -7.0}");
  ASSERT_TRUE(fault);
  EXPECT_TRUE(fault->pole);
  EXPECT_NEAR(fault->angle_rad, std::atan(r), 0.02);
  EXPECT_TRUE(fault_of(", rational_lens: {k1: -2.75, k2: 0.02, k3: 0.01, k4: -2.7, k5: 0.02}", 8));
  EXPECT_FALSE(fault_of(", rational_lens: {k1: 0.4, k2: 0.02, k4: 0.7, k5: 0.1}"));
}

TEST(LensFault, OfOneFormCountsForEach) {
  for (const char* lens :
       {"", ", radial_distortion: {kappa: -0.2}", ", radial_polynomial: {k1: 0.4, k2: 0.1}",
        ", tangential_distortion: {p1: 0.003, p2: -0.002}"}) {
    EXPECT_FALSE(fault_of(lens)) << lens;
    EXPECT_THAT(doubts_of(lens_model(lens)), testing::IsEmpty()) << lens;
  }
  // A fisheye of 200 px focal length sees rays behind the camera in the corners.
  const Model wide = Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects: {pinhole: {fx_px: 200, fy_px: 200, cx_px: 319.5, cy_px: "
      "239.5}, fisheye: {k1: 0.01, k2: 0, k3: 0, k4: 0}}\n",
      "wide"));
  EXPECT_FALSE(lens_fault(Projection(wide, kWidth_px, kHeight_px), 48));
}

TEST(LensFault, APoleIsNoFold) {
  const auto pole_of = [](const std::string& lens) {
    return lens_pole(lens_model(lens), kWidth_px, kHeight_px);
  };
  EXPECT_THAT(pole_of(", rational_lens: {k4: -7}"), testing::HasSubstr("has a pole"));
  EXPECT_EQ(pole_of(", radial_polynomial: {k1: -0.6}"), "");
  EXPECT_EQ(pole_of(""), "");
}

TEST(LensDoubts, SayWhereAndWhat) {
  EXPECT_THAT(doubts_of(lens_model(", radial_polynomial: {k1: -0.6}")),
              testing::ElementsAre(testing::HasSubstr("folds the image over")));
  EXPECT_THAT(doubts_of(lens_model(", rational_lens: {k2: -6.9, k5: -7.0}")),
              testing::ElementsAre(testing::HasSubstr("has a pole")));
  // r (1 - 0.35 r^2 - 0.6 r^4 + 0.9 r^6) grows everywhere: least at r^2 = 0.443, by 0.494.
  EXPECT_THAT(doubts_of(lens_model(", radial_polynomial: {k1: -0.35, k2: -0.6, k3: 0.9}")),
              testing::ElementsAre(testing::AllOf(testing::HasSubstr("nearly folds"),
                                                  testing::HasSubstr("at 50 % of its rate"))));
  EXPECT_THAT(doubts_of(lens_model("", "cx_px: 700, cy_px: 240")),
              testing::ElementsAre(testing::HasSubstr("outside the image of 640 x 480")));
}

}  // namespace
}  // namespace seam::effects
