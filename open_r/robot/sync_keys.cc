#include "open_r/robot/sync_keys.h"

namespace seam::open_r {

std::optional<OVRSyncKey> SyncKeys::make() {
  if (groups_.size() >= ovrsynckeyMAX_SIZE) return std::nullopt;
  const int group = next_group_++;
  const OVRSyncKey key = next_++;
  group_of_[key] = group;
  groups_[group].parts.insert(key);
  return key;
}

bool SyncKeys::cancel(OVRSyncKey key) {
  const auto found = group_of_.find(key);
  if (found == group_of_.end()) return false;
  Group& group = groups_[found->second];
  group.parts.erase(key);
  group.arrived.erase(key);
  if (group.parts.empty()) groups_.erase(found->second);
  group_of_.erase(found);
  return true;
}

std::optional<std::pair<OVRSyncKey, OVRSyncKey>> SyncKeys::divide(OVRSyncKey key) {
  const auto found = group_of_.find(key);
  if (found == group_of_.end()) return std::nullopt;
  const int number = found->second;
  Group& group = groups_[number];
  if (group.parts.size() >= ovrsynckeyMAX_NUM_DIVISION) return std::nullopt;
  group.parts.erase(key);
  group_of_.erase(found);
  const OVRSyncKey first = next_++, second = next_++;
  for (const OVRSyncKey part : {first, second}) {
    group.parts.insert(part);
    group_of_[part] = number;
  }
  return std::pair{first, second};
}

void SyncKeys::arrive(OVRSyncKey key) {
  const auto found = group_of_.find(key);
  if (found != group_of_.end()) groups_[found->second].arrived.insert(key);
}

bool SyncKeys::may_begin(OVRSyncKey key) const {
  const auto found = group_of_.find(key);
  if (found == group_of_.end()) return true;
  const Group& group = groups_.at(found->second);
  return group.arrived.size() == group.parts.size();
}

void SyncKeys::begin(OVRSyncKey key) {
  const auto found = group_of_.find(key);
  if (found == group_of_.end()) return;
  Group& group = groups_[found->second];
  group.begun.insert(key);
  if (group.begun.size() < group.parts.size()) return;
  const int number = found->second;
  for (const OVRSyncKey part : group.parts) group_of_.erase(part);
  groups_.erase(number);
}

}  // namespace seam::open_r
