#include "app/import/files/source_file.h"

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"

namespace seam::app {

std::string read_source(const std::filesystem::path& path, uint64_t limit_bytes) {
  std::string bytes = read_file(path, limit_bytes);
  if (bytes.empty()) throw InputError(fmt::format("{}: the file is empty", path.string()));
  if (bytes.starts_with("version https://git-lfs"))
    throw InputError(fmt::format(
        "{}:1: found a pointer of Git LFS, expected the file itself: fetch it with git lfs pull",
        path.string()));
  return bytes;
}

}  // namespace seam::app
