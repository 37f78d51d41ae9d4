// Commands or sounds on their way out: those of one subject one after the other without a gap,
// those of several side by side. A subject hears READY each time that one of its data is finished.
#pragma once

#include <OPENR/OObserver.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <map>

#include "open_r/robot/sync_keys.h"

namespace seam::open_r {

class OutputQueue {
 public:
  // How many frames of 8 ms the data take, at least one.
  using Duration = std::function<int64_t(RCRegion&)>;
  // Puts out frame `index` of the data, which began with frame number `first`.
  using Put = std::function<void(RCRegion&, int64_t index, int64_t first)>;

  OutputQueue(SyncKeys& keys, Duration duration, Put put)
      : keys_(keys), duration_(std::move(duration)), put_(std::move(put)) {}
  ~OutputQueue();
  OutputQueue(const OutputQueue&) = delete;
  OutputQueue& operator=(const OutputQueue&) = delete;

  void receive(const ONotifyEvent& event);
  // Ends what is finished when this frame begins; READY goes out for each.
  void finish(int64_t frame, OObserver& observer);
  // Puts out what belongs to this frame.
  void put(int64_t frame);

 private:
  struct Item {
    RCRegion* region;
    int64_t frames;
    int64_t start = -1;  // -1: not begun.
  };
  void begin_front(std::deque<Item>& items, int64_t frame);

  SyncKeys& keys_;
  Duration duration_;
  Put put_;
  std::map<SubjectID, std::deque<Item>> items_;
};

}  // namespace seam::open_r
