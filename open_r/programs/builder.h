// Builds the objects of a program into a memory stick.
#pragma once

#include <functional>

#include "open_r/programs/compiler.h"
#include "open_r/programs/program_folder.h"

namespace seam::open_r {

struct BuildReport {
  int built = 0;
  std::vector<std::string> failed;   // Names of objects that did not compile or link.
  std::vector<std::string> missing;  // Files of OBJECT.CFG that no folder makes.
};

// `out` gets MS/ (the stick) and objects/ (what the compiler made). `say` gets lines for people.
BuildReport build_program(const ProgramPlan& plan, const Toolchain& tools,
                          const std::filesystem::path& out,
                          const std::function<void(const std::string&)>& say);

}  // namespace seam::open_r
