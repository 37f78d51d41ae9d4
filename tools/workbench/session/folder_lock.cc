#include "tools/workbench/session/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "sim_core/base/error.h"

namespace seam::tools {

FolderLock::FolderLock(const std::filesystem::path& folder)
    : descriptor_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0)
    throw InputError(
        fmt::format("{}: cannot be opened: {}", folder.string(), std::strerror(errno)));
  // A file system without locks (EOPNOTSUPP, ENOLCK) is used without one.
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  ::close(descriptor_);
  throw InputError(
      fmt::format("{}: another workbench has this session open: end it, or name another folder "
                  "with --session",
                  folder.string()));
}

FolderLock::~FolderLock() {
  ::close(descriptor_);
}

}  // namespace seam::tools
