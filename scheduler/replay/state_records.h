// What a log keeps of a state beside its fingerprint: section hashes, sums, check bits, poses and
// snapshots, each made again from the re-run's state and compared.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scheduler/log/field_sums.h"
#include "scheduler/log/log.h"
#include "scheduler/replay/divergence.h"
#include "sim_core/world/world.h"

namespace seam::scheduler {

class StateRecords {
 public:
  // Both must outlive this.
  StateRecords(const Log& log, const World& world)
      : world_(world), snapshots_(log, {Topic::snapshot}) {}

  // Of a step whose fingerprint is right, with the world standing at it. What the log lacks
  // altogether is passed over (`absent`); what it keeps of some steps it must keep of all.
  std::optional<Divergence> compare(const StepRecord& logged, const StateDigest& state);
  // A snapshot at which no step was; call behind the last one.
  std::optional<Divergence> rest();
  // Names of what the log has of no step.
  std::vector<std::string> absent() const;

 private:
  // Whether the log keeps it of the steps at which it is due.
  struct Kept {
    const char* name;
    bool somewhere = false;
    bool missing = false;
  };
  template <typename List>
  bool differs(Kept& kept, const List& logged, const List& made, bool due);
  std::optional<Divergence> compare_snapshot(const StepRecord& logged);
  const SnapshotRecord* next_snapshot();

  const World& world_;
  LogCursor snapshots_;
  std::optional<SnapshotRecord> snapshot_;  // The next one.
  bool snapshots_over_ = false;
  bool has_snapshots_ = false;
  bool old_checks_ = false;
  FieldSums field_sums_;
  Kept hashes_{"section hashes"}, sums_{"field sums"}, checks_{"check bits"}, poses_{"poses"};
};

}  // namespace seam::scheduler
