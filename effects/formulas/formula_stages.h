// The stages that formulas may act at.
#pragma once

#include <string>
#include <vector>

namespace seam::effects {

struct FormulaStage {
  std::string name;
  std::vector<std::string> variables;
  // Each is a variable too, but for gain, which multiplies, and torque, which adds.
  std::vector<std::string> outputs;
  unsigned kinds = 0;  // Of measurement, on which they act.
};
// A stage at which formulas may act at two places stands once for each.
std::vector<FormulaStage> formula_stages();

// What a formula of this output says that changes nothing: "u", "1" of a gain, "0" of a torque.
std::string formula_without_change(const std::string& output);

}  // namespace seam::effects
