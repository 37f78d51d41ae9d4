#include "tools/workbench/places.h"

#include <algorithm>
#include <cstdlib>

#include "app/import/recognise.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"
#include "tools/pages/refusal.h"
#include "tools/workbench/looked.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr size_t kMostRecent = 12;

// The folder of a set: that of its measurement.yaml, too.
fs::path folder_of(const fs::path& path) {
  return path.filename() == "measurement.yaml" ? path.parent_path() : path;
}

fs::path recent_file() {
  const char* state = std::getenv("XDG_STATE_HOME");
  const char* home = std::getenv("HOME");
  if (state != nullptr && *state != '\0') return fs::path(state) / "seam/workbench.json";
  if (home != nullptr && *home != '\0') return fs::path(home) / ".local/state/seam/workbench.json";
  return {};
}

bool is_below(const fs::path& path, const fs::path& root) {
  const auto [end, rest] = std::mismatch(root.begin(), root.end(), path.begin(), path.end());
  return end == root.end();
}

}  // namespace

std::string name_in_files(std::string text) {
  for (char& c : text) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (!plain && c != '-' && c != '_') c = '_';
  }
  return text.empty() ? "set" : text;
}

Places::Places(const std::vector<std::string>& named, const std::string& session)
    : session_(session) {
  for (const std::string& name : named) {
    if (!fs::exists(name)) throw InputError(name + ": there is no such file or folder");
    const fs::path path = folder_of(fs::canonical(name));
    app::refuse_foreign_file(path);
    roots_.push_back(path);
  }
  if (!roots_.empty()) first_ = roots_.front();
}

fs::path Places::to_open(const std::string& path) const {
  std::error_code failed;
  const fs::path real = folder_of(fs::canonical(path, failed));
  const bool may =
      !failed &&
      (std::ranges::any_of(roots_, [&](const fs::path& root) { return is_below(real, root); }) ||
       was_open(real));
  if (!may)
    throw Refusal(403,
                  "the page opens only what was named at the terminal, or opened so before: "
                  "run seam workbench FOLDER");
  return real;
}

bool Places::was_open(const fs::path& data) const {
  for (const json& one : recent()) {
    if (one.value("path", "") == data.string()) return true;
  }
  return false;
}

fs::path Places::beside() const {
  return session_.empty() ? fs::current_path() : fs::absolute(session_).parent_path();
}

fs::path Places::session_of(const fs::path& data) const {
  if (!session_.empty() && data == first_) return session_;
  const std::string name = data.filename().string();
  for (int i = 1;; ++i) {
    fs::path folder =
        beside() / (i == 1 ? name + ".session" : fmt::format("{}-{}.session", name, i));
    const json state = json_of(folder / "session.json");
    if (!state.is_object() || state.value("data", "") == data.string()) return folder;
  }
}

void Places::remember(const fs::path& data, const json& set) const {
  const fs::path file = recent_file();
  if (file.empty()) return;
  json list = {{{"name", data.filename().string()},
                {"path", data.string()},
                {"kind", set.value("kind", "")},
                {"title", set.value("title", "")}}};
  for (const json& one : recent()) {
    if (one.value("path", "") != data.string() && list.size() < kMostRecent) list.push_back(one);
  }
  try {
    fs::create_directories(file.parent_path());
    write_file_atomically(file, list.dump(1, ' ', false, json::error_handler_t::replace) + "\n");
  } catch (const std::exception&) {  // A list that is a convenience; the work goes on without it.
  }
}

json Places::named() const {
  json folders = json::array();
  for (const fs::path& root : roots_) folders.push_back(root.string());
  return folders;
}

json Places::recent() const {
  const fs::path file = recent_file();
  json list = json::array();
  const json kept = file.empty() ? json() : json_of(file);
  if (!kept.is_array()) return list;
  for (const json& one : kept) {
    if (!one.is_object() || !one.contains("path") || !one["path"].is_string()) continue;
    std::error_code failed;
    if (fs::exists(fs::path(one["path"].get<std::string>()) / "measurement.yaml", failed))
      list.push_back(one);
  }
  return list;
}

}  // namespace seam::tools
