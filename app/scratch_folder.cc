#include "app/scratch_folder.h"

#include <stdlib.h>

#include <cerrno>
#include <cstring>

#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "sim_core/signals/half_made.h"

namespace seam::app {

ScratchFolder::ScratchFolder(const std::string& purpose)
    : ScratchFolder(std::filesystem::temp_directory_path(), "seam-" + purpose) {}

ScratchFolder ScratchFolder::beside(const std::filesystem::path& place) {
  std::filesystem::path named = place;
  while (!named.has_filename() && named.has_parent_path()) named = named.parent_path();
  const std::filesystem::path above = named.has_parent_path() ? named.parent_path() : ".";
  make_output_folder(above);
  return ScratchFolder(above, "." + named.filename().string());
}

ScratchFolder::ScratchFolder(const std::filesystem::path& above, const std::string& begin) {
  std::string pattern = (above / (begin + "-XXXXXX")).string();
  const SignalsWait wait;
  if (mkdtemp(pattern.data()) == nullptr)
    throw InputError(
        fmt::format("{}: cannot make a folder like this: {}", pattern, std::strerror(errno)));
  path_ = pattern;
  is_half_made(path_);
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
  is_made(path_);
}

}  // namespace seam::app
