#include "effects/model.h"

namespace seam::effects {

std::shared_ptr<const EffectDefinition> expression_effect(const std::string&, const ConfigNode& node) {
  node.fail("expression effects are not supported yet");
}

std::string expression_source(const EffectDefinition&) { return ""; }

}  // namespace seam::effects
