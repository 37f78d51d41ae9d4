// Text for people about effects: the help of one, the list of all, and the catalogue page.
#pragma once

#include <string>

#include "effects/effect.h"

namespace seam::effects {

// Everything about one effect: formula, parameters with units and bounds, signature, example.
std::string effect_help(const EffectDefinition& effect);
// Whether it has more values, as of a grid, than people read one by one: texts name the first
// alone.
bool has_many_values(const EffectDefinition& effect);
// One line an effect, by stage.
std::string catalogue_list();
// docs/reference/effects.md: made by `seam effects --markdown`, and compared with it by a test.
std::string catalogue_markdown();
// The words for the kinds of measurement of an effect.
std::string kinds_text(unsigned kinds);

// "kappa -0.1; x_m 0.3, z_m 1 -> u_px 135.1 (closed form)", for people.
std::string proof_text(const EffectDefinition& effect, const Proof& proof);

}  // namespace seam::effects
