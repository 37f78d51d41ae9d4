#include "sim_core/input/file_names.h"

#include <algorithm>
#include <deque>
#include <optional>

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

// The first link on the way from `root` to `root / relative` that leads out of it, also where
// nothing is at its end (a file may be made there); empty where none does.
std::optional<fs::path> link_out(const fs::path& root, const fs::path& relative) {
  constexpr int kMostLinks = 40;  // As many as the operating system follows.
  std::deque<fs::path> ahead(relative.begin(), relative.end());
  fs::path here = root, link;
  for (int links = 0; !ahead.empty();) {
    const fs::path part = ahead.front();
    ahead.pop_front();
    if (part == "." || part.empty()) continue;
    if (part == "..") {
      if (here == root) return link;
      here = here.parent_path();
      continue;
    }
    if (!fs::is_symlink(fs::symlink_status(here / part))) {
      here /= part;
      continue;
    }
    link = here / part;
    fs::path target = fs::read_symlink(link);
    if (++links > kMostLinks) return link;
    if (target.is_absolute()) {
      if (!is_below(root, target)) return link;
      target = target.lexically_relative(root);
      here = root;
    }
    ahead.insert(ahead.begin(), target.begin(), target.end());
  }
  return std::nullopt;
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
  try {
    const fs::path root = fs::weakly_canonical(fs::absolute(folder.empty() ? "." : folder));
    if (const auto link = link_out(root, relative))
      return fmt::format("found '{}', with a link that leads out of the folder: {}", name,
                         shown(link->string()));
  } catch (const fs::filesystem_error& error) {
    return fmt::format("found '{}': {}", name, error.code().message());
  }
  return "";
}

fs::path path_inside(const fs::path& folder, const std::string& name) {
  const std::string why = why_not_inside(folder, name);
  if (!why.empty()) throw InputError(fmt::format("{}: {}", folder.string(), why));
  return folder / name;
}

}  // namespace seam
