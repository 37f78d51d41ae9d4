#include "scheduler/verifier.h"

#include <fmt/format.h>

#include "scheduler/field_checks.h"
#include "scheduler/recorder.h"
#include "sim_core/error.h"
#include "sim_core/hash.h"

namespace seam::scheduler {
namespace {

// A field whose bits agree by chance shows up within these steps, if ever.
constexpr int kStepsToLookForField = 64;

// Events that follow from the state; the others come from outside.
bool repeats(EventKind kind) {
  return kind != EventKind::policy && kind != EventKind::fault && kind != EventKind::debug;
}

}  // namespace

FieldNames::FieldNames(const World& world) {
  for (const StateSection& section : world.sections()) {
    first_.push_back(names_.size());
    for (const StateSection::Field& field : section.fields) names_.push_back(field.name);
  }
  first_.push_back(names_.size());
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
      cursor_(log, {Topic::step, Topic::frame, Topic::event, Topic::end}) {}

void Verifier::on_start(const RunHeader& header) {
  const RunHeader& logged = log_.header();
  if (header.sections == logged.sections || logged.sections.empty()) return;
  diverge(SimTime(), "header", "sections",
          fmt::format("the log's state has the sections [{}], this program's [{}]",
                      fmt::join(logged.sections, ", "), fmt::join(header.sections, ", ")));
}

// The next record that a re-run repeats; nothing at the end of the log.
std::optional<LogRecord> Verifier::next_expected() {
  if (exhausted_) return std::nullopt;
  while (std::optional<LogRecord> record = cursor_.next()) {
    const auto* event = std::get_if<SimulationEvent>(&*record);
    if (event != nullptr && !repeats(event->kind)) continue;
    if (ignore_frames_ && std::holds_alternative<FrameRecord>(*record)) continue;
    return record;
  }
  exhausted_ = true;
  control_.stop();  // A log without an end: its writer was killed here.
  return std::nullopt;
}

void Verifier::diverge(SimTime time, std::string section, std::string field, std::string detail) {
  if (divergence_) return;
  divergence_ = {time, std::move(section), std::move(field), std::move(detail)};
  if (!field_wanted_in_) control_.stop();
}

void Verifier::on_step(SimTime time, uint64_t step, std::span<const uint64_t> section_hashes) {
  if (divergence_ && !field_wanted_in_) return;
  std::optional<LogRecord> expected = next_expected();
  if (divergence_) {  // Only the field is still unknown; other records no longer matter.
    while (expected && !std::holds_alternative<StepRecord>(*expected)) expected = next_expected();
    if (expected) look_for_field(std::get<StepRecord>(*expected));
    return;
  }
  if (!expected) return;
  if (const auto* logged = std::get_if<StepRecord>(&*expected)) {
    compare_step(*logged, time, step, section_hashes);
  } else {
    diverge(time, "events", "order",
            fmt::format("the log has another record at {} ns where the re-run steps",
                        time_of(*expected).ns()));
  }
}

void Verifier::compare_step(const StepRecord& logged, SimTime time, uint64_t step,
                            std::span<const uint64_t> section_hashes) {
  if (logged.time != time || logged.step != step) {
    return diverge(std::min(time, logged.time), "clock", "step",
                   fmt::format("the log has step {} at {} ns, the re-run step {} at {} ns",
                               logged.step, logged.time.ns(), step, time.ns()));
  }
  if (logged.fingerprint == step_fingerprint(section_hashes)) {
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
  look_for_field(logged);
}

void Verifier::look_for_field(const StepRecord& logged) {
  FieldChecks checks;
  world_.visit(checks);
  const auto field = FieldNames(world_).first_difference(*field_wanted_in_, logged.field_checks,
                                                         checks.bits());
  if (field) divergence_->field = *field;
  if (field || logged.field_checks.empty() || ++steps_looked_ >= kStepsToLookForField) {
    field_wanted_in_.reset();
    control_.stop();
  }
}

void Verifier::on_frame(SimTime time, const FrameJob&, const Frame& frame) {
  if (divergence_ || ignore_frames_) return;
  const std::optional<LogRecord> expected = next_expected();
  if (!expected) return;
  const std::string section = "frame/" + frame.robot;
  const auto* logged = std::get_if<FrameRecord>(&*expected);
  if (logged == nullptr || logged->time != time || logged->index != frame.frame_index ||
      log_.header().robots[static_cast<size_t>(logged->robot)] != frame.robot) {
    return diverge(time, section, "index",
                   fmt::format("the re-run made frame {}, which the log does not have here",
                               frame.frame_index));
  }
  if (logged->stamp != frame.stamp) {
    return diverge(time, section, "stamp_ns",
                   fmt::format("frame {}: the log has the stamp {} ns, the re-run {} ns",
                               frame.frame_index, logged->stamp.ns(), frame.stamp.ns()));
  }
  if (logged->fingerprint != frame.fingerprint) {
    return diverge(time, section, "pixels",
                   fmt::format("frame {}: the log has the fingerprint {}, the re-run {}",
                               frame.frame_index, to_hex(logged->fingerprint),
                               to_hex(frame.fingerprint)));
  }
  ++frames_;
  verified_until_ = time;
}

void Verifier::on_event(const SimulationEvent& event) {
  if (divergence_ || !repeats(event.kind)) return;
  const std::optional<LogRecord> expected = next_expected();
  if (!expected) return;
  const auto* logged = std::get_if<SimulationEvent>(&*expected);
  if (logged != nullptr && logged->time == event.time && logged->kind == event.kind &&
      logged->robot == event.robot && logged->name == event.name &&
      logged->detail == event.detail) {
    return;
  }
  diverge(event.time, "events", event.name,
          fmt::format("the re-run has the event '{}' {} {}, which the log does not have here",
                      event.name, event.robot, event.detail));
}

void Verifier::on_end(SimTime time, EndReason reason, uint64_t fingerprint) {
  if (divergence_ || exhausted_) return;
  const std::optional<LogRecord> expected = next_expected();
  if (!expected) return;
  const auto* logged = std::get_if<EndRecord>(&*expected);
  if (logged == nullptr) {
    return diverge(time, "end", "time_ns",
                   fmt::format("the re-run ended at {} ns, the log goes on", time.ns()));
  }
  // A run that was stopped from outside may have ended between two events of one instant.
  if (logged->reason != EndReason::finished || ignore_frames_) return;
  if (reason != logged->reason || logged->fingerprint != fingerprint) {
    diverge(time, "end", "fingerprint",
            fmt::format("the log has the fingerprint {}, the re-run {}",
                        to_hex(logged->fingerprint), to_hex(fingerprint)));
  }
}

}  // namespace seam::scheduler
