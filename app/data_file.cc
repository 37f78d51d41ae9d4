#include "app/data_file.h"

#include <algorithm>
#include <cstdio>

#include "sim_core/base/error.h"
#include "sim_core/input/shown_text.h"
#include "sim_core/system/own_files.h"

namespace seam::app {

namespace fs = std::filesystem;

namespace {

fs::path beside_build_folder(const std::string& name) {
  return program_file().parent_path().parent_path() / name;
}

}  // namespace

fs::path data_file(const std::string& name) {
  if (fs::exists(name)) return name;
  if (const fs::path shared = find_shared(name); !shared.empty()) return shared;
  const fs::path beside = beside_build_folder(name);
  if (!fs::exists(beside)) {
    throw InputError(
        fmt::format("{}: not found here nor beside the program, expected SEAM's own files", name));
  }
  return beside;
}

fs::path given_or_ours(const fs::path& name) {
  std::error_code unknown;
  const std::string first = name.empty() ? "" : name.begin()->string();
  if (fs::exists(name, unknown) || (first != "scenarios" && first != "models")) return name;
  const fs::path shared = find_shared(name.string());
  if (shared.empty()) return name;
  std::fprintf(stderr, "%s is not here: %s is used\n", shown(name.string()).c_str(),
               shown(shared.string()).c_str());
  return shared;
}

bool is_our_data(const fs::path& path) {
  std::error_code unknown;
  const fs::path file = fs::weakly_canonical(path, unknown);
  for (const char* name : {"models", "scenarios"}) {
    for (const fs::path& place : {find_shared(name), beside_build_folder(name)}) {
      const fs::path folder = fs::weakly_canonical(place, unknown);
      const auto [end, at] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
      if (!place.empty() && end == folder.end()) return true;
    }
  }
  return false;
}

}  // namespace seam::app
