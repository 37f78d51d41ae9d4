#include "app/bundle/python_imports.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <sstream>
#include <vector>

#include "sim_core/system/own_files.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;

// Modules that are compiled into Debian's interpreter: no file shows them.
constexpr std::array kBuiltIn = {
    "__future__",   "_thread", "array", "atexit", "binascii",  "builtins", "cmath",       "errno",
    "faulthandler", "fcntl",   "gc",    "grp",    "itertools", "marshal",  "math",        "posix",
    "pwd",          "select",  "spwd",  "sys",    "syslog",    "time",     "unicodedata", "zlib"};

bool is_module_of(const fs::path& folder, const std::string& module) {
  std::error_code unknown;
  return fs::exists(folder / (module + ".py"), unknown) ||
         fs::is_directory(folder / module, unknown);
}

// A module that was compiled: NAME.cpython-311-x86_64-linux-gnu.so.
bool is_compiled_in(const fs::path& folder, const std::string& module) {
  std::error_code unknown;
  for (fs::directory_iterator at(folder, unknown), end; !unknown && at != end;
       at.increment(unknown)) {
    const std::string name = at->path().filename().string();
    if (name.starts_with(module + ".") && name.ends_with(".so")) return true;
  }
  return false;
}

// The name that a text begins with, behind spaces; empty: none.
std::string first_name(const std::string& text) {
  const auto in_name = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  const auto begin = std::find_if_not(text.begin(), text.end(),
                                      [](unsigned char c) { return std::isspace(c) != 0; });
  if (begin != text.end() && std::isdigit(static_cast<unsigned char>(*begin)) != 0) return "";
  return {begin, std::find_if_not(begin, text.end(), in_name)};
}

// Of all versions that are there.
std::vector<fs::path> library_folders() {
  std::vector<fs::path> folders;
  for (const char* root : {"/usr/lib", "/usr/local/lib"}) {
    std::error_code unknown;
    for (fs::directory_iterator at(root, unknown), end; !unknown && at != end;
         at.increment(unknown))
      if (at->path().filename().string().starts_with("python3.")) folders.push_back(at->path());
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

}  // namespace

std::set<std::string> imported_modules(const std::string& text) {
  constexpr size_t kMostLine = 1000;
  std::set<std::string> modules;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.size() > kMostLine) continue;
    std::istringstream words(line);
    std::string keyword, name, next;
    words >> keyword;
    if (keyword == "from" && words >> name >> next && first_name(next) == "import")
      modules.insert(first_name(name));
    if (keyword != "import") continue;
    while (std::getline(words, name, ',')) {
      const std::string module = first_name(name);
      modules.insert(module);
      // Behind the last name of the statement: a comment, or another statement.
      if (name.find_first_of("#;") != std::string::npos) break;
    }
  }
  modules.erase("");  // Of a relative import.
  return modules;
}

ModulePlace place_of_module(const std::string& module) {
  if (std::find(kBuiltIn.begin(), kBuiltIn.end(), module) != kBuiltIn.end()) return {true, ""};
  if (!python_folder().empty() && is_module_of(python_folder(), module)) return {true, ""};
  for (const fs::path& folder : library_folders())
    if (is_module_of(folder, module) || is_compiled_in(folder / "lib-dynload", module))
      return {true, folder.string()};
  std::vector<fs::path> packages = {"/usr/lib/python3/dist-packages"};
  for (const fs::path& folder : library_folders())
    for (const char* name : {"dist-packages", "site-packages"}) packages.push_back(folder / name);
  for (const fs::path& folder : packages)
    if (is_module_of(folder, module) || is_compiled_in(folder, module))
      return {false, folder.string()};
  return {};
}

}  // namespace seam::app
