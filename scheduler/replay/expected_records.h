// The records of one kind that a re-run must repeat, found by key: other writers may have ordered
// records of different times or kinds otherwise.
#pragma once

#include <map>
#include <optional>

#include "scheduler/log/log.h"

namespace seam::scheduler {

// `Record` is an alternative of LogRecord with a member `time`; `key_of(record)` names it.
template <typename Record, typename Key>
class ExpectedRecords {
 public:
  ExpectedRecords(const Log& log, Topic topic, Key (*key_of)(const Record&),
                  bool (*wanted)(const Record&))
      : cursor_(log, {topic}), key_of_(key_of), wanted_(wanted) {}

  // Takes the record of this key out; nothing where the log has none up to `time` + kAhead.
  std::optional<Record> take(const Key& key, SimTime time) {
    while (true) {
      if (const auto found = waiting_.find(key); found != waiting_.end()) {
        Record record = std::move(found->second);
        waiting_.erase(found);
        return record;
      }
      if (read_until_ > time + kAhead || !read()) return std::nullopt;
    }
  }
  // The first record that nobody took, of all that the log has.
  const Record* rest() {
    while (read()) {
    }
    const Record* first = nullptr;
    for (const auto& [key, record] : waiting_) {
      if (first == nullptr || record.time < first->time) first = &record;
    }
    return first;
  }
  // The log has no record that was not read.
  bool exhausted() const { return exhausted_; }
  // A record that should have come by `time`, and did not.
  const Record* overdue(SimTime time) {
    while (read_until_ < time && read()) {
    }
    const Record* first = nullptr;
    for (const auto& [key, record] : waiting_) {
      if (record.time + kLate >= time) continue;
      if (first == nullptr || record.time < first->time) first = &record;
    }
    return first;
  }

 private:
  // Frames and events are recorded at most this long after their own time: a camera's period and
  // its exposure, a behaviour's period.
  static constexpr SimDuration kLate = SimDuration::from_ns(10'000'000'000);
  static constexpr SimDuration kAhead = SimDuration::from_ns(1'000'000'000);

  bool read() {
    std::optional<LogRecord> record = cursor_.next();
    if (!record) {
      exhausted_ = true;
      return false;
    }
    Record& one = std::get<Record>(*record);
    read_until_ = std::max(read_until_, one.time);
    if (wanted_(one)) waiting_.emplace(key_of_(one), std::move(one));
    return true;
  }

  LogCursor cursor_;
  Key (*key_of_)(const Record&);
  bool (*wanted_)(const Record&);
  std::multimap<Key, Record> waiting_;
  SimTime read_until_ = SimTime::from_ns(-1);
  bool exhausted_ = false;
};

}  // namespace seam::scheduler
