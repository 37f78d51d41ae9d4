#include "app/data_file.h"

#include "sim_core/base/error.h"

namespace seam::app {

namespace fs = std::filesystem;

fs::path data_file(const std::string& name) {
  if (fs::exists(name)) return name;
  const fs::path beside = fs::read_symlink("/proc/self/exe").parent_path().parent_path() / name;
  if (!fs::exists(beside)) {
    throw InputError(
        fmt::format("{}: not found here nor beside the program, expected SEAM's own files", name));
  }
  return beside;
}

}  // namespace seam::app
