// What a Python file imports, as far as its text shows without running it.
#pragma once

#include <filesystem>
#include <set>
#include <string>

namespace seam::app {

// First parts of the names of modules: `numpy` for `from numpy.linalg import norm`; names that
// begin with a dot are left out, for they stand beside the file.
std::set<std::string> imported_modules(const std::string& text);

// Where a module that stands not beside its script comes from.
struct ModulePlace {
  bool of_python = false;  // Of its standard library, or our own package.
  std::string path;        // Where Debian's Python finds it; empty: nowhere.
};
ModulePlace place_of_module(const std::string& module);

}  // namespace seam::app
