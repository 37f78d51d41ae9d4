#include "scheduler/replay/state_records.h"

#include <fmt/format.h>

#include <cstring>

#include "scheduler/log/field_checks.h"
#include "scheduler/log/recorder.h"

namespace seam::scheduler {
namespace {

// Bit by bit: a forged -0.0 or NaN is another pose.
std::string bits_of(const std::vector<float>& values) {
  std::string bits(values.size() * sizeof(float), '\0');
  if (!values.empty()) std::memcpy(bits.data(), values.data(), bits.size());
  return bits;
}

}  // namespace

template <typename List>
bool StateRecords::differs(Kept& kept, const List& logged, const List& made, bool due) {
  if (logged.empty()) {
    if (due) kept.missing = true;
    return due && kept.somewhere;
  }
  kept.somewhere = true;
  return kept.missing || logged != made;
}

std::optional<Divergence> StateRecords::compare(const StepRecord& logged,
                                                const StateDigest& state) {
  const auto other = [&](const Kept& what) {
    return Divergence{logged.time, "step", what.name,
                      fmt::format("step {}: the state is the same, the log's {} are others",
                                  logged.step, what.name)};
  };
  std::vector<uint32_t> halves;
  for (const uint64_t hash : state.section_hashes) halves.push_back(static_cast<uint32_t>(hash));
  if (differs(hashes_, logged.section_hashes, halves, true)) return other(hashes_);
  if (differs(sums_, logged.field_sums, field_sums_.of(state.words), true)) return other(sums_);
  // Before there were sums, other bits of the hashes were kept.
  const bool old_checks = sums_.missing && !logged.field_checks.empty();
  old_checks_ |= old_checks;
  const bool check_due = logged.step % kCheckEverySteps == 0;
  const bool has_checks = !logged.field_checks.empty();
  if (!old_checks &&
      differs(checks_, logged.field_checks,
              has_checks ? field_checks(state.words, logged.step) : std::string(), check_due)) {
    return other(checks_);
  }
  const bool pose_due = logged.step % kPoseEverySteps == 0;
  const bool has_poses = !logged.poses.empty();
  if (differs(poses_, bits_of(logged.poses), has_poses ? bits_of(poses_of(world_)) : std::string(),
              pose_due)) {
    return other(poses_);
  }
  return compare_snapshot(logged);
}

const SnapshotRecord* StateRecords::next_snapshot() {
  if (!snapshot_ && !snapshots_over_) {
    if (std::optional<LogRecord> record = snapshots_.next()) {
      snapshot_ = std::get<SnapshotRecord>(std::move(*record));
    } else {
      snapshots_over_ = true;
    }
  }
  return snapshot_ ? &*snapshot_ : nullptr;
}

std::optional<Divergence> StateRecords::compare_snapshot(const StepRecord& logged) {
  const SnapshotRecord* snapshot = next_snapshot();
  if (snapshot == nullptr || (snapshot->step > logged.step && snapshot->time > logged.time)) {
    return std::nullopt;
  }
  has_snapshots_ = true;
  if (snapshot->step != logged.step || snapshot->time != logged.time) return rest();
  if (snapshot->state != world_.snapshot()) {
    return Divergence{logged.time, "snapshot", "state",
                      fmt::format("step {}: the log's snapshot is another state", logged.step)};
  }
  snapshot_.reset();
  return std::nullopt;
}

std::optional<Divergence> StateRecords::rest() {
  const SnapshotRecord* snapshot = next_snapshot();
  if (snapshot == nullptr) return std::nullopt;
  return Divergence{snapshot->time, "snapshot", "step",
                    fmt::format("the log has a snapshot of step {} at {} ns, the re-run has no "
                                "such step",
                                snapshot->step, snapshot->time.ns())};
}

std::vector<std::string> StateRecords::absent() const {
  std::vector<std::string> names;
  for (const Kept* kept : {&hashes_, &sums_, &checks_, &poses_}) {
    if (kept->missing && !kept->somewhere) names.emplace_back(kept->name);
  }
  if (old_checks_) names.emplace_back("check bits as they are kept today");
  if (!has_snapshots_) names.emplace_back("snapshots");
  return names;
}

}  // namespace seam::scheduler
