// The stages that formulas may act at.
#pragma once

#include <string>
#include <vector>

namespace seam::effects {

struct FormulaStage {
  std::string name;
  std::vector<std::string> variables;
  std::vector<std::string> outputs;  // Each is a variable too, but for gain, which multiplies.
  unsigned kinds = 0;                // Of measurement, on which they act.
};
std::vector<FormulaStage> formula_stages();

}  // namespace seam::effects
