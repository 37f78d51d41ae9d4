// The lockstep barrier with live clients: hands out observations, collects decisions, applies the
// policies for silent clients. Free of gRPC; a connection is known by interface.
#pragma once

#include <bitset>
#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "scheduler/clients/debug_budget.h"
#include "scheduler/clients/shared_core.h"
#include "scheduler/listen/wake.h"
#include "scheduler/loop/decision_source.h"
#include "scheduler/loop/run_control.h"
#include "sim_core/scenario/scenario.h"

namespace seam::scheduler {

// One client's stream as the hub sees it. Called from any thread; must not block, and must not
// call the hub back from inside a call.
class ClientConnection {
 public:
  virtual ~ClientConnection() = default;
  // `asked`: the numbers of all robots that are asked at this instant.
  virtual void send(std::shared_ptr<const Observation> observation,
                    const std::vector<int>& asked) = 0;
  // The run is over.
  virtual void say_goodbye(SimTime time, const std::string& reason) = 0;
  // Another connection with the robot's token took over.
  virtual void drop(const std::string& reason) = 0;

  // A socket from which the hub has decisions read on the loop's thread, which saves a turn the
  // waking of another; -1: the connection reads by itself.
  virtual int descriptor() const { return -1; }
  // The client's process, where it is on this machine; 0: not known.
  virtual pid_t process() const { return 0; }
  // What was sent is not written yet, for want of room in the socket.
  virtual bool wants_to_write() const { return false; }
  // Reads and writes what can be at once; may call the hub.
  virtual void serve() {}
};

struct HubRobot {
  std::string id;
  std::string token;
  SilencePolicy policy = SilencePolicy::wait;
  double limit_s = 1;           // Wall time after which freeze and abort act.
  double connect_limit_s = 60;  // The same before the client's first connection.
  bool expected = true;         // False: the clock does not wait until a client has come.
};

struct HubRobotStatus {
  std::string id;
  bool connected = false;
  bool frozen = false;
  bool owes_decision = false;
  std::string client;  // As the one that is connected calls itself.
};

enum class Attachment { accepted, unknown_robot, wrong_token, ended };
enum class Acceptance {
  accepted,
  stale,          // Of an earlier observation; nothing changes.
  duplicate,      // The pending observation was answered already, or none is pending.
  future,         // Of an observation that was never sent.
  logs_too_much,  // Counts as an empty decision: it logs more than the budget has left.
};

// What is to be recorded of a decision if it counts, at the time of its observation.
struct DecisionDoubts {
  std::string refused;                    // Why it counts as an empty one; empty: it was not.
  std::map<size_t, std::string> clamped;  // Targets beyond the range, by joint.
};

class ClientHub final : public LiveSource {
 public:
  ClientHub(std::vector<HubRobot> robots, RunControl& control);

  // ---- From connections ----

  struct Attached {
    Attachment result = Attachment::accepted;
    int robot = -1;
    uint64_t next_sequence = 1;
  };
  // A client said hello. The pending observation, if any, is sent once `activate` is called.
  // `client`: what it calls itself, for people.
  Attached attach(const std::string& robot, const std::string& token, const std::string& client,
                  std::shared_ptr<ClientConnection> connection);
  void activate(int robot, const ClientConnection& connection);
  void detach(int robot, const ClientConnection& connection);
  Acceptance answer(int robot, const ClientConnection& connection, uint64_t sequence,
                    Decision decision, const DecisionDoubts& doubts = {});
  // Something a client did was refused.
  void note_fault(int robot, const std::string& name, const std::string& detail);
  // A client came with a wrong token, or too soon after many: counted, reported once a second.
  void note_wrong_hello(int robot);
  // Nobody can answer for this robot any more (its process ended): policies act at once, and
  // `wait`, which would wait for ever, aborts.
  void give_up(const std::string& robot, const std::string& reason);
  // Acts with the next turn.
  void act(std::vector<SupervisorAction> actions);

  // ---- For anybody ----

  std::vector<HubRobotStatus> status() const;
  // Robots that hold the clock now, with the wall time for which they have.
  std::vector<std::string> waiting_for(double& since_s) const;
  double wall_waiting_s() const;
  uint64_t decisions() const;
  int robot_number(const std::string& id) const;  // -1 where unknown.

  // ---- From the loop ----

  std::optional<Turn> decide(
      SimTime now, std::span<const std::shared_ptr<const Observation>> observations) override;
  void ask(SimTime now, std::span<const std::shared_ptr<const Observation>> observations) override;
  std::optional<Turn> answers(
      std::span<const std::shared_ptr<const Observation>> observations) override;
  std::vector<SimulationEvent> take_faults() override;
  void finish(SimTime time, const std::string& reason) override;

 private:
  using WallClock = std::chrono::steady_clock;
  struct Slot {
    HubRobot robot;
    std::shared_ptr<ClientConnection> connection;
    std::string client;   // Its name, control characters shown.
    bool active = false;  // Its Welcome is out; observations may follow.
    bool ever_connected = false;
    bool frozen = false;
    bool returning = false;  // Frozen, but has shown signs of life.
    bool gone = false;       // See give_up.
    std::string gone_reason;
    uint64_t last_sequence = 0;                  // Of the last observation of any instant.
    std::shared_ptr<const Observation> pending;  // The observation of the current instant.
    bool owes = false;
    std::optional<Decision> decision;
    DebugBudget budget;
    std::bitset<kMostJoints> clamped;  // Joints of which it was recorded: once each.
    uint64_t wrong_hellos = 0;         // Since they were last reported.
    std::optional<SimTime> hellos_told;
  };

  void add_fault(int robot, const std::string& name, const std::string& detail);
  void add_doubts(int robot, const DecisionDoubts& doubts);
  using Letter = std::pair<std::shared_ptr<ClientConnection>, std::shared_ptr<const Observation>>;
  // What is to be sent to whom; the clock runs from here.
  std::vector<Letter> letters_for(SimTime now,
                                  std::span<const std::shared_ptr<const Observation>> observations);
  void apply_policies(WallClock::time_point now);
  std::optional<WallClock::time_point> next_deadline() const;
  WallClock::time_point deadline_of(const Slot& slot) const;
  Answer answer_of(Slot& slot);
  void wait(std::unique_lock<std::mutex>& lock, std::optional<WallClock::time_point> until);

  mutable std::mutex mutex_;
  Wake changed_;
  std::thread::id loop_;  // The thread that waits in decide.
  RunControl& control_;
  std::vector<Slot> slots_;
  std::vector<SupervisorAction> actions_;
  std::vector<SimulationEvent> faults_;
  std::vector<std::pair<int, std::string>> applied_;  // Policies that acted in this instant.
  SharedCore core_;
  size_t owed_ = 0;
  std::vector<int> asked_;  // At this instant; changed by the loop's thread alone.
  bool ended_ = false;
  SimTime now_;
  WallClock::time_point asked_at_;
  double waited_s_ = 0;
  uint64_t decisions_ = 0;
};

}  // namespace seam::scheduler
