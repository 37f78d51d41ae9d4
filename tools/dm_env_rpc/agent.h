// One stream of dm_env_rpc: its requests, answered in order, and what it has joined.
#pragma once

#include <string>

#include "scheduler/clients/token_tries.h"
#include "tools/dm_env_rpc/properties.h"

namespace seam::tools::dm {

class Agent {
 public:
  // `peer`: whose tries at tokens count together. The parts outlive it.
  Agent(Worlds& worlds, scheduler::TokenTries& tries, std::string peer, Cancelled cancelled)
      : worlds_(worlds), tries_(tries), peer_(std::move(peer)), cancelled_(std::move(cancelled)) {}
  ~Agent();  // Leaves its world.
  Agent(const Agent&) = delete;
  Agent& operator=(const Agent&) = delete;

  // What fails is answered by an error, and has changed nothing.
  rpc::EnvironmentResponse answer(const rpc::EnvironmentRequest& request);

 private:
  using Settings = google::protobuf::Map<std::string, rpc::Tensor>;
  void take(const rpc::EnvironmentRequest& request, rpc::EnvironmentResponse& response);
  void create(const rpc::CreateWorldRequest& request, rpc::CreateWorldResponse& response);
  void join(const rpc::JoinWorldRequest& request, rpc::JoinWorldResponse& response);
  void reset(const rpc::ResetRequest& request, rpc::ResetResponse& response);
  void reset_world(const rpc::ResetWorldRequest& request);
  void destroy(const rpc::DestroyWorldRequest& request);
  void leave();
  void extension(const google::protobuf::Any& request, google::protobuf::Any& response);
  void check_token(const RobotInterface& robot, const std::string& token) const;
  // Throws RequestError unless a world is joined; `what` needs it.
  World& joined(const char* what) const;

  Worlds& worlds_;
  scheduler::TokenTries& tries_;
  const std::string peer_;
  const Cancelled cancelled_;
  Seat seat_;
};

}  // namespace seam::tools::dm
