#include "measurement/problem/fit_key.h"

#include "effects/exact_key.h"

namespace seam::measurement {

std::string fit_key(const Model& model, const std::vector<Unknown>& unknowns,
                    const Groups& groups) {
  std::string key(groups.begin(), groups.end());
  for (const effects::ModelEffect& effect : model.effects()) key += effects::exact_key(effect);
  for (const Unknown& unknown : unknowns)
    key += fmt::format(";{}.{}", unknown.effect, unknown.parameter);
  return key;
}

}  // namespace seam::measurement
