#include "scheduler/log/inputs_hash.h"

#include <utility>

namespace seam::scheduler {

void InputsHash::add(const LogRecord& record, std::string_view bytes) {
  if (std::holds_alternative<RunHeader>(record)) {
    if (!std::exchange(has_header_, true)) header_.add(bytes);
  } else if (std::holds_alternative<TurnRecord>(record)) {
    turns_.add(bytes);
  } else if (const auto* event = std::get_if<SimulationEvent>(&record)) {
    if (event->kind == EventKind::fault) faults_.add(bytes);
  }
}

uint64_t InputsHash::digest(SimTime end, EndReason reason) const {
  Hasher hasher;
  for (const Hasher* part : {&header_, &turns_, &faults_}) hasher.add(part->digest());
  hasher.add(end.ns());
  hasher.add(static_cast<uint64_t>(reason));
  return hasher.digest();
}

}  // namespace seam::scheduler
