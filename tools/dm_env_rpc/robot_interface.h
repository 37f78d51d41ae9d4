// One robot as an agent has it: which actions it takes and what it observes, by number. It knows
// what the robot's own stream brings (proto/seam/v1/simulation.proto), nothing else.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "seam/v1/simulation.pb.h"
#include "sim_core/scenario/scenario.h"
#include "tools/dm_env_rpc/tensors.h"

namespace seam::tools::dm {

// What the robot was last sent.
struct Sensed {
  v1::Observation now;
  std::optional<v1::Frame> frame;  // The newest.
};

class RobotInterface {
 public:
  RobotInterface(const Scenario& scenario, const RobotSpec& robot);

  const std::string& robot() const { return robot_; }
  const std::string& token() const { return token_; }  // Empty: anybody may join as this robot.
  const rpc::ActionObservationSpecs& specs() const { return specs_; }

  // The actions as orders; `walk` is the velocity that was last ordered. Throws RequestError, and
  // has changed nothing then.
  v1::Decision decide(const google::protobuf::Map<uint64_t, rpc::Tensor>& actions,
                      v1::WalkCommand& walk) const;

  using Numbers = google::protobuf::RepeatedField<uint64_t>;
  // Throws RequestError for one that there is not.
  void check_observations(const Numbers& asked) const;
  bool asks_for_frames(const Numbers& asked) const;
  void observe(const Sensed& sensed, const Numbers& asked,
               google::protobuf::Map<uint64_t, rpc::Tensor>& observations) const;

 private:
  using Give =
      std::function<void(const rpc::Tensor&, v1::Decision& decision, v1::WalkCommand& walk)>;
  using Look = std::function<void(const Sensed&, rpc::Tensor&)>;
  void add_action(rpc::TensorSpec spec, Give give);
  void add_observation(rpc::TensorSpec spec, Look look, bool of_camera = false);
  void add_joints(const RobotBody& body);
  void add_walk(const Gait& gait);
  void add_body_sensors(const RobotSpec& robot);
  void add_camera(const CameraSpec& camera);
  void add_radio(int64_t most_bytes);
  void add_game();

  struct Observed {
    Look look;
    bool of_camera = false;
  };
  std::string robot_, token_;
  rpc::ActionObservationSpecs specs_;
  std::map<uint64_t, Give> actions_;
  std::map<uint64_t, Observed> observations_;
};

}  // namespace seam::tools::dm
