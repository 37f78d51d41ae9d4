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
  // Beside a place, on the same disk, so that what is made in it can be moved there.
  static ScratchFolder beside(const std::filesystem::path& place);
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  explicit ScratchFolder(const std::filesystem::path& above, const std::string& begin);
  std::filesystem::path path_;
};

}  // namespace seam::app
