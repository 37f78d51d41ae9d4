// What a plan varies: one entry of `vary`, a list of settings of which each run has one. Settings
// are worked out when they are asked for, so that a long range costs nothing.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "app/scenario_tree.h"
#include "app/sweep/plan/plan_files.h"
#include "sim_core/base/config.h"

namespace seam::app {

// A parameter of a plan: its name in tables and formulas, and the paths that all take its value.
struct SweepParameter {
  std::string name;
  std::vector<std::string> paths;
  bool takes_file = false;  // Its plain values name files.
};

struct Axis {
  std::vector<SweepParameter> parameters;  // All of them change together.
  uint64_t size = 0;
  // Of a parameter in a setting; a pure function.
  std::function<WrittenValue(size_t parameter, uint64_t setting)> value;
};

// Reads an entry of `vary`: `values`, `range`, a distribution with `draws`, several of those under
// `of`, or a `table`. Throws InputError naming file, line and key.
Axis read_axis(const ConfigNode& entry, PlanFiles& files);
// `seeds: [first, last]`.
Axis seed_axis(const ConfigNode& seeds);

// A value as a plan states it.
WrittenValue written(const ConfigNode& value);

}  // namespace seam::app
