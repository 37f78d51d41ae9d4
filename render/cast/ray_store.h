// Rays of cameras that many models share: a search renders hundreds that differ in anything but the
// lens, and finding the rays costs as much as a frame.
#pragma once

#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>

#include "render/cast/ray_table.h"

namespace seam::render {

class RayStore {
 public:
  using Rays = std::shared_ptr<const CameraRays>;

  // Those of this key, made once. May be called from several threads at once.
  Rays get(const std::string& key, const std::function<CameraRays()>& make);

 private:
  std::mutex mutex_;
  std::list<std::pair<std::string, Rays>> entries_;  // Most recently used first.
};

}  // namespace seam::render
