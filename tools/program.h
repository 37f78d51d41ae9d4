// What every program does around its work.
#pragma once

#include <functional>
#include <string>

namespace seam::tools {

// Runs `work` and returns the program's exit code: its own, that of an ExitCode, 2 after a
// UsageError, 1 after any other error, and 1 where standard output could not be written. Standard
// streams that are closed lead to /dev/null, so that no file which is opened later takes their
// place.
int run_program(const std::string& name, const std::function<int()>& work);

}  // namespace seam::tools
