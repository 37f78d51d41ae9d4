#include "open_r/robot/output_queue.h"

#include <OPENR/ODataVector.h>

#include <algorithm>

namespace seam::open_r {
namespace {

const ODataVectorInfo& header_of(const RCRegion& region) {
  return *reinterpret_cast<const ODataVectorInfo*>(region.Base());
}

}  // namespace

OutputQueue::~OutputQueue() {
  for (auto& [subject, items] : items_)
    for (const Item& item : items) item.region->RemoveReference();
}

void OutputQueue::receive(const ONotifyEvent& event) {
  for (int i = 0; i < event.NumOfData(); ++i) {
    RCRegion* region = event.RCData(i);
    region->AddReference();
    items_[event.SenderID()].push_back({region, std::max<int64_t>(1, duration_(*region))});
  }
}

void OutputQueue::finish(int64_t frame, OObserver& observer) {
  for (auto& [subject, items] : items_) {
    while (!items.empty() && items.front().start >= 0 &&
           frame >= items.front().start + items.front().frames) {
      items.front().region->RemoveReference();
      items.pop_front();
      observer.AssertReady(subject);
      // What waits behind begins with this frame; it must not end before it has begun.
      if (!items.empty() && items.front().start < 0) break;
    }
  }
}

void OutputQueue::begin_front(std::deque<Item>& items, int64_t frame) {
  Item& front = items.front();
  if (front.start >= 0) return;
  const ODataVectorInfo& header = header_of(*front.region);
  if (!keys_.may_begin(header.syncKey)) return;
  front.start = frame + header.wait;
}

void OutputQueue::put(int64_t frame) {
  for (auto& [subject, items] : items_)
    if (!items.empty() && items.front().start < 0)
      keys_.arrive(header_of(*items.front().region).syncKey);
  for (auto& [subject, items] : items_) {
    if (items.empty()) continue;
    begin_front(items, frame);
    const Item& front = items.front();
    if (front.start < 0 || frame < front.start) continue;
    if (frame == front.start) keys_.begin(header_of(*front.region).syncKey);
    put_(*front.region, frame - front.start, front.start);
  }
}

}  // namespace seam::open_r
