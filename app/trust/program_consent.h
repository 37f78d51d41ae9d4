// A log names programs, and whoever sends a log must not start programs on the machine of its
// reader: they are started when the user said so.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "sim_core/scenario/scenario.h"

namespace seam::app {

// The commands that the scenario would start, one line a robot, control characters shown.
std::vector<std::string> programs_of(const Scenario& scenario);

// Returns where there are none, where `agreed` (--run-programs), or where the user says yes to
// them: asked only where `terminal`. Throws UsageError otherwise, with the programs.
void require_consent(const std::vector<std::string>& programs, bool agreed, bool terminal,
                     std::istream& in, std::ostream& out);
// The same at this process's terminal, if it has one.
void require_consent(const std::vector<std::string>& programs, bool agreed);

}  // namespace seam::app
