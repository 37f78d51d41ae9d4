// OSubject: a buffer for each observer, sent when the observer is ready.
#include <OPENR/OSubject.h>

#include <algorithm>

#include "open_r/library/system.h"

using seam::open_r::System;

namespace {

size_t room_for(size_t units, size_t unit, size_t most) {
  return std::max(unit, std::min(units * unit, most));
}

// Gives a copy of a buffer to `take`, which may keep it.
template <class Take>
OStatus with_copy(const void* buffer, size_t size, Take take) {
  auto* region = new RCRegion(size);
  std::copy_n(static_cast<const char*>(buffer), size, region->Base());
  const OStatus status = take(region);
  region->RemoveReference();
  return status;
}

}  // namespace

OSubject::OSubject() : buffer_size_(MAX_NUM_DATA), unit_(1) {}

OSubject::~OSubject() {
  ClearBuffer();
}

OStatus OSubject::SetReadyEntry(const OServiceEntry& entry) {
  id_ = entry;
  return oSUCCESS;
}

OStatus OSubject::SetBufferSize(size_t size) {
  buffer_size_ = std::clamp<size_t>(size, 1, MAX_NUM_DATA);
  return oSUCCESS;
}

OStatus OSubject::SetNotifyUnitSize(size_t size) {
  unit_ = std::clamp<size_t>(size, 1, MAX_NUM_DATA);
  return oSUCCESS;
}

ObserverIterator OSubject::find(const ObserverID& id) {
  return std::find_if(observers_.begin(), observers_.end(),
                      [&](const OObserverInfo& o) { return o.id_ == id; });
}

ObserverConstIterator OSubject::FindObserver(const ObserverID& id) const {
  return std::find_if(observers_.begin(), observers_.end(),
                      [&](const OObserverInfo& o) { return o.id_ == id; });
}

// ---- Data ----

OStatus OSubject::keep(OObserverInfo& observer, RCRegion* region) {
  if (region == nullptr) return oINVALID_ARG;
  if (observer.skipped_ < observer.skip_) {
    ++observer.skipped_;
    return oSUCCESS;
  }
  observer.skipped_ = 0;
  while (observer.waiting_.size() >= room_for(observer.max_, unit_, buffer_size_)) {
    observer.waiting_.front()->RemoveReference();
    observer.waiting_.pop_front();
  }
  region->AddReference();
  observer.waiting_.push_back(region);
  return oSUCCESS;
}

OStatus OSubject::SetData(RCRegion* region) {
  if (region == nullptr) return oINVALID_ARG;
  for (OObserverInfo& observer : observers_) keep(observer, region);
  return oSUCCESS;
}

OStatus OSubject::SetData(const OObserverInfo& observer, RCRegion* region) {
  return SetData(observer.id_, region);
}

OStatus OSubject::SetData(const ObserverID& id, RCRegion* region) {
  const ObserverIterator observer = find(id);
  return observer == observers_.end() ? oNOT_FOUND : keep(*observer, region);
}

OStatus OSubject::SetData(const void* buffer, size_t size) {
  return with_copy(buffer, size, [&](RCRegion* region) { return SetData(region); });
}

OStatus OSubject::SetData(const OObserverInfo& observer, const void* buffer, size_t size) {
  return SetData(observer.id_, buffer, size);
}

OStatus OSubject::SetData(const ObserverID& observer, const void* buffer, size_t size) {
  return with_copy(buffer, size, [&](RCRegion* region) { return SetData(observer, region); });
}

void OSubject::clear(OObserverInfo& observer) {
  for (RCRegion* region : observer.waiting_) region->RemoveReference();
  observer.waiting_.clear();
  observer.notified_ = 0;
}

OStatus OSubject::ClearBuffer() {
  for (OObserverInfo& observer : observers_) clear(observer);
  return oSUCCESS;
}

OStatus OSubject::ClearBuffer(const OObserverInfo& observer) {
  return ClearBuffer(observer.id_);
}

