#include "scheduler/replay/verifier.h"

#include <fmt/format.h>

#include <algorithm>

#include "scheduler/log/field_checks.h"
#include "scheduler/log/field_sums.h"
#include "scheduler/log/recorder.h"
#include "sim_core/base/error.h"
#include "sim_core/base/hash.h"

namespace seam::scheduler {
namespace {

// A field whose bits agree by chance shows up within these steps, if ever.
constexpr int kStepsToLookForField = 64;
// How often missing frames and events are looked for.
constexpr uint64_t kStepsBetweenLooks = 128;

// Events that a re-run has again: they follow from the state or the decisions. The others come
// from outside.
bool repeats(EventKind kind) {
  return kind != EventKind::fault && kind != EventKind::debug;
}

uint64_t frames_of(const Log& log) {
  LogCursor cursor(log, {Topic::frame});
  uint64_t frames = 0;
  while (cursor.next()) ++frames;
  return frames;
}

}  // namespace

FieldNames::FieldNames(const World& world) {
  for (const StateSection& section : world.sections()) {
    first_.push_back(names_.size());
    for (const StateSection::Field& field : section.fields) names_.push_back(field.name);
  }
  first_.push_back(names_.size());
}

std::optional<std::string> FieldNames::first_of(size_t section,
                                                std::span<const size_t> fields) const {
  if (section + 1 >= first_.size()) return std::nullopt;
  for (const size_t field : fields) {
    if (field >= first_[section] && field < first_[section + 1]) return names_[field];
  }
  return std::nullopt;
}

std::optional<std::string> FieldNames::first_difference(size_t section,
                                                        std::string_view logged_checks,
                                                        std::string_view checks) const {
  if (section + 1 >= first_.size()) return std::nullopt;
  const auto bits = [](std::string_view packed, size_t field) {
    return (static_cast<uint8_t>(packed[field / 4]) >> (2 * (field % 4))) & 3;
  };
  for (size_t field = first_[section]; field < first_[section + 1]; ++field) {
    if (field / 4 >= logged_checks.size() || field / 4 >= checks.size()) break;
    if (bits(logged_checks, field) != bits(checks, field)) return names_[field];
  }
  return std::nullopt;
}

Verifier::Verifier(const Log& log, const World& world, RunControl& control)
    : log_(log),
      world_(world),
      control_(control),
      end_(log.end()),
      steps_expected_(log, {Topic::step}),
      turns_expected_(log, {Topic::turn}),
      state_records_(log, world),
      shown_records_(log, world),
      chain_(log, {Topic::step, Topic::frame}),
      frames_expected_(
          log, Topic::frame,
          [](const FrameRecord& frame) { return std::pair(frame.robot, frame.index); },
          [](const FrameRecord&) { return true; }),
      events_expected_(
          log, Topic::event,
          [](const SimulationEvent& event) {
            return EventKey(event.time, event.kind, event.robot, event.name, event.detail);
          },
          [](const SimulationEvent& event) { return repeats(event.kind); }) {}

void Verifier::on_start(const RunHeader& header) {
  const RunHeader& logged = log_.header();
  std::vector<std::string> robots;
  for (const RobotSpec& robot : world_.scenario().robots) robots.push_back(robot.id);
  if (robots != logged.robots) {
    return diverge(SimTime(), "header", "robots",
                   fmt::format("the log names the robots [{}], its scenario [{}]",
                               fmt::join(logged.robots, ", "), fmt::join(robots, ", ")));
  }
  if (header.sections == logged.sections || logged.sections.empty()) return;
  diverge(SimTime(), "header", "sections",
          fmt::format("the log's state has the sections [{}], this program's [{}]",
                      fmt::join(logged.sections, ", "), fmt::join(header.sections, ", ")));
}

void Verifier::on_turn(SimTime, const Turn&) {
  // What it says was taken from the log; here it only counts that none is left in the end.
  if (!over_ && !divergence_) turns_expected_.next();
}

// A run that was stopped from outside may have ended between two events of its last instant.
bool Verifier::may_be_cut_off(SimTime time) const {
  return !end_ || (end_->reason == EndReason::stopped && time >= end_->time);
}

void Verifier::stop_at_open_end() {
  over_ = true;
  control_.stop();
}

std::optional<StepRecord> Verifier::next_step() {
  std::optional<LogRecord> record = steps_expected_.next();
  if (!record) return std::nullopt;
  return std::get<StepRecord>(std::move(*record));
}

// Frames and events of the log that the re-run should have made long ago.
void Verifier::find_missing(SimTime time) {
  if (const FrameRecord* frame = ignore_frames_ ? nullptr : frames_expected_.overdue(time)) {
    report_missing(*frame);
  }
  if (const SimulationEvent* event = events_expected_.overdue(time)) report_missing(*event);
}

void Verifier::report_missing(const FrameRecord& frame) {
  diverge(frame.time, "frame/" + log_.header().robots[static_cast<size_t>(frame.robot)], "index",
          fmt::format("the log has frame {}, the re-run does not make it", frame.index));
}

void Verifier::report_missing(const SimulationEvent& event) {
  diverge(event.time, "events", event.name,
          fmt::format("the log has the event '{}' {} {}, the re-run does not", event.name,
                      event.robot, event.detail));
}

void Verifier::diverge(SimTime time, std::string section, std::string field, std::string detail) {
  if (divergence_) return;
  divergence_ = {time, std::move(section), std::move(field), std::move(detail)};
  if (!field_wanted_in_) control_.stop();
}

void Verifier::on_step(SimTime time, uint64_t step, const StateDigest& state) {
  if (over_ || (divergence_ && !field_wanted_in_)) return;
  const std::optional<StepRecord> logged = next_step();
  if (divergence_) {  // Only the field is still unknown.
    if (logged) look_for_field(*logged, state);
    return;
  }
  if (logged) {
    compare_step(*logged, time, step, state);
  } else if (may_be_cut_off(time)) {
    stop_at_open_end();
  } else {
    diverge(time, "clock", "step",
            fmt::format("the re-run has step {} at {} ns, the log ended", step, time.ns()));
  }
  if (!divergence_ && step % kStepsBetweenLooks == 0) find_missing(time);
}

void Verifier::compare_step(const StepRecord& logged, SimTime time, uint64_t step,
                            const StateDigest& state) {
  const std::vector<uint64_t>& section_hashes = state.section_hashes;
  if (logged.time != time || logged.step != step) {
    return diverge(std::min(time, logged.time), "clock", "step",
                   fmt::format("the log has step {} at {} ns, the re-run step {} at {} ns",
                               logged.step, logged.time.ns(), step, time.ns()));
  }
  if (logged.fingerprint == step_fingerprint(section_hashes)) {
    std::optional<Divergence> other = state_records_.compare(logged, state);
    if (!other) other = shown_records_.compare_step(time);
    if (other) return diverge(other->time, other->section, other->field, other->detail);
    if (end_ && end_->reason == EndReason::stopped) {
      chain_until_step();
      chained_.add(section_hashes);
    }
    ++steps_;
    verified_until_ = time;
    return;
  }
  size_t section = 0;
  while (section < section_hashes.size() && section < logged.section_hashes.size() &&
         static_cast<uint32_t>(section_hashes[section]) == logged.section_hashes[section]) {
    ++section;
  }
  const std::vector<std::string>& names = log_.header().sections;
  field_wanted_in_ = section;
  diverge(time, section < names.size() ? names[section] : "state", "",
          fmt::format("step {}: the states differ", step));
  look_for_field(logged, state);
}

// At the first step that differs the sums name the field, unless many differ at once. Then the next
// check bits do.
void Verifier::look_for_field(const StepRecord& logged, const StateDigest& state) {
  const FieldNames names(world_);
  std::optional<std::string> field;
  if (steps_looked_ == 0) {
    field = names.first_of(
        *field_wanted_in_,
        differing_fields(logged.field_sums, FieldSums().of(state.words), state.words.size()));
  }
  if (!field && !logged.field_checks.empty()) {
    field = names.first_difference(*field_wanted_in_, logged.field_checks,
                                   field_checks(state.words, logged.step));
  }
  if (field) divergence_->field = *field;
  if (field || ++steps_looked_ >= kStepsToLookForField) {
    field_wanted_in_.reset();
    control_.stop();
  }
}

void Verifier::on_frame(SimTime time, const FrameJob&, const Frame& frame) {
  // Also of a log that is over: the last frames are finished behind its last step.
  if (divergence_ || ignore_frames_) return;
  const std::string section = "frame/" + frame.robot;
  const auto& robots = log_.header().robots;
  const int robot =
      static_cast<int>(std::find(robots.begin(), robots.end(), frame.robot) - robots.begin());
  const auto logged = frames_expected_.take({robot, frame.frame_index}, time);
  if (!logged) {
    if (may_be_cut_off(time) && frames_expected_.exhausted())
      return;  // Made, but not yet written when killed.
    return diverge(
        time, section, "index",
        fmt::format("the re-run made frame {}, which the log does not have", frame.frame_index));
  }
  if (logged->stamp != frame.stamp || logged->time != time) {
    return diverge(
        time, section, "stamp_ns",
        fmt::format("frame {}: the log has the stamp {} ns and ends at {} ns, the re-run "
                    "{} ns and {} ns",
                    frame.frame_index, logged->stamp.ns(), logged->time.ns(), frame.stamp.ns(),
                    time.ns()));
  }
  if (logged->fingerprint != frame.fingerprint) {
    return diverge(
        time, section, "pixels",
        fmt::format("frame {}: the log has the fingerprint {}, the re-run {}", frame.frame_index,
                    to_hex(logged->fingerprint), to_hex(frame.fingerprint)));
  }
  if (auto other = shown_records_.compare_frame(time, frame)) {
    return diverge(other->time, other->section, other->field, other->detail);
  }
  ++frames_;
  if (!over_) verified_until_ = std::max(verified_until_, time);
}

void Verifier::on_event(const SimulationEvent& event) {
  if (over_ || divergence_ || !repeats(event.kind)) return;
  const EventKey key(event.time, event.kind, event.robot, event.name, event.detail);
  if (events_expected_.take(key, event.time)) return;
  if (may_be_cut_off(event.time) && events_expected_.exhausted()) return;
  diverge(event.time, "events", event.name,
          fmt::format("the re-run has the event '{}' {} {}, which the log does not have",
                      event.name, event.robot, event.detail));
}

void Verifier::on_end(SimTime time, EndReason reason, uint64_t fingerprint) {
  if (divergence_) return;
  compare_rest();
  if (divergence_ || !end_) return;
  if (steps_ != end_->steps) {
    return diverge(end_->time, "end", "steps",
                   fmt::format("the log counts {} steps and has {}", end_->steps, steps_));
  }
  const uint64_t frames = ignore_frames_ ? frames_of(log_) : frames_;
  if (frames != end_->frames) {
    return diverge(end_->time, "end", "frames",
                   fmt::format("the log counts {} frames and has {}", end_->frames, frames));
  }
  if (end_->reason == EndReason::stopped) {
    compare_stopped_end();
  } else {
    compare_end(time, reason, fingerprint);
  }
}

// Whatever the log has and the re-run had not.
void Verifier::compare_rest() {
  if (const std::optional<StepRecord> more = over_ ? std::nullopt : next_step()) {
    return diverge(more->time, "end", "time_ns",
                   fmt::format("the re-run ended after {} steps, the log goes on at {} ns", steps_,
                               more->time.ns()));
  }
  if (const std::optional<LogRecord> turn = over_ ? std::nullopt : turns_expected_.next()) {
    return diverge(time_of(*turn), "end", "turn",
                   "the log has decisions for an instant that the re-run does not reach");
  }
  if (const FrameRecord* frame = ignore_frames_ ? nullptr : frames_expected_.rest()) {
    return report_missing(*frame);
  }
  if (const SimulationEvent* event = events_expected_.rest()) return report_missing(*event);
  std::optional<Divergence> other = state_records_.rest();
  if (!other) other = shown_records_.rest(!ignore_frames_);
  if (other) diverge(other->time, other->section, other->field, other->detail);
}

void Verifier::compare_end(SimTime time, EndReason reason, uint64_t fingerprint) {
  if (reason != end_->reason) {
    return diverge(time, "end", "reason", "the re-run does not end as the log says");
  }
  if (time != end_->time) {
    return diverge(
        time, "end", "time_ns",
        fmt::format("the log ends at {} ns, the re-run at {} ns", end_->time.ns(), time.ns()));
  }
  if (end_->fingerprint == fingerprint || ignore_frames_) return;
  diverge(time, "end", "fingerprint",
          fmt::format("the log has the fingerprint {}, the re-run {}", to_hex(end_->fingerprint),
                      to_hex(fingerprint)));
}

// Chains the frames up to the next step of the log, or to its end.
void Verifier::chain_until_step() {
  while (const std::optional<LogRecord> record = chain_.next()) {
    const auto* frame = std::get_if<FrameRecord>(&*record);
    if (frame == nullptr) return;
    chained_.add({&frame->fingerprint, 1});
  }
}

void Verifier::compare_stopped_end() {
  if (ignore_frames_) return;
  chain_until_step();
  if (chained_.value() == end_->fingerprint) return;
  diverge(end_->time, "end", "fingerprint",
          fmt::format("the log has the fingerprint {}, its steps and frames together {}",
                      to_hex(end_->fingerprint), to_hex(chained_.value())));
}

}  // namespace seam::scheduler
