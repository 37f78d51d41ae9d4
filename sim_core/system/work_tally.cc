#include "sim_core/system/work_tally.h"

namespace seam {
namespace {

std::atomic<WorkTally*> watched{nullptr};

}  // namespace

void watch_work(WorkTally* tally) {
  watched = tally;
}

WorkTally::Seen WorkTally::seen() const {
  const std::lock_guard lock(mutex_);
  Seen now = seen_;
  now.done = done_, now.steps = steps_;
  return now;
}

void say_work(const std::string& label) {
  WorkTally* const tally = watched;
  if (tally == nullptr) return;
  const std::lock_guard lock(tally->mutex_);
  tally->seen_.label = label;
}

void count_fit_step() {
  if (WorkTally* const tally = watched; tally != nullptr) ++tally->steps_;
}

Work::Work(const char* part, size_t of, Of how) : tally_(watched) {
  if (tally_ == nullptr) return;
  if (tally_->taken_.exchange(true)) {
    tally_ = nullptr;
    return;
  }
  const std::lock_guard lock(tally_->mutex_);
  WorkTally::Seen& seen = tally_->seen_;
  tally_->done_ = 0;
  seen.part = part, seen.of = of, seen.at_most = how == Of::at_most, ++seen.number;
}

Work::~Work() {
  if (tally_ == nullptr) return;
  const std::lock_guard lock(tally_->mutex_);
  tally_->seen_.part.clear();
  tally_->taken_ = false;
}

void Work::done() const {
  if (tally_ != nullptr) ++tally_->done_;
}

void Work::done_so_far(uint64_t pieces) const {
  if (tally_ != nullptr) tally_->done_ = pieces;
}

}  // namespace seam
