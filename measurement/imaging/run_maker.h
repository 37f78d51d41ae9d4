// Whole runs of the simulator, as sets of kind `outcomes` ask for them: a plan of runs
// (seam-sweep/1) with another model in the place of its robots'.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "effects/model.h"

namespace seam::measurement {

// What runs kept, in the order of the plan: by run, by column; NaN where a run gave no number.
struct RunTable {
  std::vector<std::vector<double>> runs;
  std::string first_error;  // Why the first run that failed did; empty: none failed.
};

struct RunPlan {
  std::string name;            // Of the set's scenario.
  std::filesystem::path file;  // seam-sweep/1
};

struct RunSpec {
  std::vector<RunPlan> plans;
  std::vector<std::string> robots;  // Whose model it is; empty: of all robots.
};

class RunMaker {
 public:
  virtual ~RunMaker() = default;

  // By plan: the names of what its runs keep, and how many runs it has.
  virtual std::vector<std::string> columns(size_t plan) const = 0;
  virtual uint64_t runs(size_t plan) const = 0;
  // So many runs that follow each other have the same settings but for their seeds.
  virtual uint64_t alike(size_t plan) const = 0;
  // All that the plan is made of, by name beside it: its scenario as one whole document.
  virtual std::map<std::string, std::string> files(size_t plan) const = 0;

  // Makes all runs of the plan; of equal plan, model and draw, equal tables. `draw` 0: the plan's
  // own seeds, the same whatever the model; others: seeds of their own. Thread-safe. Throws
  // InputError where runs cannot be made at all.
  virtual RunTable make(size_t plan, const effects::Model& model, uint64_t draw) = 0;
};

}  // namespace seam::measurement
