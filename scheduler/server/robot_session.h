// What a robot's client and the server say to each other, whatever carries it: wire messages become
// calls of the hub; nothing that a client sends goes anywhere else.
#pragma once

#include <grpcpp/support/status.h>

#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "scheduler/clients/client_hub.h"
#include "scheduler/clients/token_tries.h"
#include "scheduler/server/watch.h"
#include "seam/v1/simulation.pb.h"

namespace seam::scheduler {

struct FieldError;

// What all sessions of a run have in common.
struct SessionParts {
  const Scenario& scenario;
  ClientHub& hub;
  TokenTries& tries;
  std::string supervisor_token;
  WatchSource* watches = nullptr;  // None: nobody may watch.
};

class RobotSession : public ClientConnection {
 public:
  // `peer`: who is at the other end, by whom wrong tokens are counted.
  RobotSession(const SessionParts& parts, std::string peer)
      : parts_(parts), peer_(std::move(peer)) {}

  // ---- ClientConnection ----
  void send(std::shared_ptr<const Observation> observation, const std::vector<int>& asked) override;
  void say_goodbye(SimTime time, const std::string& reason) override;
  void drop(const std::string& reason) override;

 protected:
  // ---- From what carries the messages, one at a time ----
  void take_message(const v1::ClientMessage& message);
  // In place of a message of so many bytes, more than it may have.
  void take_too_long(size_t bytes);
  // May be called more than once.
  void client_left();
  bool has_greeted();

  // ---- To it, from any thread; neither blocks ----
  virtual void say(v1::ServerMessage message) = 0;
  // After what was said.
  virtual void hang_up(const grpc::Status& status) = 0;
  virtual std::shared_ptr<ClientConnection> self() = 0;

 private:
  void take_hello(const v1::ClientMessage& message);
  // False: it was refused.
  bool take_watch(const v1::Hello& hello);
  void tell_watched(SimTime time, const std::vector<int>& asked);
  void take_decision(const v1::ClientMessage& message);
  // `bad`: why it is refused.
  void answer(uint64_t sequence, Decision decision, const FieldError* bad,
              const DecisionDoubts& doubts);
  void refuse(uint64_t sequence, const FieldError& error, bool decision_owed);

  const SessionParts& parts_;
  std::string peer_;
  std::mutex mutex_;
  int robot_ = -1;  // Once the hello was accepted.
  bool left_ = false;
  uint64_t sent_ = 0;             // The newest observation's number.
  std::shared_ptr<Watch> watch_;  // Set before the robot is known; none: nothing is watched.
};

}  // namespace seam::scheduler
