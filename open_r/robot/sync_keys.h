// Keys by which commands and sounds of several objects begin at one time: a key is divided until
// each has a part, and all begin when each part has come.
#pragma once

#include <OPENR/OPENR.h>

#include <map>
#include <optional>
#include <set>
#include <utility>

namespace seam::open_r {

class SyncKeys {
 public:
  std::optional<OVRSyncKey> make();  // None while eight are in use.
  bool cancel(OVRSyncKey key);
  std::optional<std::pair<OVRSyncKey, OVRSyncKey>> divide(OVRSyncKey key);

  // Data with this key may begin, as soon as all that share it are there. A key that is not known
  // holds nothing back.
  void arrive(OVRSyncKey key);
  bool may_begin(OVRSyncKey key) const;
  // Data with this key have begun.
  void begin(OVRSyncKey key);

 private:
  struct Group {
    std::set<OVRSyncKey> parts, arrived, begun;
  };
  std::map<OVRSyncKey, int> group_of_;
  std::map<int, Group> groups_;
  OVRSyncKey next_ = 1;
  int next_group_ = 0;
};

}  // namespace seam::open_r
