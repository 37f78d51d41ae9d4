#include "open_r/files/memory_stick.h"

#include <algorithm>
#include <cctype>

namespace seam::open_r {
namespace {

namespace fs = std::filesystem;

// The entry of a folder with this name; where there is none, the name that a new one gets.
fs::path entry_of(const fs::path& folder, const std::string& name) {
  std::error_code error;
  if (fs::exists(folder / name, error)) return folder / name;
  std::string first;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string there = entry.path().filename().string();
    if (same_name(there, name) && (first.empty() || there < first)) first = there;
  }
  return folder / (first.empty() ? name : first);
}

}  // namespace

bool same_name(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char x, unsigned char y) {
    return std::toupper(x) == std::toupper(y);
  });
}

fs::path MemoryStick::find(std::string_view name) const {
  constexpr std::string_view kStick = "/MS/";
  if (!name.starts_with(kStick) && name != "/MS") return fs::path(name);
  fs::path at = root_;
  if (name.size() < kStick.size()) return at;
  for (const fs::path& part : fs::path(name.substr(kStick.size()))) {
    // A stick has nothing beyond its root.
    if (part.empty() || part == "." || part == "..") continue;
    at = entry_of(at, part.string());
  }
  return at;
}

}  // namespace seam::open_r
