#include "measurement/imaging/light_store.h"

#include <algorithm>

#include "effects/exact_key.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

// What the light depends on: every effect before the sensor, with its exact values.
std::string light_key(const effects::Model& model) {
  std::string key;
  for (const effects::ModelEffect& effect : model.effects()) {
    const effects::Stage stage = effect.definition->stage;
    if (stage != effects::Stage::sensor && stage != effects::Stage::detector)
      key += effects::exact_key(effect);
  }
  return key;
}

}  // namespace

LightStore::LightStore(size_t frames, int width_px, int height_px, Render render)
    : frames_(frames), render_(std::move(render)) {
  const size_t bytes =
      static_cast<size_t>(width_px) * static_cast<size_t>(height_px) * 3 * sizeof(float) * frames;
  capacity_ = std::clamp<size_t>(200'000'000 / std::max<size_t>(bytes, 1), 4, 64);
}

std::vector<LightImage> LightStore::light(const effects::Model& model,
                                          const std::vector<size_t>& frames) const {
  const std::string key = light_key(model);
  std::vector<LightImage> out(frames.size());
  const auto find_entry = [&]() -> Entry& {
    const auto found = std::find_if(entries_.begin(), entries_.end(),
                                    [&](const Entry& entry) { return entry.key == key; });
    if (found == entries_.end()) {
      entries_.push_front({key, std::vector<LightImage>(frames_)});
      if (entries_.size() > capacity_) entries_.pop_back();
    } else {
      entries_.splice(entries_.begin(), entries_, found);
    }
    return entries_.front();
  };
  std::vector<size_t> missing;
  {
    const std::scoped_lock lock(mutex_);
    const Entry& entry = find_entry();
    for (size_t i = 0; i < frames.size(); ++i) {
      out[i] = entry.frames[frames[i]];
      if (!out[i]) missing.push_back(frames[i]);
    }
  }
  if (missing.empty()) return out;
  const std::vector<LightImage> rendered = render_(model, missing);
  const std::scoped_lock lock(mutex_);
  Entry& entry = find_entry();
  for (size_t k = 0; k < missing.size(); ++k) entry.frames[missing[k]] = rendered[k];
  for (size_t i = 0; i < frames.size(); ++i) {
    if (!out[i]) out[i] = entry.frames[frames[i]];
  }
  return out;
}

}  // namespace seam::measurement
