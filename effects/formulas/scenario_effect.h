// An effect that changes keys of a scenario: a setting of a behaviour, a clock, where something
// stands. It acts on whole runs alone (sets of outcomes); no image shows it.
#pragma once

#include <memory>
#include <string>

#include "effects/effect.h"
#include "sim_core/base/config.h"

namespace seam::effects {

// `stage: scenario`, with `parameters:` and `set: {PATH: FORMULA}`, formulas over the parameters.
// At neutral values nothing is set. Throws InputError naming file, line and key.
std::shared_ptr<const EffectDefinition> scenario_effect(const std::string& name,
                                                        const ConfigNode& node);

}  // namespace seam::effects
