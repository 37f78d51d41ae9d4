#include "tools/dm_env_rpc/robot_interface.h"

#include <gtest/gtest.h>

#include "tools/dm_env_rpc/request_error.h"

namespace seam::tools::dm {
namespace {

using Actions = google::protobuf::Map<uint64_t, rpc::Tensor>;

RobotSpec robot_with_table() {
  RobotSpec robot;
  robot.id = "r0";
  robot.camera.width_px = 20;
  robot.camera.height_px = 10;
  robot.camera.colour_table_yaml = "the text of a table";
  for (JointLimits& limits : robot.body.joints) limits.min_rad = -1, limits.max_rad = 1;
  return robot;
}

class DmRobot : public ::testing::Test {
 protected:
  DmRobot() : interface_(Scenario(), robot_with_table()) {}

  static uint64_t number_in(const google::protobuf::Map<uint64_t, rpc::TensorSpec>& specs,
                            const std::string& name) {
    for (const auto& [number, spec] : specs)
      if (spec.name() == name) return number;
    ADD_FAILURE() << "no " << name;
    return 0;
  }
  uint64_t action(const std::string& name) const {
    return number_in(interface_.specs().actions(), name);
  }
  rpc::Tensor observed(const Sensed& sensed, const std::string& name) const {
    const uint64_t number = number_in(interface_.specs().observations(), name);
    RobotInterface::Numbers asked;
    asked.Add(number);
    interface_.check_observations(asked);
    Actions observations;
    interface_.observe(sensed, asked, observations);
    return observations.at(number);
  }
  grpc::StatusCode refusal(const Actions& actions) const {
    v1::WalkCommand walk;
    try {
      interface_.decide(actions, walk);
    } catch (const RequestError& error) {
      EXPECT_EQ(walk.vx_m_s(), 0);
      return error.code();
    }
    return grpc::StatusCode::OK;
  }

  const RobotInterface interface_;
};

TEST_F(DmRobot, ActionsBecomeOrders) {
  Actions actions;
  actions[action("joints.pan_rad")] = tensor_of(0.5);
  actions[action("walk.vx_m_s")] = tensor_of(0.05);
  v1::WalkCommand walk;
  walk.set_omega_rad_s(0.25);
  const v1::Decision decision = interface_.decide(actions, walk);
  ASSERT_EQ(decision.joints_size(), 1);
  ASSERT_EQ(decision.joints(0).targets_size(), 1);
  EXPECT_EQ(decision.joints(0).targets(0).angle_rad(), 0.5);
  // What was ordered before goes on.
  EXPECT_EQ(decision.walk().vx_m_s(), 0.05);
  EXPECT_EQ(decision.walk().omega_rad_s(), 0.25);
  EXPECT_EQ(walk.vx_m_s(), 0.05);
  EXPECT_FALSE(interface_.decide({}, walk).has_walk());
}

TEST_F(DmRobot, WhatIsNoActionIsRefusedAsAWhole) {
  Actions good;
  good[action("walk.vx_m_s")] = tensor_of(0.05);
  for (const auto& [number, tensor, code] :
       {std::tuple(uint64_t{4711}, tensor_of(0.0), grpc::StatusCode::NOT_FOUND),
        std::tuple(action("joints.pan_rad"), tensor_of(1.5), grpc::StatusCode::OUT_OF_RANGE),
        std::tuple(action("joints.pan_rad"), tensor_of("left"), grpc::StatusCode::INVALID_ARGUMENT),
        std::tuple(action("kick"), tensor_of(1.0), grpc::StatusCode::INVALID_ARGUMENT)}) {
    Actions actions = good;
    actions[number] = tensor;
    EXPECT_EQ(refusal(actions), code);
  }
  RobotInterface::Numbers asked;
  asked.Add(4711);
  EXPECT_THROW(interface_.check_observations(asked), RequestError);
}

TEST_F(DmRobot, ColoursAreSeenOfARobotWithATable) {
  // Before the first frame nothing was detected; a detection stands for two by two pixels.
  const rpc::Tensor none = observed({}, "camera.colours");
  EXPECT_EQ((std::vector<int>(none.shape().begin(), none.shape().end())), (std::vector{5, 8}));
  EXPECT_EQ(none.uint8s().array(), std::string(40, '\0'));
  Sensed sensed;
  std::string bits(40, '\0');
  bits[9] = '\x02';
  sensed.frame.emplace().set_colours(bits);
  EXPECT_EQ(observed(sensed, "camera.colours").uint8s().array(), bits);
  RobotInterface::Numbers asked;
  asked.Add(number_in(interface_.specs().observations(), "camera.colours"));
  EXPECT_TRUE(interface_.asks_for_frames(asked));
  RobotSpec plain = robot_with_table();
  plain.camera.colour_table_yaml.clear();
  const RobotInterface without(Scenario(), plain);
  EXPECT_EQ(without.specs().observations_size(), interface_.specs().observations_size() - 1);
}

}  // namespace
}  // namespace seam::tools::dm
