#include "effects/exact_key.h"

namespace seam::effects {

std::string exact_key(const ModelEffect& effect) {
  std::string key = effect.definition->name;
  for (const double value : effect.values()) key += fmt::format(",{:a}", value);
  return key + ';';
}

}  // namespace seam::effects
