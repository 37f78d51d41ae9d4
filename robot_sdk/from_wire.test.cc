#include "robot_sdk/from_wire.h"

#include <gtest/gtest.h>

#include "seam/v1/simulation.pb.h"

namespace seam::sdk {
namespace {

TEST(FromWire, AGyroscopesReadingIsThereWhereOneWasSent) {
  v1::Observation wire;
  wire.mutable_sensors()->mutable_acceleration_m_s2()->set_z(9.8);
  EXPECT_EQ(from_wire(wire).sensors.acceleration_m_s2.z, 9.8);
  EXPECT_FALSE(from_wire(wire).sensors.angular_velocity_rad_s);
  v1::Vector3& rate = *wire.mutable_sensors()->mutable_angular_velocity_rad_s();
  rate.set_x(0.25), rate.set_y(-0.5), rate.set_z(1.5);
  const auto read = from_wire(wire).sensors.angular_velocity_rad_s;
  ASSERT_TRUE(read);
  EXPECT_EQ(read->x, 0.25);
  EXPECT_EQ(read->y, -0.5);
  EXPECT_EQ(read->z, 1.5);
}

}  // namespace
}  // namespace seam::sdk
