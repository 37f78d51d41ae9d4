// For tests: plans beside the project's own scenarios.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "app/scratch_folder.h"
#include "app/sweep/plan/plan.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"

namespace seam::app {

inline const std::string kSource = SEAM_SOURCE_DIR;

// A folder with a plan of these lines after format and scenario.
class PlanFolder {
 public:
  explicit PlanFolder(const std::string& lines, const std::string& scenario = "head_swing.yaml") {
    write("plan.yaml", "format: seam-sweep/1\nscenario: " + kSource + "/scenarios/" + scenario +
                           "\n" + lines + "\n");
  }
  void write(const std::string& name, const std::string& text) const {
    write_file_atomically(path(name), text);
  }
  std::filesystem::path path(const std::string& name) const { return scratch_.path() / name; }
  SweepPlan plan() const { return SweepPlan::from_file(path("plan.yaml")); }
  std::string why_not() const {
    try {
      plan();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

 private:
  ScratchFolder scratch_{"plan"};
};

}  // namespace seam::app
