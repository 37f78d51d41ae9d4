// What a robot senses besides its camera: each sensor samples by its own clock, with its own
// noise, and its readings reach the behaviour after its own latency.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "sim_core/base/pose.h"
#include "sim_core/base/random.h"
#include "sim_core/base/time.h"
#include "sim_core/body/inertial_reading.h"
#include "sim_core/body/joints.h"
#include "sim_core/body/state.h"
#include "sim_core/scenario/scenario.h"

namespace seam {

class RobotPartsFactory;

struct JointReading {
  SimTime time;
  JointAngles rad{};  // Encoders, in the order of joints.h.
};

// What a robot may get at an instant. Times say when each value was measured.
struct RobotSensors {
  SimTime time;  // When this was asked for.

  std::optional<int> tree_joints;       // Of a robot that is no ERS-210: how many it has.
  JointReading joints;                  // The newest delivered.
  std::vector<JointReading> joint_log;  // All delivered since the time that was asked for.

  SimTime odometry_time;
  Pose2 odometry;  // Dead reckoning of the legs' commands, in the frame of the first pose.

  SimTime acceleration_time;
  Vec3 acceleration_m_s2{0.0};  // Specific force in the body's frame: +9.81 in z at rest.

  SimTime angular_velocity_time;
  std::optional<Vec3> angular_velocity_rad_s;  // In the body's frame; of a robot with a gyroscope.

  SimTime paws_time;
  std::array<bool, kLegs> paw_contact{};
};

// What the sensors of a robot measure at an instant, free of noise.
struct SensorTruth {
  JointAngles encoders_rad{};
  Pose2 dead_reckoning;
  BodyMotion motion_B;
  std::array<bool, kLegs> paw_contact{};
};

// The readings of one robot's sensors.
class SensorSuite {
 public:
  // Joint readings are kept until `memory` after their delivery.
  // `stream` is the robot's.
  SensorSuite(const RobotSpec& robot, SimDuration memory, const RandomStream& stream,
              const RobotPartsFactory& parts);

  // Instants after `after`, up to and including `until`, at which some sensor samples, ascending.
  std::vector<SimTime> sampling_times(SimTime after, SimTime until) const;
  // The truth at one of these instants.
  void sample(SimTime time, const SensorTruth& truth);
  // What has arrived by `time`; `joint_log` holds what arrived after `since`.
  RobotSensors read(SimTime time, SimTime since) const;
  void visit(StateVisitor& visitor);

 private:
  struct Triad {
    SimTime time;
    Vec3 value{0.0};
  };
  // An accelerometer or a gyroscope.
  class InertialSensor {
   public:
    // Of its stream of noise and of its state.
    struct Names {
      const char *sensor, *readings, *time, *x, *y, *z, *effects_state;
    };
    static const Names kAccelerometer, kGyroscope;

    InertialSensor(const SensorSpec& spec, const Names& names, Vec3 BodyMotion::*measured,
                   std::shared_ptr<const InertialReading> effects);

    void sample(SimTime time, const BodyMotion& motion, const RandomStream& noise_of_all);
    const Triad& newest_at(SimTime time) const;
    void forget_old(SimTime time);
    const SensorSpec& spec() const { return *spec_; }
    void visit_readings(StateVisitor& visitor);
    void visit_effects(StateVisitor& visitor);

   private:
    const SensorSpec* spec_;
    const Names* names_;
    Vec3 BodyMotion::*measured_;  // What of the motion it is there for.
    std::shared_ptr<const InertialReading> effects_;
    std::vector<double> effects_state_;
    std::vector<Triad> readings_;  // Ascending, as the others below.
  };
  struct Odometry {
    SimTime time;
    Pose2 value;
    void visit(StateVisitor& visitor);
  };
  struct Paws {
    SimTime time;
    std::array<bool, kLegs> value{};
    void visit(StateVisitor& visitor);
  };
  void forget_old(SimTime time);

  const SensorsSpec* spec_;
  std::optional<int> tree_joints_;
  // How many angles of a reading are state. No fewer than an ERS-210's, as older logs have it.
  size_t kept_joints_ = kJoints;
  SimDuration memory_;
  RandomStream stream_;
  // Readings still needed: those not delivered yet, and the newest delivered one. Ascending.
  std::vector<JointReading> joints_;
  std::vector<Odometry> odometry_;
  InertialSensor accelerometer_;
  std::optional<InertialSensor> gyroscope_;
  std::vector<Paws> paws_;
  Pose2 odometry_error_;  // What noise has added up to.
  Pose2 last_dead_reckoning_;
};

}  // namespace seam
