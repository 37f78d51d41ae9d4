#include "tools/workbench/desk.h"

#include <algorithm>
#include <fstream>

#include "measurement/sets/set.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/input/file_names.h"
#include "tools/pages/refusal.h"
#include "tools/workbench/session/cache_key.h"

namespace seam::tools {

namespace fs = std::filesystem;
using nlohmann::json;

Desk::Desk()
    : looking_(std::make_unique<Looking>(
          [this](const LookJob& job, const json& event) { said(job, event); },
          [this](const LookJob& job, const std::string& trouble, bool cancelled) {
            ended(job, trouble, cancelled);
          })) {}

void Desk::open(const fs::path& data, const fs::path& session) {
  const auto set = measurement::MeasurementSet::open(data);
  looking_->cancel();  // Also a change that is being computed, which holds the lock.
  const std::lock_guard change(changing_);
  {
    const std::lock_guard lock(mutex_);
    auto next = std::make_unique<Session>(session, data, session_.get());
    set_key_ = set_key(*next);
    session_ = std::move(next);
    ++opened_;
    job_ = look_ = nullptr;
    looked_.clear();
    lines_.clear();
    for (const Version& version : session_->state().versions)
      looked_[version.id] = looked_before(version);
    const fs::path folder = fs::canonical(data);
    set_ = {{"title", set.title},
            {"kind", set.kind},
            {"file", ""},
            {"rows", 0},
            {"groups", 0},
            {"group", set.group},
            {"noise", set.noise},
            {"noise_estimated", false},
            {"columns", json::array()},
            {"doubts", json::array()},
            {"folder", folder.string()}};
    command_ = command_of(session_->state().version(session_->state().current));
    events_.publish("state", state_unlocked());
  }
  look_at_current();
}

// What was computed of a version, if it was of the files as they are now; else it is removed.
Looked Desk::looked_before(const Version& version) const {
  const fs::path cache = session_->cache(version.id), key = cache / kKey, rows = cache / "rows.bin";
  try {
    if (fs::exists(key) && read_file(key) == cache_key(set_key_, *session_, version)) {
      Looked looked;
      looked.read(cache);
      search_json(looked);
      if (fs::exists(rows)) column_of(rows, "line");
      return looked;
    }
  } catch (const std::exception&) {  // A damaged file: it is made again.
  }
  std::error_code failed;  // A look that cannot write there will say so.
  fs::remove_all(cache, failed);
  return {};
}

void Desk::offer(json recent, json samples, json named) {
  const std::lock_guard lock(mutex_);
  recent_ = std::move(recent);
  samples_ = std::move(samples);
  named_ = std::move(named);
}

Session& Desk::session() {
  if (session_) return *session_;
  throw Refusal(404, "no set is open: open a folder, a file or a sample first");
}

json Desk::set_json() const {
  if (!session_) return nullptr;
  json fields = set_;
  const auto take = [&](const std::string& id) {
    const auto found = looked_.find(id);
    if (found == looked_.end() || !found->second.set.is_object()) return false;
    fields.update(found->second.set);
    return true;
  };
  if (take(session_->state().current)) return fields;
  for (const auto& [id, looked] : looked_) {
    if (take(id)) break;
  }
  return fields;
}

json Desk::version_json(const Version& version) const {
  size_t left_out = 0;
  for (const LeftOut& one : version.left_out) left_out += one.lines.size();
  json fields = {{"id", version.id},
                 {"parent", version.parent.empty() ? json(nullptr) : json(version.parent)},
                 {"name", version.name},
                 {"command", command_of(version)},
                 {"note", version.note},
                 {"error", nullptr},
                 {"headline", ""},
                 {"effects", json::object()},
                 {"structure", nullptr},
                 {"doubts", json::array()},
                 {"noise", json::object()},
                 {"left_out", left_out}};
  const auto found = looked_.find(version.id);
  const bool running = looking_->runs(opened_, version.id);
  const Looked none;
  const Looked& looked = found == looked_.end() ? none : found->second;
  fields["looked"] = running                                         ? "running"
                     : !looked.trouble.empty()                       ? "failed"
                     : looked.ended() && looked.diagnose.is_object() ? "yes"
                                                                     : "no";
  if (!looked.trouble.empty()) fields["trouble"] = looked.trouble;
  for (const char* key : {"error", "headline", "structure", "traces", "doubts", "noise", "native",
                          "notes", "outliers", "findings", "figures"}) {
    if (looked.compare.is_object() && looked.compare.contains(key))
      fields[key] = looked.compare[key];
  }
  if (looked.effects.is_object()) fields["effects"] = looked.effects;
  if (looked.diagnose.is_object()) {
    fields["verdict"] = looked.diagnose.value("verdict", "");
    fields["headline"] = looked.diagnose.value("headline", "");
  }
  return fields;
}

json Desk::state_unlocked() const {
  json state = {{"format", "seam-workbench/1"},
                {"revision", 0},
                {"current", ""},
                {"can_undo", false},
                {"can_redo", false},
                {"command", command_},
                {"job", job_.is_null() ? look_ : job_},
                {"selection", json::array()},
                {"set", set_json()},
                {"versions", json::array()},
                {"left_out", json::array()},
                {"recent", recent_},
                {"samples", samples_},
                {"named", named_}};
  if (!session_) return state;
  const SessionState& saved = session_->state();
  const Version& current = saved.version(saved.current);
  state["revision"] = saved.revision;
  state["current"] = saved.current;
  state["can_undo"] = !current.parent.empty();
  state["can_redo"] = !saved.undone.empty();
  state["selection"] = saved.selection;
  state["session"] = session_->folder().string();
  for (const Version& version : saved.versions) state["versions"].push_back(version_json(version));
  if (current.left_out.empty()) return state;
  const std::vector<int>& lines = lines_of_rows();
  for (const LeftOut& one : current.left_out) {
    Ranges ranges;
    for (const int line : one.lines) {
      const auto found = std::ranges::lower_bound(lines, line);
      if (found == lines.end() || *found != line) continue;
      const int64_t row = found - lines.begin();
      if (!ranges.empty() && ranges.back().second + 1 == row) {
        ++ranges.back().second;
      } else {
        ranges.emplace_back(row, row);
      }
    }
    state["left_out"].push_back(
        {{"ranges", ranges}, {"count", one.lines.size()}, {"reason", one.reason}});
  }
  return state;
}

// The lines of all rows, once a look at any version has written them.
const std::vector<int>& Desk::lines_of_rows() const {
  if (!lines_.empty()) return lines_;
  for (const Version& version : session_->state().versions) {
    const fs::path file = session_->cache(version.id) / "rows.bin";
    if (!fs::exists(file)) continue;
    for (const float line : column_of(file, "line")) lines_.push_back(static_cast<int>(line));
    if (!lines_.empty()) break;
  }
  return lines_;
}

json Desk::state() {
  const std::lock_guard lock(mutex_);
  return state_unlocked();
}

json Desk::search(const std::string& id) {
  json fields;
  {
    const std::lock_guard lock(mutex_);
    const Version& version = session().state().version(id);
    fields = search_json(looked_[id]);
    fields["version"] = version.id;
    fields["progress"] =
        look_.is_object() && look_.value("version", "") == id ? look_ : json(nullptr);
    const Looked& looked = looked_[id];
    const bool done = looked.ended() && looked.diagnose.is_object();
    if (!done && looked.trouble.empty() && !looked.cancelled) look(version);
  }
  return fields;
}

std::string Desk::script() {
  const std::lock_guard lock(mutex_);
  return script_of(session().state());
}

fs::path Desk::model(const std::string& version) {
  const std::lock_guard lock(mutex_);
  return session().model(session().state().version(version).id);
}

fs::path Desk::set_folder() {
  const std::lock_guard lock(mutex_);
  return session().state().data;
}

fs::path Desk::computed(const std::string& id, const std::vector<std::string>& names) {
  const std::lock_guard lock(mutex_);
  const Version& version = session().state().version(id);
  for (const std::string& name : names) {
    const fs::path file = session().cache(version.id) / name;
    if (fs::exists(file)) return file;
  }
  const Looked& looked = looked_[version.id];
  if (!looked.trouble.empty()) throw Refusal(404, looked.trouble);
  if (looked.cancelled) throw Refusal(404, "the look at this version was cancelled");
  if (looked.ended() && looked.diagnose.is_object())
    throw Refusal(404, "nothing was computed of that for this version");
  look(version);
  return {};
}

json Desk::line(int64_t row) {
  const std::lock_guard lock(mutex_);
  session();
  const json set = set_json();
  const std::vector<int> lines = lines_of({{row, row}});
  const std::string name = set.value("file", "");
  std::ifstream in(path_inside(session().state().data, name));
  std::string header, text;
  std::getline(in, header);
  for (int at = 2; at <= lines.front() && std::getline(in, text); ++at) {
  }
  const auto cells = [](const std::string& of_line) {
    json list = json::array();
    for (size_t at = 0, end = 0; end != std::string::npos; at = end + 1) {
      end = of_line.find(',', at);
      list.push_back(of_line.substr(at, end == std::string::npos ? end : end - at));
    }
    return list;
  };
  return {{"file", name},
          {"line", lines.front()},
          {"text", text},
          {"columns", cells(header)},
          {"cells", cells(text)}};
}

bool Desk::is_open(uint64_t opened, const std::string& version) const {
  return session_ && opened == opened_ && session_->state().find(version) != nullptr;
}

void Desk::said(const LookJob& job, const json& event) {
  const std::string& version = job.version;
  const std::string what = event.value("event", "");
  const std::lock_guard lock(mutex_);
  if (!is_open(job.opened, version)) return;
  if (what == "work") {
    // While candidates are counted, what goes on inside of one is no news.
    if (look_.is_object() && look_.value("done", 0) < look_.value("of", 0)) return;
    if (!look_.is_object()) look_ = {{"done", 0}, {"of", 0}, {"version", version}};
    look_["what"] = event.value("doing", "");
    events_.publish("progress", look_);
    return;
  }
  if (event.contains("done")) {
    look_ = {{"what", event.value("what", "")},
             {"done", event.value("done", 0)},
             {"of", event.value("of", 0)},
             {"version", version}};
    if (what == "progress") events_.publish("progress", look_);
  }
  Looked& looked = looked_[version];
  const fs::path folder = session_->cache(version);
  if (what == "compared" || what == "set") {
    looked.read(folder);
    events_.publish("state", state_unlocked());
  } else if (what == "preview") {
    events_.publish("preview", {{"version", version}, {"effect", event.value("effect", "")}});
  } else if (what == "search") {
    looked.search = json_of(folder / "search.json");
    json fields = search_json(looked);
    fields["version"] = version;
    fields["progress"] = look_;
    events_.publish("search", fields);
  }
}

void Desk::ended(const LookJob& job, const std::string& trouble, bool cancelled) {
  const std::string& version = job.version;
  const std::lock_guard lock(mutex_);
  if (!is_open(job.opened, version)) return;
  look_ = nullptr;
  Looked& looked = looked_[version];
  looked.read(session_->cache(version));
  looked.trouble = trouble;
  looked.cancelled = cancelled;
  json fields = search_json(looked);
  fields["version"] = version;
  fields["progress"] = nullptr;
  events_.publish("search", fields);
  events_.publish("state", state_unlocked());
}

}  // namespace seam::tools
