// A world of dm_env_rpc: places for the robots that are driven, and the run of the sequence that is
// going on. A sequence begins when all places are taken and all agents step; it ends with the run,
// or when no agent plays any more.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tools/dm_env_rpc/robot_interface.h"
#include "tools/dm_env_rpc/run.h"

namespace seam::tools::dm {

// Whether whoever waits for an answer is gone.
using Cancelled = std::function<bool()>;

class World {
 public:
  // The robots outlive it. `seed` is the first sequence's; each further one has the next.
  World(std::string name, const std::vector<RobotInterface>& robots, const RunCommand& command,
        int64_t seed);
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  const std::string& name() const { return name_; }

  // ---- Of agents; each place belongs to one stream, whose calls come one after the other ----

  // The robot's place; no name: the first that is free. Throws RequestError.
  size_t join(const std::string& robot);
  void leave(size_t place);
  const RobotInterface& robot_of(size_t place) const { return *places_[place].robot; }
  rpc::StepResponse step(size_t place, const rpc::StepRequest& request, const Cancelled& cancelled);
  // Ends the agent's sequence.
  void reset(size_t place);

  // ---- Of anybody ----

  // Ends the sequence of all agents, and waits until they have learnt it. `caller`: the place of
  // whoever asks, if any.
  void reset_all(std::optional<size_t> caller, const Cancelled& cancelled);
  std::vector<std::string> joined() const;  // Robots whose places are taken.
  void seed_next(int64_t seed);
  int64_t next_seed() const;
  int64_t sequences() const;  // Begun so far.
  std::string log_of(int64_t sequence) const;
  // The server ends: nobody waits any more.
  void close();

 private:
  enum class State { vacant, idle, playing };
  struct Place {
    const RobotInterface* robot = nullptr;
    State state = State::vacant;
    bool ready = false;        // Waits for the next sequence.
    bool interrupted = false;  // Somebody has reset the world, which its agent is to learn.
    // While it plays its agent's, then its stand-in's.
    std::unique_ptr<RobotLine> line;
    Sensed sensed;
    v1::WalkCommand walk;  // As last ordered.
    bool frames_on = false;
    // Answers for a robot whose agent plays no more, while others do.
    std::jthread stand_in;
  };

  void begin(Place& place, const Cancelled& cancelled);
  bool can_start() const;
  void start(std::unique_lock<std::mutex>& lock);
  void give_up_waiting(Place& place, const std::string& why, grpc::StatusCode code);
  void answer(Place& place, const rpc::StepRequest& request);
  // False at the end of the run.
  bool sense(Place& place);
  bool take_interruption(Place& place);
  // The agent's sequence is over. `run_over`: the run has said so. Throws RequestError where the
  // run ended otherwise.
  void stop_playing(Place& place, bool run_over);
  void stand_in(Place& place);
  bool anybody_plays() const;

  const std::string name_;
  const RunCommand& command_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Place> places_;
  std::unique_ptr<Run> run_;
  bool starting_ = false, closed_ = false;
  std::string failure_;  // Of the last start.
  int64_t next_seed_, sequences_ = 0;
};

}  // namespace seam::tools::dm
