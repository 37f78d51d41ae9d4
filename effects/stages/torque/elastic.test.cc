// An elastic joint against small steps of its equation, in servo logs and in the simulator's
// robots.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "effects/stages/robots/robot_parts.h"
#include "effects/stages/servo.h"

namespace seam::effects {
namespace {

Model elastic_model(const std::string& servo) {
  return Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects: {" + servo +
          fmt::format("elastic_joint: {{period_s: {:.17g}, damping: 0.15}}}}\n", 1.0 / 7),
      "test"));
}

// The load behind a drive that goes to 1 rad at this speed, then stands.
double by_small_steps(double radps, double at_s) {
  const double omega = 14 * M_PI, damping = 0.15, h = 1e-5;
  double q = 0, w = 0;
  for (double t = 0; t < at_s - 0.5 * h; t += h) {
    const double middle = t + 0.5 * h, drive = std::min(1.0, radps * middle);
    const double rate = radps * middle < 1 ? radps : 0;
    const double a = omega * omega * (drive - q - 0.5 * h * w) + 2 * damping * omega * (rate - w);
    q += h * (w + 0.5 * h * a);
    w += h * a;
  }
  return q;
}

TEST(ElasticJoint, FollowsADriveThatRampsAndStops) {
  Servo servo(servo_of(elastic_model("speed_limit: {rad_per_s: 4}, ")), 0, 0);
  servo.command(0, 1);
  for (const double t : {0.013, 0.1, 0.24, 0.3, 0.52}) {
    servo.advance_to(t);
    EXPECT_NEAR(servo.joint_rad(), by_small_steps(4, t), 2e-4) << t;
  }
}

// However the time is cut, the joint moves alike.
TEST(ElasticJoint, RowsDoNotChangeTheMotion) {
  const ServoModel model = servo_of(elastic_model("servo_lag: {tau_s: 0.03}, "));
  Servo coarse(model, 0, 0), fine(model, 0, 0);
  for (Servo* servo : {&coarse, &fine}) servo->command(0, 0.8), servo->command(0.2, -0.1);
  for (int k = 1; k <= 400; ++k) fine.advance_to(0.001 * k);
  coarse.advance_to(0.4);
  EXPECT_NEAR(coarse.joint_rad(), fine.joint_rad(), 4e-4);  // Of a swing of 0.9 rad.
}

// Where no command acts any more, the drive stays and the load swings on.
TEST(ElasticJoint, SwingsOnWithoutTorque) {
  Servo servo(servo_of(elastic_model("")), 0, 0);
  servo.command(0, 1);
  servo.command(0.02, 1, /*enabled=*/false);
  servo.advance_to(0.07);
  const double early = servo.joint_rad();
  servo.advance_to(2);
  EXPECT_GT(early, 1.1);
  EXPECT_NEAR(servo.joint_rad(), 1, 1e-3);
}

// A motor's load against small steps of all four equations at once, with a duty that saturates.
TEST(ElasticJoint, HangsOnAMotor) {
  Servo servo(servo_of(elastic_model(
                  "motor_servo: {stall_rad_per_s2: 200, back_emf_per_s: 10, gain: 0.5, max_duty: "
                  "0.4}, ")),
              0, 0);
  servo.command(0, 1.5);
  const double omega = 14 * M_PI, damping = 0.15, h = 1e-6;
  double m = 0, v = 0, q = 0, w = 0;
  int k = 0;
  for (const double t : {0.02, 0.1, 0.23, 0.6}) {
    servo.advance_to(t);
    for (; k < std::lround(t / h); ++k) {
      const double duty = std::min(0.4, 0.5 * (1.5 - m));
      v += h * (200 * duty - 10 * v);
      w += h * (omega * omega * (m - q) + 2 * damping * omega * (v - w));
      m += h * v, q += h * w;
    }
    EXPECT_NEAR(servo.joint_rad(), q, 2e-5) << t;
  }
}

TEST(ElasticJoint, MovesTheSimulatorsJoints) {
  RobotSpec robot;
  robot.id = "red1";
  const ModelParts parts({{"red1", elastic_model("")}});
  const auto at = [](double s) { return SimTime::from_ns(static_cast<int64_t>(1e9 * s)); };
  const auto actuator = [&] {
    auto joint = parts.joint(robot, 0, 0, RandomStream{});
    joint->command(at(0), 1, 4);
    return joint;
  };
  const auto asked_once = actuator(), asked_often = actuator();
  for (int k = 0; k < 50; ++k) {
    asked_often->angle(at(0.0063 * k));
    asked_often->forget_before(at(0.006 * k));
  }
  for (const double t : {0.31, 0.4, 0.47}) {
    EXPECT_NEAR(asked_once->angle(at(t)), by_small_steps(4, t), 5e-4) << t;
    EXPECT_EQ(asked_once->angle(at(t)), asked_often->angle(at(t))) << t;
  }
}

}  // namespace
}  // namespace seam::effects
