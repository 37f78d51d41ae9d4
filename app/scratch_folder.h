#pragma once

#include <filesystem>
#include <string>

namespace seam::app {

// A folder below the system's folder for temporary files, for this user alone; it goes with what it
// holds when the object does.
class ScratchFolder {
 public:
  // `purpose` is part of its name. Throws InputError where it cannot be made.
  explicit ScratchFolder(const std::string& purpose);
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace seam::app
