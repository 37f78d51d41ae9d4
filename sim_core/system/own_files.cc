#include "sim_core/system/own_files.h"

#include <cstdlib>
#include <initializer_list>

namespace seam {
namespace {

namespace fs = std::filesystem;

// The first that exists, else an empty path.
fs::path first_of(std::initializer_list<fs::path> places) {
  std::error_code unknown;
  for (const fs::path& place : places) {
    if (fs::exists(place, unknown)) return place;
  }
  return {};
}

}  // namespace

fs::path program_file() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error);
}

fs::path find_shared(const std::string& name) {
  std::error_code unknown;
  if (const char* share = std::getenv("SEAM_SHARE"); share != nullptr && *share != '\0') {
    if (const fs::path given = fs::path(share) / name; fs::exists(given, unknown)) return given;
  }
  const fs::path here = program_file().parent_path();
  return first_of({here / "share/seam" / name, here.parent_path() / "share/seam" / name});
}

fs::path behaviours_folder() {
  const fs::path here = program_file().parent_path();
  const fs::path found =
      first_of({here / "behaviours", here.parent_path() / "lib/seam/behaviours"});
  return found.empty() ? here / "behaviours" : found;
}

fs::path python_folder() {
  const fs::path here = program_file().parent_path();
  const fs::path built = first_of({here / "python/seam_sdk"});
  const fs::path found = built.empty() ? find_shared("python/seam_sdk") : built;
  return found.parent_path();
}

}  // namespace seam
