#include "render/cast/ray_store.h"

#include <algorithm>

namespace seam::render {

RayStore::Rays RayStore::get(const std::string& key, const std::function<CameraRays()>& make) {
  constexpr size_t kMost = 16;  // About a megabyte each, for small images.
  {
    const std::scoped_lock lock(mutex_);
    const auto found = std::find_if(entries_.begin(), entries_.end(),
                                    [&](const auto& entry) { return entry.first == key; });
    if (found != entries_.end()) {
      entries_.splice(entries_.begin(), entries_, found);
      return found->second;
    }
  }
  Rays made = std::make_shared<const CameraRays>(make());
  const std::scoped_lock lock(mutex_);
  entries_.emplace_front(key, made);
  if (entries_.size() > kMost) entries_.pop_back();
  return made;
}

}  // namespace seam::render
