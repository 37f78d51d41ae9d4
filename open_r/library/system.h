// The objects of one robot and the messages between them. Each object handles one message at a
// time, and messages are handled in the order in which they were sent, so that a run repeats.
#pragma once

#include <MCOOP.h>
#include <OPENR/OSubject.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "open_r/files/fault.h"

namespace seam::open_r {

class System {
 public:
  // Handles a message that came to an entry of the object.
  using Handler = std::function<void(Selector, void* message)>;

  // The system that OPEN-R's free functions talk to, the newest one of this process.
  static System& current();

  System();
  ~System();
  System(const System&) = delete;
  System& operator=(const System&) = delete;

  // ---- Objects ----
  // An object that is about to be made: what its constructors ask for is its own.
  OID begin_object(const std::string& name);
  void end_object(OID object, Handler handler);
  OID add(const std::string& name, Handler handler);
  // The object whose code runs now.
  OID running() const { return running_; }
  const std::string& name(OID object) const;

  // ---- Services and their connections ----
  OStatus register_service(const OServiceEntry& entry, const std::string& name);
  // Lines of CONNECT.CFG. False, with a line for people, where an end is not there.
  bool connect(const std::string& subject, const std::string& observer);

  // ---- Messages ----
  // Handled at once, within what runs.
  void call(const OServiceEntry& entry, void* message);
  // Handled in its turn. `given_back`: references that end when the message is handled.
  void post(const OServiceEntry& entry, std::shared_ptr<void> message,
            std::vector<RCRegion*> given_back = {});
  // Handles messages until there is none. Throws Fault where they do not end.
  void deliver();

  // ---- Time, and the rest ----
  int64_t now_ns() const { return now_ns_; }
  void set_now_ns(int64_t now_ns) { now_ns_ = now_ns; }
  MemoryRegionID next_region() { return ++last_region_; }
  // What objects share by its number alone.
  std::map<MemoryRegionID, RCRegion*>& shared_regions() { return shared_regions_; }

 private:
  struct Object {
    std::string name;
    Handler handler;
  };
  struct Message {
    OServiceEntry entry;
    std::shared_ptr<void> content;
    std::vector<RCRegion*> given_back;
  };
  const OServiceEntry* find_service(const std::string& name) const;

  System* before_;
  std::map<OID, Object> objects_;
  std::map<std::string, OServiceEntry> services_;
  std::deque<Message> messages_;
  OID running_;
  int64_t now_ns_ = 0;
  MemoryRegionID last_region_ = 0;
  std::map<MemoryRegionID, RCRegion*> shared_regions_;
};

}  // namespace seam::open_r
