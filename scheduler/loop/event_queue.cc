#include "scheduler/loop/event_queue.h"

#include <algorithm>
#include <functional>

#include "sim_core/base/error.h"

namespace seam::scheduler {

std::string to_string(Phase phase) {
  switch (phase) {
    case Phase::apply_commands:
      return "apply_commands";
    case Phase::step_world:
      return "step_world";
    case Phase::sample_light:
      return "sample_light";
    case Phase::finish_frames:
      return "finish_frames";
    case Phase::deliver_observations:
      return "deliver_observations";
    case Phase::wait_for_decisions:
      return "wait_for_decisions";
  }
  return "unknown";
}

std::string to_string(const EventKey& key) {
  return fmt::format("({} ns, {}, source {}, number {})", key.time.ns(), to_string(key.phase),
                     key.source, key.sequence);
}

void EventQueue::push(const EventKey& key) {
  SEAM_CHECK(!last_popped_ || *last_popped_ < key, "event {} after {}", to_string(key),
             to_string(*last_popped_));
  if (permutation_) {
    buffer_.push_back(key);
    return;
  }
  heap_.push_back(key);
  std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
}

void EventQueue::flush() {
  for (size_t left = buffer_.size(); left > 0; --left) {
    const auto pick = static_cast<size_t>(uniform(*permutation_, draws_++) * left);
    std::swap(buffer_[pick], buffer_[left - 1]);
    heap_.push_back(buffer_[left - 1]);
    std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
  }
  buffer_.clear();
}

const EventKey& EventQueue::top() {
  flush();
  SEAM_CHECK(!heap_.empty(), "the event queue is empty");
  return heap_.front();
}

EventKey EventQueue::pop() {
  const EventKey key = top();
  std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
  heap_.pop_back();
  SEAM_CHECK(!last_popped_ || *last_popped_ < key, "two events have the key {}", to_string(key));
  last_popped_ = key;
  return key;
}

std::vector<EventKey> EventQueue::pending() const {
  std::vector<EventKey> keys = heap_;
  keys.insert(keys.end(), buffer_.begin(), buffer_.end());
  std::sort(keys.begin(), keys.end());
  return keys;
}

void EventQueue::clear() {
  heap_.clear();
  buffer_.clear();
  last_popped_.reset();
}

}  // namespace seam::scheduler
