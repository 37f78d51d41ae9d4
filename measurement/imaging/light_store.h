// Light on the sensor for models, each rendered once: many models of a search differ in their
// sensor alone.
#pragma once

#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "effects/model.h"

namespace seam::measurement {

// Row-major, red, green and blue interleaved.
using LightImage = std::shared_ptr<const std::vector<float>>;

class LightStore {
 public:
  // Renders these frames; may be called from several threads at once.
  using Render = std::function<std::vector<LightImage>(const effects::Model&,
                                                       const std::vector<size_t>& frames)>;

  LightStore(size_t frames, int width_px, int height_px, Render render);
  std::vector<LightImage> light(const effects::Model& model,
                                const std::vector<size_t>& frames) const;

 private:
  struct Entry {
    std::string key;
    std::vector<LightImage> frames;
  };
  size_t frames_;
  Render render_;
  size_t capacity_;
  mutable std::mutex mutex_;
  mutable std::list<Entry> entries_;  // Most recently used first.
};

}  // namespace seam::measurement