OStatus OSubject::ClearBuffer(const ObserverID& id) {
  const ObserverIterator observer = find(id);
  if (observer == observers_.end()) return oNOT_FOUND;
  clear(*observer);
  return oSUCCESS;
}

size_t OSubject::RemainBuffer(const OObserverInfo& observer) const {
  const size_t room = room_for(observer.max_, unit_, buffer_size_);
  return room - std::min(room, observer.waiting_.size());
}

size_t OSubject::RemainBuffer(const ObserverID& id) const {
  const ObserverConstIterator observer = FindObserver(id);
  return observer == observers_.end() ? 0 : RemainBuffer(*observer);
}

size_t OSubject::RemainBuffer() const {
  size_t least = observers_.empty() ? 0 : MAX_NUM_DATA;
  for (const OObserverInfo& observer : observers_) least = std::min(least, RemainBuffer(observer));
  return least;
}

// ---- Notifications ----

void OSubject::send_if_ready(OObserverInfo& observer) {
  if (observer.ready_ < 1 || observer.notified_ == 0) return;
  if (observer.waiting_.size() < observer.min_ * unit_ || observer.waiting_.empty()) return;
  auto message = std::make_shared<ONotifyMessage>();
  message->subjectID = id_;
  message->numOfNotify = static_cast<int>(observer.notified_);
  for (RCRegion* region : observer.waiting_) message->data[message->numOfData++] = region;
  observer.waiting_.clear();  // The message has their references now.
  observer.notified_ = 0;
  --observer.ready_;
  System::current().post(observer.id_, message);
}

OStatus OSubject::notify(OObserverInfo& observer) {
  if (observer.ready_ < 0) {
    clear(observer);
    return oSUCCESS;
  }
  if (!observer.waiting_.empty()) ++observer.notified_;
  send_if_ready(observer);
  return oSUCCESS;
}

OStatus OSubject::NotifyObservers() {
  for (OObserverInfo& observer : observers_) notify(observer);
  return oSUCCESS;
}

OStatus OSubject::NotifyObserver(const OObserverInfo& observer) {
  return NotifyObserver(observer.id_);
}

OStatus OSubject::NotifyObserver(const ObserverID& id) {
  const ObserverIterator observer = find(id);
  return observer == observers_.end() ? oNOT_FOUND : notify(*observer);
}

// ---- Who is ready ----

int OSubject::IsAnyReady() const {
  return std::any_of(observers_.begin(), observers_.end(),
                     [](const OObserverInfo& o) { return o.ready_ > 0; });
}

int OSubject::IsAllReady() const {
  return IsAnyReady() && std::none_of(observers_.begin(), observers_.end(),
                                      [](const OObserverInfo& o) { return o.ready_ == 0; });
}

int OSubject::IsReady(const ObserverID& id) const {
  return ReadyStatus(id) > 0;
}

int OSubject::ReadyStatus(const ObserverID& id) const {
  const ObserverConstIterator observer = FindObserver(id);
  return observer == observers_.end() ? 0 : observer->ready_;
}

OStatus OSubject::ControlHandler(const OControlMessage& message, OStatus status) {
  if (status != oSUCCESS || message.command != objcommCMD_ADDOBSERVER) return oREFUSED;
  OObserverInfo observer;
  observer.id_ = message.observerID;
  observer.skip_ = observer.skipped_ = message.skip;
  observer.min_ = std::max<size_t>(1, message.min);
  observer.max_ = std::max(observer.min_, message.max);
  observers_.push_back(observer);
  message.answer = id_;
  return oSUCCESS;
}

OStatus OSubject::ReadyHandler(const OReadyMessage& message) {
  const ObserverIterator observer = find(message.observerID);
  if (observer == observers_.end()) return oNOT_FOUND;
  if (message.command == objcommCMD_ASSERT_READY) {
    observer->ready_ = std::max(0, observer->ready_) + 1;
    send_if_ready(*observer);
  } else {
    observer->ready_ = -1;
    clear(*observer);
  }
  return oSUCCESS;
}
