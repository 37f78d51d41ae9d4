// The catalogue of effects, in the order in which they compose.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "effects/effect.h"

namespace seam::effects {

class Model;

// All known effects: the catalogue and what plugins registered.
const std::vector<std::shared_ptr<const EffectDefinition>>& catalogue();

// Null where the name is unknown. Of several cameras on a rig one may have an effect of its own:
// `pinhole@right` is `pinhole` of the camera "right" alone, and goes before a plain `pinhole`,
// which is that of all cameras.
std::shared_ptr<const EffectDefinition> find_effect(const std::string& name);
// Its camera; empty: it is that of all.
std::string camera_of(const std::string& effect);
std::string plain_name(const std::string& effect);
// Whether some camera has both: neither is another's, nor overridden by one of its own.
bool meet(const std::string& a, const std::string& b, const Model& model);
std::vector<std::string> effect_names();

// Adds a plugin's effect behind the catalogue; throws InputError if the name is taken.
void register_effect(EffectDefinition definition);

}  // namespace seam::effects
