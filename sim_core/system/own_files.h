// Where the files that belong to the running program are: in its build folder, or in the tree that
// it was installed in, wherever that was moved.
#pragma once

#include <filesystem>
#include <string>

namespace seam {

// The running program's own file, links followed.
std::filesystem::path program_file();

// NAME in the folder of shared files: that which SEAM_SHARE names, share/seam beside the program (a
// build folder) or beside the program's folder (PREFIX/bin). Empty where none of them has it.
std::filesystem::path find_shared(const std::string& name);

// The folders of behaviours: beside the program in a build folder, PREFIX/lib/seam where installed.
// The first of them that is there; where none is, the first that was looked for.
std::filesystem::path behaviours_folder();

// The folder of our package for Python (seam_sdk); empty where there is none.
std::filesystem::path python_folder();

}  // namespace seam
