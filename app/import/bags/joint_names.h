// The joints that a message names, kept once for all messages with the same ones.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace seam::app {

struct BagJointNames {
  std::vector<std::string> list;
  std::map<std::string, size_t> place;

  explicit BagJointNames(std::vector<std::string> names) : list(std::move(names)) {
    for (size_t i = 0; i < list.size(); ++i) place.try_emplace(list[i], i);
  }
  std::optional<size_t> find(const std::string& name) const {
    const auto found = place.find(name);
    return found == place.end() ? std::nullopt : std::optional(found->second);
  }
};
using SharedNames = std::shared_ptr<const BagJointNames>;

// `last` where it holds these names, else new ones in its place.
inline const SharedNames& share_names(SharedNames& last, std::vector<std::string> names) {
  if (!last || last->list != names) last = std::make_shared<const BagJointNames>(std::move(names));
  return last;
}

}  // namespace seam::app
