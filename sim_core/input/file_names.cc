#include "sim_core/input/file_names.h"

#include <algorithm>

#include "sim_core/base/error.h"
#include "sim_core/input/shown_text.h"

namespace seam {
namespace fs = std::filesystem;

namespace {

bool is_below(const fs::path& folder, const fs::path& path) {
  const auto [in_folder, in_path] =
      std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  return in_folder == folder.end() || in_folder->empty();
}

}  // namespace

std::string why_not_inside(const fs::path& folder, const std::string& name) {
  if (name.empty()) return "found an empty name, expected a file inside the folder";
  if (shown(name) != name) {
    return fmt::format("found '{}', expected a name without control characters", shown(name));
  }
  const fs::path relative(name);
  if (relative.is_absolute())
    return fmt::format("found '{}', expected a path relative to the folder", name);
  if (std::find(relative.begin(), relative.end(), "..") != relative.end())
    return fmt::format("found '{}', which leads out of the folder, expected a path inside", name);
  std::error_code error;
  const fs::path root = fs::weakly_canonical(folder.empty() ? "." : folder, error);
  const fs::path target = fs::weakly_canonical(root / relative, error);
  if (error) return fmt::format("found '{}': {}", name, error.message());
  if (!is_below(root, target))
    return fmt::format("found '{}', a link that leads out of the folder to {}", name,
                       shown(target.string()));
  return "";
}

fs::path path_inside(const fs::path& folder, const std::string& name) {
  const std::string why = why_not_inside(folder, name);
  if (!why.empty()) throw InputError(fmt::format("{}: {}", folder.string(), why));
  return folder / name;
}

}  // namespace seam
