// The effects that a file lists, counted before any of them is read.
#pragma once

#include <string>
#include <vector>

#include "sim_core/base/config.h"
#include "sim_core/base/error.h"

namespace seam::effects {

// The names in a file's map of effects; fails where there are more effects or formulas than a model
// may have, before any is looked up or compiled.
inline std::vector<std::string> effect_keys(const ConfigNode& effects) {
  constexpr size_t kMostEffects = 1000, kMostFormulas = 200;
  std::vector<std::string> names = effects.keys();
  if (names.size() > kMostEffects)
    effects.fail(fmt::format("found {} effects, expected {} at most", names.size(), kMostEffects));
  size_t formulas = 0;
  for (const std::string& name : names) {
    const ConfigNode node = effects.at(name);
    if (!node.is_map() || !node.has("stage")) continue;
    const auto settings = node.find("set");
    formulas += settings && settings->is_map() ? settings->keys().size() : 1;
  }
  // Each costs milliseconds to compile, and every thread that evaluates it keeps it.
  if (formulas > kMostFormulas)
    effects.fail(fmt::format("found {} formulas, expected {} at most", formulas, kMostFormulas));
  return names;
}

}  // namespace seam::effects
