// What a folder with an OPEN-R program holds: its objects with their sources, and the memory stick
// that it is to run from. Makefiles are read where there are any; else each folder with a stub.cfg
// or a .ocf file is an object of all sources in it.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace seam::open_r {

struct SourceFile {
  std::filesystem::path file;
  std::vector<std::string> flags;  // -I and -D of its Makefile.
};

struct ObjectPlan {
  std::string name;  // As its .ocf calls it: "movingHead".
  std::filesystem::path folder;
  std::vector<SourceFile> sources;
  std::filesystem::path stub_settings;  // Empty: its stub is written by hand.
  std::vector<std::string> libraries;   // That the folder does not hold: "jpeg".
  std::vector<std::string> installed;   // File names on the stick, such as MOVEHEAD.BIN.
};

struct ProgramPlan {
  std::string design;
  std::filesystem::path stick;      // The folder MS; empty: there is none.
  std::vector<std::string> wanted;  // File names of OBJECT.CFG.
  std::vector<ObjectPlan> objects;
};

// A file with this name in its folder says that a build made the stick beside it.
constexpr const char* kBuildMark = ".open_r_build";

// Whether a path is a folder's or lies below it; both without links.
bool lies_in(const std::filesystem::path& path, const std::filesystem::path& folder);

// `folders`: that of the program, then others that hold objects of it. `given`: variables for
// Makefiles. `out`: where the build goes; a stick there is not the program's. Throws Fault where
// there is no program.
ProgramPlan plan_program(const std::vector<std::filesystem::path>& folders,
                         const std::string& design, const std::map<std::string, std::string>& given,
                         const std::filesystem::path& out);

// The object that makes each wanted file, in their order; nullptr where none does.
std::vector<const ObjectPlan*> assign_objects(const ProgramPlan& plan);

}  // namespace seam::open_r
