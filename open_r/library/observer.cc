// OObserver: says when it is ready, and keeps what it was sent until then.
#include <OPENR/OObserver.h>

#include "open_r/library/system.h"

using seam::open_r::System;

OObserver::OObserver() : skip_(0), min_(1), max_(1) {}

OObserver::~OObserver() {
  for (const Held& held : held_) held.region->RemoveReference();
}

OStatus OObserver::SetNotifyEntry(const OServiceEntry& entry) {
  id_ = entry;
  return oSUCCESS;
}

void OObserver::SetBufCtrlParam(size_t skip, size_t min, size_t max) {
  skip_ = skip;
  min_ = min;
  max_ = max;
}

OStatus OObserver::send(ObjcommCommand command, const SubjectID& subject) {
  // What was held goes back with the message: the subject sees it free when it hears of it.
  std::vector<RCRegion*> given_back;
  for (auto held = held_.begin(); held != held_.end();) {
    if (held->subject != subject) {
      ++held;
      continue;
    }
    given_back.push_back(held->region);
    held = held_.erase(held);
  }
  System::current().post(subject, std::make_shared<OReadyMessage>(command, id_),
                         std::move(given_back));
  return oSUCCESS;
}

OStatus OObserver::send_all(ObjcommCommand command) {
  for (const OSubjectInfo& subject : subjects_) send(command, subject);
  return oSUCCESS;
}

OStatus OObserver::AssertReady() {
  return send_all(objcommCMD_ASSERT_READY);
}
OStatus OObserver::AssertReady(const SubjectID& subject) {
  return send(objcommCMD_ASSERT_READY, subject);
}
OStatus OObserver::DeassertReady() {
  return send_all(objcommCMD_DEASSERT_READY);
}
OStatus OObserver::DeassertReady(const SubjectID& subject) {
  return send(objcommCMD_DEASSERT_READY, subject);
}

OStatus OObserver::ConnectHandler(const OConnectMessage& message, OStatus status) {
  if (status != oSUCCESS || message.command != oconnectcmdCONNECT) return oREFUSED;
  OControlMessage control;
  control.observerID = id_;
  control.skip = skip_;
  control.min = min_;
  control.max = max_;
  memcpy(control.subName, message.subName, sizeof control.subName);
  System::current().call(message.entry, &control);
  if (!control.answer.IsValid()) return oREFUSED;
  subjects_.push_back(OSubjectInfo(control.answer));
  return oSUCCESS;
}

OStatus OObserver::NotifyHandler(const ONotifyMessage& message, ONotifyEvent* event) {
  for (int i = 0; i < message.numOfData; ++i) held_.push_back({message.subjectID, message.data[i]});
  event->Set(message.subjectID, message.numOfData, message.numOfNotify, message.data);
  return oSUCCESS;
}
