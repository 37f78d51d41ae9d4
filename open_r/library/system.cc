#include "open_r/library/system.h"

#include <cstdio>
#include <cstring>

namespace seam::open_r {
namespace {

constexpr longword kFirstObject = 0x80000040;
// In one frame of 8 ms: no robot handled that many, and a program that sends in circles never ends.
constexpr int kMostMessages = 1'000'000;

// OPEN-R's calls are free functions, so that the system they mean is one of the process.
System* newest = nullptr;

// "A.B.C.S": the name of the data, C.
std::string data_of(const std::string& service) {
  const size_t end = service.rfind('.');
  if (end == std::string::npos || end == 0) return "";
  const size_t begin = service.rfind('.', end - 1);
  return begin == std::string::npos ? "" : service.substr(begin + 1, end - begin - 1);
}

}  // namespace

System& System::current() {
  if (newest == nullptr) throw Fault("a call of OPEN-R outside of an object");
  return *newest;
}

System::System() : before_(newest) {
  newest = this;
}

System::~System() {
  for (const auto& [id, region] : shared_regions_) region->RemoveReference();
  newest = before_;
}

OID System::begin_object(const std::string& name) {
  const OID object(kFirstObject + static_cast<longword>(objects_.size()));
  objects_[object].name = name;
  running_ = object;
  return object;
}

void System::end_object(OID object, Handler handler) {
  objects_[object].handler = std::move(handler);
  running_.MakeInvalid();
}

OID System::add(const std::string& name, Handler handler) {
  const OID object = begin_object(name);
  end_object(object, std::move(handler));
  return object;
}

const std::string& System::name(OID object) const {
  return objects_.at(object).name;
}

OStatus System::register_service(const OServiceEntry& entry, const std::string& name) {
  return services_.emplace(name, entry).second ? oSUCCESS : oALREADY_EXIST;
}

const OServiceEntry* System::find_service(const std::string& name) const {
  const auto found = services_.find(name);
  return found == services_.end() ? nullptr : &found->second;
}

bool System::connect(const std::string& subject, const std::string& observer) {
  const OServiceEntry* from = find_service(subject);
  const OServiceEntry* to = find_service(observer);
  const auto refuse = [&](const std::string& why) {
    std::printf("CONNECT.CFG: %s %s: not connected: %s\n", subject.c_str(), observer.c_str(),
                why.c_str());
    return false;
  };
  if (from == nullptr) return refuse("no object has the service " + subject);
  if (to == nullptr) return refuse("no object has the service " + observer);
  if (data_of(subject) != data_of(observer))
    return refuse("the names of their data differ, expected the same");
  OConnectMessage message;
  message.entry = *from;
  std::strncpy(message.subName, subject.c_str(), oserviceNAME_MAX);
  message.subName[oserviceNAME_MAX] = '\0';
  call(*to, &message);
  return true;
}

void System::call(const OServiceEntry& entry, void* message) {
  const auto object = objects_.find(entry.oid);
  if (object == objects_.end() || !object->second.handler) return;
  const OID caller = running_;
  running_ = entry.oid;
  object->second.handler(entry.selector, message);
  running_ = caller;
}

void System::post(const OServiceEntry& entry, std::shared_ptr<void> message,
                  std::vector<RCRegion*> given_back) {
  messages_.push_back({entry, std::move(message), std::move(given_back)});
}

void System::deliver() {
  for (int handled = 0; !messages_.empty(); ++handled) {
    Message message = std::move(messages_.front());
    messages_.pop_front();
    if (handled == kMostMessages)
      throw Fault("the objects sent " + std::to_string(kMostMessages) +
                  " messages within one frame of 8 ms, the last one to " + name(message.entry.oid) +
                  ": an object that answers each message with another one waits for a frame in "
                  "between");
    for (RCRegion* region : message.given_back) region->RemoveReference();
    call(message.entry, message.content.get());
  }
}

}  // namespace seam::open_r
