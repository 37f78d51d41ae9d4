// Where decisions come from: live clients (gRPC), a log, or functions in this process.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "scheduler/loop/exchange.h"

namespace seam::scheduler {

class DecisionSource {
 public:
  virtual ~DecisionSource() = default;

  // Hands out the observations of one instant, in the scenario's order of robots, and returns one
  // answer for each, in the same order, whatever the order in which answers arrive. Blocks until
  // every answer is there. Nothing means that the run is to stop here (Ctrl-C, the log's end).
  virtual std::optional<Turn> decide(
      SimTime now, std::span<const std::shared_ptr<const Observation>> observations) = 0;

  // Takes what happened outside since the last call and is worth a line in the log: refused
  // messages, lost connections. Information only.
  virtual std::vector<SimulationEvent> take_faults() { return {}; }

  // The run is over; clients are notified.
  virtual void finish(SimTime, const std::string& /*reason*/) {}
};

// Clients that decide while the caller does something else.
class LiveSource : public DecisionSource {
 public:
  // Hands out the observations of one instant and returns at once.
  virtual void ask(SimTime now,
                   std::span<const std::shared_ptr<const Observation>> observations) = 0;
  // What `decide` returns, of what was asked last.
  virtual std::optional<Turn> answers(
      std::span<const std::shared_ptr<const Observation>> observations) = 0;
};

// Decisions made by a function in this process: tests and benchmarks.
class FunctionSource final : public DecisionSource {
 public:
  using Behaviour = std::function<Decision(const Observation&)>;
  explicit FunctionSource(Behaviour behaviour) : behaviour_(std::move(behaviour)) {}

  std::optional<Turn> decide(
      SimTime, std::span<const std::shared_ptr<const Observation>> observations) override {
    Turn turn;
    for (const auto& observation : observations)
      turn.answers.push_back(
          {observation->robot, observation->sequence, Outcome::decided, behaviour_(*observation)});
    return turn;
  }

 private:
  Behaviour behaviour_;
};

}  // namespace seam::scheduler
