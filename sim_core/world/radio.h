// The radio between team mates: latency, range, loss, and a bandwidth for each sender.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim_core/base/random.h"
#include "sim_core/base/time.h"
#include "sim_core/body/state.h"
#include "sim_core/scenario/scenario.h"

namespace seam {

struct RadioMessage {
  std::string from;  // The sender's id.
  SimTime sent;
  SimTime arrived;
  std::string payload;
};

enum class RadioFate : uint8_t { on_its_way, lost, out_of_range, queue_full };

// A message that is sent occupies its sender's channel for bytes / bandwidth; it arrives at each
// team mate in range a latency after that. Losses are drawn for each receiver from a counter.
class Radio {
 public:
  Radio(const RadioSpec& spec, std::vector<std::string> ids, std::vector<Team> teams,
        RandomStream stream);

  // Queues the message to all team mates; `places` are the robots' places at this time. Returns
  // what becomes of it for each robot that is a team mate, in order of robots.
  std::vector<std::pair<size_t, RadioFate>> send(size_t from, const std::string& payload,
                                                 SimTime time, const std::vector<Pose2>& places);
  // Messages that arrived after `since` and by `time`, in the order (arrival, sender, sequence).
  std::vector<RadioMessage> received(size_t to, SimTime time, SimTime since) const;
  // No message that arrived before this time will be asked for any more.
  void forget_before(SimTime time);
  void visit(StateVisitor& visitor);

 private:
  struct InFlight {
    SimTime arrives;
    int64_t from = 0;
    int64_t to = 0;
    int64_t sequence = 0;
    SimTime sent;
    std::string payload;
    void visit(StateVisitor& visitor);
  };
  struct Sender {
    SimTime free_at;       // When its channel is free again.
    int64_t sequence = 0;  // Messages sent so far.
    void visit(StateVisitor& visitor);
  };
  const RadioSpec* spec_;
  std::vector<std::string> ids_;
  std::vector<Team> teams_;
  RandomStream stream_;
  std::vector<Sender> senders_;
  std::vector<InFlight>
      messages_;  // On their way or arrived lately, in the order (arrives, from, sequence, to).
};

}  // namespace seam
