#include "open_r/robot/primitives.h"

#include <gtest/gtest.h>

#include <set>

#include "open_r/files/fault.h"

namespace seam::open_r {
namespace {

const Primitive& at(const RobotDesign& design, std::string_view locator) {
  return design.primitives[static_cast<size_t>(find_primitive(design, locator))];
}

TEST(Designs, LocatorsArePlacesOfTheSensorVector) {
  const RobotDesign& design = robot_design("ERS-210");
  EXPECT_EQ(design.sensors.size(), 31u);
  EXPECT_EQ(find_primitive(design, "PRM:/r1/c1-Joint2:j1"), 0);
  EXPECT_EQ(find_primitive(design, "PRM:/a3-Sensor:a3"), 30);
  EXPECT_EQ(find_primitive(design, "PRM:/r1/c1-Joint2:11"), -1);
  const RobotDesign& other = robot_design("ERS-7");
  EXPECT_EQ(other.sensors.size(), 34u);
  EXPECT_GE(find_primitive(other, "PRM:/r1/c1-Joint2:11"), 0);
}

TEST(Designs, NoLocatorStandsTwice) {
  for (const char* name : {"ERS-210", "ERS-7"}) {
    std::set<std::string_view> locators;
    for (const Primitive& primitive : robot_design(name).primitives)
      EXPECT_TRUE(locators.insert(primitive.locator).second) << primitive.locator;
  }
}

// Gains as the robot's own software sets them; ranges in radians.
TEST(Designs, DefaultGainsAndRanges) {
  const RobotDesign& design = robot_design("ERS-210");
  const Primitive& tilt = at(design, "PRM:/r1/c1-Joint2:j1");
  EXPECT_EQ(tilt.gain.p, 0x0a);
  EXPECT_EQ(tilt.gain.i, 0x08);
  EXPECT_EQ(tilt.gain.d, 0x0c);
  const Primitive& pan = at(design, "PRM:/r1/c1/c2-Joint2:j2");
  EXPECT_EQ(pan.gain.p, 0x0d);
  EXPECT_EQ(pan.gain.d, 0x0b);
  EXPECT_NEAR(tilt.min_rad, -1.43117, 1e-5);
  EXPECT_NEAR(tilt.max_rad, 0.750492, 1e-6);
}

TEST(Designs, AnUnknownOneIsRefused) {
  EXPECT_THROW(robot_design("ERS-110"), Fault);
}

}  // namespace
}  // namespace seam::open_r
