#include "scheduler/loop/event_queue.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace seam::scheduler {
namespace {

EventKey key(int64_t ns, Phase phase, uint32_t source, uint64_t sequence) {
  return {SimTime::from_ns(ns), phase, source, sequence};
}

std::vector<EventKey> some_keys() {
  std::vector<EventKey> keys;
  for (int64_t ns : {5, 3, 9})
    for (Phase phase : {Phase::wait_for_decisions, Phase::apply_commands, Phase::sample_light})
      for (uint32_t source : {2u, 0u, 1u})
        for (uint64_t sequence : {1ull, 0ull}) keys.push_back(key(ns, phase, source, sequence));
  return keys;
}

TEST(EventQueue, PopsByTimeThenPhaseThenSourceThenSequence) {
  EventQueue queue;
  for (const EventKey& k : some_keys()) queue.push(k);
  std::vector<EventKey> expected = some_keys();
  std::sort(expected.begin(), expected.end(), [](const EventKey& a, const EventKey& b) {
    return std::tuple(a.time.ns(), static_cast<int>(a.phase), a.source, a.sequence) <
           std::tuple(b.time.ns(), static_cast<int>(b.phase), b.source, b.sequence);
  });
  for (const EventKey& k : expected) EXPECT_EQ(queue.pop(), k);
  EXPECT_TRUE(queue.empty());
}

TEST(EventQueue, OrderOfInsertionDoesNotMatter) {
  std::vector<EventKey> reference = some_keys();
  std::sort(reference.begin(), reference.end());
  for (uint64_t seed = 0; seed < 50; ++seed) {
    EventQueue queue;
    queue.permute_insertions(RandomStream{seed, 1});
    for (const EventKey& k : some_keys()) queue.push(k);
    for (const EventKey& k : reference) ASSERT_EQ(queue.pop(), k) << "seed " << seed;
  }
}

TEST(EventQueue, PendingIsSortedAndComplete) {
  EventQueue queue;
  for (const EventKey& k : some_keys()) queue.push(k);
  std::vector<EventKey> reference = some_keys();
  std::sort(reference.begin(), reference.end());
  EXPECT_EQ(queue.pending(), reference);
}

TEST(EventQueueDeathTest, RefusesThePast) {
  EventQueue queue;
  queue.push(key(10, Phase::step_world, 0, 0));
  queue.pop();
  EXPECT_DEATH(queue.push(key(10, Phase::apply_commands, 0, 0)), "apply_commands");
}

TEST(EventQueueDeathTest, RefusesTwoEventsWithOneKey) {
  EventQueue queue;
  queue.push(key(10, Phase::step_world, 0, 0));
  queue.push(key(10, Phase::step_world, 0, 0));
  queue.pop();
  EXPECT_DEATH(queue.pop(), "two events");
}

}  // namespace
}  // namespace seam::scheduler
