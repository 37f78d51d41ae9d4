// The simulator's joints and legs as a model has them: the same solvers that predict measurements
// move the robots, each by its own model.
#pragma once

#include <map>
#include <string>

#include "effects/model.h"
#include "sim_core/world/world.h"

namespace seam::effects {

class ModelParts final : public RobotPartsFactory {
 public:
  // By robot id; a robot without one has joints with their speed limits and ideal walking.
  // Joints by robot id and joint name may have models of their own.
  using JointModels = std::map<std::pair<std::string, std::string>, Model>;
  explicit ModelParts(std::map<std::string, Model> models, JointModels joints = {})
      : models_(std::move(models)), joints_(std::move(joints)) {}

  // Of a joint's own model everything acts. Of a robot's, servo effects act on every joint; the
  // play of tilt and roll is that of `tilt_width_rad` and `roll_width_rad`, legs have none. The
  // encoder sits on the motor, before play and sag. A motor's gravity acts on the head's tilt and
  // roll; its setpoint goes to a command at the commanded speed.
  std::unique_ptr<JointActuator> joint(const RobotSpec& robot, int joint, double initial_rad,
                                       RandomStream noise) const override;
  std::unique_ptr<LocomotionModel> locomotion(const RobotSpec& robot,
                                              RandomStream noise) const override;
  // Effects of stage `inertial`; the robot is as warm as at their bias.
  std::shared_ptr<const InertialReading> accelerometer(const RobotSpec& robot,
                                                       RandomStream noise) const override;
  std::shared_ptr<const InertialReading> gyroscope(const RobotSpec& robot,
                                                   RandomStream noise) const override;

 private:
  std::shared_ptr<const InertialReading> inertial_sensor(const RobotSpec& robot, bool is_gyroscope,
                                                         SimDuration period,
                                                         const RandomStream& noise) const;

  std::map<std::string, Model> models_;
  JointModels joints_;
};

}  // namespace seam::effects
