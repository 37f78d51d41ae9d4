// One program at a time works in a folder: another is refused, until this one ends, however it
// does.
#pragma once

#include <filesystem>

namespace seam::tools {

class FolderLock {
 public:
  // Throws InputError where another program holds it, or there is no such folder.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace seam::tools
