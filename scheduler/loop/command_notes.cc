#include "scheduler/loop/command_notes.h"

#include <fmt/format.h>

namespace seam::scheduler {

std::string clamped_line(const SimulationEvent& event) {
  return fmt::format("{:.3f} s {}: warning: {}", event.time.s(), event.robot, event.detail);
}

void CommandNotes::on_event(const SimulationEvent& event) {
  if (event.kind != EventKind::fault) return;
  if (event.name == kClampedFault) clamped_.push_back(clamped_line(event));
  if (event.name != kRefusedFault) return;
  Refused& refused = refused_[event.robot];
  if (refused.count++ > 0) return;
  refused.first = event.time;
  refused.why = event.detail;
}

void CommandNotes::on_turn(SimTime, const Turn& turn) {
  for (const Answer& answer : turn.answers)
    if (answer.outcome == Outcome::decided || answer.outcome == Outcome::resumed)
      ++decisions_[robots_.at(static_cast<size_t>(answer.robot))];
}

std::vector<std::string> CommandNotes::refused_lines() const {
  std::vector<std::string> lines;
  for (const auto& [robot, refused] : refused_) {
    const auto made = decisions_.find(robot);
    lines.push_back(fmt::format(
        "{}: {} of {} decisions were refused and did nothing; the first at {:.3f} s: {}", robot,
        refused.count, made == decisions_.end() ? 0 : made->second, refused.first.s(),
        refused.why));
  }
  return lines;
}

}  // namespace seam::scheduler
