#include "open_r/robot/camera_settings.h"

#include <gtest/gtest.h>

namespace seam::open_r {
namespace {

using Pixel = std::array<byte, 3>;

TEST(CameraSettings, DefaultLeavesThePicture) {
  CameraSettings settings;
  EXPECT_TRUE(settings.are_default());
  EXPECT_TRUE(settings.set(oprmreqCAM_SET_SHUTTER_SPEED, ocamparamSHUTTER_MID));
  EXPECT_TRUE(settings.set(oprmreqCAM_SET_GAIN, ocamparamGAIN_MID));
  EXPECT_TRUE(settings.set(oprmreqCAM_SET_WHITE_BALANCE, ocamparamWB_FL_MODE));
  EXPECT_TRUE(settings.are_default());
}

TEST(CameraSettings, ShutterAndGainScaleAPixel) {
  CameraSettings settings;
  settings.set(oprmreqCAM_SET_SHUTTER_SPEED, ocamparamSHUTTER_SLOW);
  EXPECT_EQ(settings.applied({60, 138, 128}), (Pixel{120, 148, 128}));
  settings.set(oprmreqCAM_SET_SHUTTER_SPEED, ocamparamSHUTTER_FAST);
  EXPECT_EQ(settings.applied({60, 138, 128}), (Pixel{30, 133, 128}));
  // 1/200 s and 6 dB more are nearly the default.
  settings.set(oprmreqCAM_SET_GAIN, ocamparamGAIN_HIGH);
  EXPECT_EQ(settings.applied({60, 138, 128}), (Pixel{60, 138, 128}));
  settings.set(oprmreqCAM_SET_GAIN, ocamparamGAIN_LOW);
  EXPECT_EQ(settings.applied({200, 128, 128}), (Pixel{50, 128, 128}));
}

// A camera that takes lamps for white sees daylight blue, and the other way round.
TEST(CameraSettings, WhiteBalanceTurnsGreyIntoAColour) {
  CameraSettings settings;
  settings.set(oprmreqCAM_SET_WHITE_BALANCE, ocamparamWB_INDOOR_MODE);
  const Pixel indoor = settings.applied({100, 128, 128});
  EXPECT_LT(indoor[1], 118);
  EXPECT_GT(indoor[2], 138);
  settings.set(oprmreqCAM_SET_WHITE_BALANCE, ocamparamWB_OUTDOOR_MODE);
  const Pixel outdoor = settings.applied({100, 128, 128});
  EXPECT_GT(outdoor[1], 128);
  EXPECT_LT(outdoor[2], 128);
}

TEST(CameraSettings, OthersAreRefused) {
  CameraSettings settings;
  EXPECT_FALSE(settings.set(oprmreqCAM_SET_GAIN, 4));
  EXPECT_FALSE(settings.set(oprmreqMIC_OMNI, 1));
  EXPECT_TRUE(settings.are_default());
}

}  // namespace
}  // namespace seam::open_r
