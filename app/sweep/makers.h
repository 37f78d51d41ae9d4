// What made a run: this program, its plugins, and the programs of the behaviours.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "app/sweep/plan/plan.h"
#include "app/sweep/results.h"

namespace seam::app {

// Fingerprints of programs and of the files that commands name, read once each.
class ProgramPrints {
 public:
  // Of the program and of all arguments that are files (a script, a table).
  std::string of(const std::vector<std::string>& command, const std::string& robot);
  const std::string& print_of(const std::string& file);

 private:
  std::map<std::string, std::string> prints_;
};

// Of this program with its plugins.
std::string program_print(ProgramPrints& prints);
// Throws InputError where a behaviour is not there.
Makers makers_of(const SweepPlan& plan, ProgramPrints& prints);

// What a sweep is known by among those made here (app/session/runs_made_here.h): all of its plan,
// and its programs.
std::vector<std::string> made_by(const SweepPlan& plan, const Makers& makers);

}  // namespace seam::app
