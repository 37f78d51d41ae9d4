// The memory stick of a robot as a folder: what a program names /MS/OPEN-R/... lies in it. Names on
// a stick do not know small letters from capitals.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace seam::open_r {

// Whether a stick takes two names of files for one.
bool same_name(std::string_view a, std::string_view b);

class MemoryStick {
 public:
  explicit MemoryStick(std::filesystem::path root) : root_(std::move(root)) {}

  // The file that a program means: a path that begins with /MS/ in the folder, another as it is.
  std::filesystem::path find(std::string_view name) const;
  const std::filesystem::path& root() const { return root_; }

 private:
  std::filesystem::path root_;
};

}  // namespace seam::open_r
