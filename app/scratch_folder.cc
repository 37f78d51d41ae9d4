#include "app/scratch_folder.h"

#include <stdlib.h>

#include <cerrno>
#include <cstring>

#include "sim_core/base/error.h"

namespace seam::app {

ScratchFolder::ScratchFolder(const std::string& purpose) {
  std::string pattern =
      (std::filesystem::temp_directory_path() / ("seam-" + purpose + "-XXXXXX")).string();
  if (mkdtemp(pattern.data()) == nullptr)
    throw InputError(
        fmt::format("{}: cannot make a folder like this: {}", pattern, std::strerror(errno)));
  path_ = pattern;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace seam::app
