#include "app/data_file.h"

#include "sim_core/base/error.h"
#include "sim_core/system/own_files.h"

namespace seam::app {

namespace fs = std::filesystem;

fs::path data_file(const std::string& name) {
  if (fs::exists(name)) return name;
  if (const fs::path shared = find_shared(name); !shared.empty()) return shared;
  const fs::path beside = program_file().parent_path().parent_path() / name;
  if (!fs::exists(beside)) {
    throw InputError(
        fmt::format("{}: not found here nor beside the program, expected SEAM's own files", name));
  }
  return beside;
}

}  // namespace seam::app
