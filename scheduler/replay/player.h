// Decisions from a log: alone for re-runs, or together with live clients for going on from a log
// and for what-if runs.
#pragma once

#include <atomic>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "scheduler/log/log.h"
#include "scheduler/loop/decision_source.h"

namespace seam::scheduler {

// The turns of a log, one after another.
class TurnReader {
 public:
  explicit TurnReader(const Log& log) : cursor_(log, {Topic::turn}) {}

  // The turn of this instant; nothing where the log has no more. Throws InputError where the log
  // has another instant or other robots than asked for: it belongs to another run, or a part is
  // missing.
  std::optional<Turn> turn(SimTime now,
                           std::span<const std::shared_ptr<const Observation>> observations);

 private:
  LogCursor cursor_;
};

// A re-run: every decision from the log; the run stops where the log does.
class LogSource final : public DecisionSource {
 public:
  explicit LogSource(const Log& log) : turns_(log) {}
  std::optional<Turn> decide(
      SimTime now, std::span<const std::shared_ptr<const Observation>> observations) override;

 private:
  TurnReader turns_;
};

struct MixedSourceOptions {
  // From this time on, these robots are driven by their live clients, even where the log has their
  // decisions.
  std::set<int> live_robots;
  SimTime live_from;
};

// What came of it.
struct MixedReport {
  // While the log decided: how many live decisions there were, and how many of them were others
  // than those of the log. A behaviour that does not repeat itself cannot be resumed exactly.
  uint64_t compared_decisions = 0;
  uint64_t different_decisions = 0;
  // The first instant at which a live decision took effect.
  std::optional<SimTime> live_since;
  // By robot: when its client first decided otherwise than the log says, with effect or without.
  struct Otherwise {
    SimTime time;
    Answer logged, live;
  };
  std::map<int, Otherwise> first_otherwise;
  std::map<int, uint64_t> alike;  // By robot: decisions before the first other one.
  // The first instant whose decisions were others than the log's, with effect: until then the world
  // is the log's. Renderers read it on threads of their own.
  std::atomic<int64_t> departs_ns = std::numeric_limits<int64_t>::max();
};

// Decisions from a log as far as it goes, then from live clients. The live clients get every
// observation from the start, so that they come to know what they would have known; what they
// decide while the log decides has no effect. The supervisor's actions of the log are repeated.
class MixedSource final : public DecisionSource {
 public:
  MixedSource(const Log& log, DecisionSource& live, MixedReport& report,
              MixedSourceOptions options = {})
      : turns_(log), live_(live), report_(report), options_(std::move(options)) {}

  std::optional<Turn> decide(
      SimTime now, std::span<const std::shared_ptr<const Observation>> observations) override;
  std::vector<SimulationEvent> take_faults() override { return live_.take_faults(); }
  void finish(SimTime now, const std::string& reason) override { live_.finish(now, reason); }

 private:
  void mix(SimTime now, Answer& logged, Answer& live, const std::vector<std::string>& robots);

  TurnReader turns_;
  DecisionSource& live_;
  MixedReport& report_;
  MixedSourceOptions options_;
  bool log_is_over_ = false;
};

}  // namespace seam::scheduler
