// The events of a run in their total order: (time, phase, source id, sequence number). The order in
// which events are inserted never matters beyond that key, and no two events share a key.
#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim_core/base/random.h"
#include "sim_core/base/time.h"

namespace seam::scheduler {

// What happens at one instant, in this order.
enum class Phase : uint8_t {
  apply_commands,
  step_world,
  sample_light,
  finish_frames,
  deliver_observations,
  wait_for_decisions,
};
std::string to_string(Phase phase);

struct EventKey {
  SimTime time;
  Phase phase = Phase::apply_commands;
  uint32_t source = 0;    // 0 the world, 1 + robot's number a robot.
  uint64_t sequence = 0;  // Counts the events of one source in one phase; given by the source.

  auto operator<=>(const EventKey&) const = default;
};
std::string to_string(const EventKey& key);

// A binary heap of keys. Which payload belongs to a key is the business of its source, so that the
// queue's state is the set of keys and nothing else.
class EventQueue {
 public:
  // Test mode: simultaneous insertions are buffered and inserted in an order drawn from `stream`.
  // A run must come out the same whatever the stream.
  void permute_insertions(RandomStream stream) { permutation_ = stream; }

  // The key must not lie before the last popped key: nothing happens in the past.
  void push(const EventKey& key);
  bool empty() const { return heap_.empty() && buffer_.empty(); }
  size_t size() const { return heap_.size() + buffer_.size(); }
  const EventKey& top();
  EventKey pop();
  std::optional<EventKey> last_popped() const { return last_popped_; }

  // All pending keys in order; for snapshots and tests.
  std::vector<EventKey> pending() const;
  void clear();

 private:
  void flush();

  std::vector<EventKey> heap_;
  std::vector<EventKey> buffer_;  // Used in the permuting test mode only.
  std::optional<EventKey> last_popped_;
  std::optional<RandomStream> permutation_;
  uint64_t draws_ = 0;
};

}  // namespace seam::scheduler
