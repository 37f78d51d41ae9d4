// What a plan keeps of each run: its summary, what clients logged, formulas over both, and files.
#pragma once

#include <array>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "app/session/logged_values.h"
#include "effects/formulas/formula.h"
#include "sim_core/base/config.h"
#include "sim_core/scenario/scenario.h"

namespace seam::app {

// The columns of a summary, in the order of tables. `seed` is the one that the run had.
inline constexpr std::array<const char*, 8> kSummaryColumns = {
    "seed", "end", "sim_s", "frames", "decisions", "fingerprint", "red_score", "blue_score"};

struct KeptValue {
  std::string column;
  std::string robot;
  std::string name;  // As its client logs it.
  Statistic statistic = Statistic::last;
  bool optional = false;  // Not all runs log it.
  std::string where;      // In the plan, for errors.
};

struct KeptFormula {
  std::string column;
  effects::Formula formula;
  std::vector<std::string> reads;  // In the formula's order of variables.
};

struct Keep {
  std::vector<std::string> summary;  // Columns of a table; results hold all of them.
  std::vector<KeptValue> values;
  std::vector<KeptFormula> formulas;
  bool logs = false;    // Each run's replay log.
  bool frames = false;  // Each run's frames as pictures.

  // Names of values and formulas, in this order.
  std::vector<std::string> columns() const;
};

// Reads `keep:`; `node` may be missing. `parameters` are the plan's names, which formulas may read
// beside what is kept and the summary's numbers; `without_number`: those of them that are no number
// in any run.
Keep read_keep(const std::optional<ConfigNode>& node, const Scenario& scenario,
               const std::vector<std::string>& parameters,
               const std::set<std::string>& without_number = {});

}  // namespace seam::app
