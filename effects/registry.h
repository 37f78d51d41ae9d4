// The catalogue of effects, in the order in which they compose.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "effects/effect.h"

namespace seam::effects {

// All known effects: the catalogue and what plugins registered.
const std::vector<std::shared_ptr<const EffectDefinition>>& catalogue();

// Null where the name is unknown.
std::shared_ptr<const EffectDefinition> find_effect(const std::string& name);
std::vector<std::string> effect_names();

// Adds a plugin's effect behind the catalogue; throws InputError if the name is taken.
void register_effect(EffectDefinition definition);

}  // namespace seam::effects
