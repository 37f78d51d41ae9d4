// Compares a re-run with its log, step by step, and latches the first divergence.
#pragma once

#include <optional>
#include <string>
#include <tuple>

#include "scheduler/log/log.h"
#include "scheduler/loop/observer.h"
#include "scheduler/loop/run_control.h"
#include "scheduler/loop/run_fingerprint.h"
#include "scheduler/replay/divergence.h"
#include "scheduler/replay/expected_records.h"
#include "scheduler/replay/shown_records.h"
#include "scheduler/replay/state_records.h"
#include "sim_core/world/world.h"

namespace seam::scheduler {

// What fields of a state are called, by their number over all sections.
class FieldNames {
 public:
  explicit FieldNames(const World& world);
  // The first of these fields, by their numbers, that belongs to the section.
  std::optional<std::string> first_of(size_t section, std::span<const size_t> fields) const;
  // The first field of a section that differs by its check bits; nothing where none shows it.
  std::optional<std::string> first_difference(size_t section, std::string_view logged_checks,
                                              std::string_view checks) const;

 private:
  std::vector<size_t> first_;  // Number of each section's first field, and the end.
  std::vector<std::string> names_;
};

class Verifier final : public SimulationObserver {
 public:
  // `control` is asked to stop once everything is known. All must outlive the verifier.
  Verifier(const Log& log, const World& world, RunControl& control);

  void on_start(const RunHeader& header) override;
  void on_turn(SimTime time, const Turn& turn) override;
  void on_step(SimTime time, uint64_t step, const StateDigest& state) override;
  void on_frame(SimTime time, const FrameJob& job, const Frame& frame) override;
  void on_event(const SimulationEvent& event) override;
  void on_end(SimTime time, EndReason reason, uint64_t fingerprint) override;

  // Frames are not made in this re-run, so those of the log are passed over.
  void ignore_frames() { ignore_frames_ = true; }

  const std::optional<Divergence>& divergence() const { return divergence_; }
  uint64_t steps() const { return steps_; }
  uint64_t frames() const { return frames_; }
  // The log has its end, and it was reached.
  bool has_end() const { return end_.has_value(); }
  // What the log holds of no step, though a recorder writes it: names for people.
  std::vector<std::string> absent() const { return state_records_.absent(); }
  // Time of the last step or frame that was compared.
  SimTime verified_until() const { return verified_until_; }

 private:
  using EventKey = std::tuple<SimTime, EventKind, std::string, std::string, std::string>;

  std::optional<StepRecord> next_step();
  void find_missing(SimTime time);
  void report_missing(const FrameRecord& frame);
  void report_missing(const SimulationEvent& event);
  // The log ends here without an end: its writer was killed, and nothing more can be compared.
  bool may_be_cut_off(SimTime time) const;
  void stop_at_open_end();
  void compare_rest();
  void compare_end(SimTime time, EndReason reason, uint64_t fingerprint);
  void compare_stopped_end();
  void chain_until_step();
  void diverge(SimTime time, std::string section, std::string field, std::string detail);
  void compare_step(const StepRecord& logged, SimTime time, uint64_t step,
                    const StateDigest& state);
  void look_for_field(const StepRecord& logged, const StateDigest& state);

  const Log& log_;
  const World& world_;
  RunControl& control_;
  std::optional<EndRecord> end_;
  LogCursor steps_expected_;
  LogCursor turns_expected_;
  StateRecords state_records_;
  ShownRecords shown_records_;
  // Of a run that was stopped, whose last frames a re-run finishes later than it did: the
  // fingerprint in the order of the log.
  LogCursor chain_;
  RunFingerprint chained_;
  ExpectedRecords<FrameRecord, std::pair<int, uint64_t>> frames_expected_;
  ExpectedRecords<SimulationEvent, EventKey> events_expected_;
  bool ignore_frames_ = false;
  bool over_ = false;
  std::optional<Divergence> divergence_;
  std::optional<size_t> field_wanted_in_;  // Section whose differing field is not yet known.
  int steps_looked_ = 0;
  uint64_t steps_ = 0;
  uint64_t frames_ = 0;
  SimTime verified_until_;
};

}  // namespace seam::scheduler
