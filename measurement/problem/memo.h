// Predictions that are asked for again: a fit of a spread, a score after a fit, a held-out fold and
// a structure test all ask for the same mean. Values are pure functions of their keys, so what is
// kept changes no result. Safe in several threads.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace seam::measurement {

template <class Value>
class Memo {
 public:
  // In each slot (a run, a group) the last few values are kept.
  explicit Memo(size_t slots, size_t kept = 8) : slots_(slots), kept_(kept) {}

  template <class Compute>
  std::shared_ptr<const Value> of(size_t slot, const std::vector<double>& key,
                                  const Compute& compute) const {
    if (auto found = find(slot, key)) return found;
    auto value = std::make_shared<const Value>(compute());
    const std::lock_guard lock(mutex_);
    std::vector<Entry>& entries = slots_[slot];
    if (entries.size() < kept_) {
      entries.push_back({key, value, ++clock_});
    } else {
      *std::min_element(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
        return a.used < b.used;
      }) = {key, value, ++clock_};
    }
    return value;
  }

 private:
  struct Entry {
    std::vector<double> key;
    std::shared_ptr<const Value> value;
    uint64_t used = 0;
  };

  std::shared_ptr<const Value> find(size_t slot, const std::vector<double>& key) const {
    const std::lock_guard lock(mutex_);
    for (Entry& entry : slots_[slot]) {
      if (entry.key != key) continue;
      entry.used = ++clock_;
      return entry.value;
    }
    return nullptr;
  }

  mutable std::mutex mutex_;
  mutable std::vector<std::vector<Entry>> slots_;
  mutable uint64_t clock_ = 0;  // Of uses.
  size_t kept_;
};

}  // namespace seam::measurement
