#include "tools/workbench/session/session.h"

#include <algorithm>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"
#include "sim_core/input/file_names.h"
#include "sim_core/input/json_input.h"
#include "sim_core/input/shown_text.h"
#include "tools/pages/refusal.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kSession = "session.json";
constexpr const char* kLeftOut = "left-out.csv";

// The model that comes with a set.
fs::path nominal_of(const fs::path& data) {
  for (const char* name : {"nominal.yaml", "model.yaml"}) {
    const fs::path file = path_inside(data, name);
    if (fs::is_regular_file(file)) return file;
  }
  throw InputError(fmt::format(
      "{}: found no nominal.yaml, expected the model to begin with beside measurement.yaml",
      data.string()));
}

// Its name stands in files and pages, which hold text.
void expect_text(const fs::path& folder) {
  const std::string name = folder.string();
  if (shown(name) != name)
    throw InputError(
        fmt::format("{}: expected a name of printed characters in UTF-8: rename it", shown(name)));
}

Refusal not_saved(const InputError& error) {
  return Refusal(507,
                 fmt::format("not saved: {}; what was saved before is still there", error.what()));
}

}  // namespace

const Version* SessionState::find(const std::string& id) const {
  const auto found = std::ranges::find(versions, id, &Version::id);
  return found == versions.end() ? nullptr : &*found;
}

const Version& SessionState::version(const std::string& id) const {
  if (const Version* found = find(id)) return *found;
  throw Refusal(404, fmt::format("there is no version '{}'", id.substr(0, 20)));
}

std::string SessionState::next_id() const {
  if (versions.size() >= kMostVersions)
    throw Refusal(
        400, fmt::format("a session has at most {} versions: begin another one", kMostVersions));
  return fmt::format("{:03}", versions.size() + 1);
}

std::string model_name(const std::string& id) {
  return "versions/" + id + ".yaml";
}

std::string formula_name(const std::string& id) {
  return "effects/" + id + ".yaml";
}

std::string one_cell(std::string text) {
  for (char& c : text) {
    if (c == ',') c = ';';
    if (static_cast<unsigned char>(c) < ' ' || c == '"') c = ' ';
  }
  const size_t first = text.find_first_not_of(' ');
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

bool is_effect_name(const std::string& name) {
  return !name.empty() && name.size() <= 100 && name.front() != '-' &&
         name.find_first_not_of(
             "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
             "0123456789_@-") == std::string::npos;
}

std::vector<std::string> about(const SessionState& state, const Version& version,
                               const std::string& left_out) {
  std::vector<std::string> arguments = {"--model", model_name(version.id), "--data", state.data};
  if (!version.left_out.empty()) arguments.insert(arguments.end(), {"--leave-out", left_out});
  return arguments;
}

std::vector<std::string> arguments_of(const SessionState& state, const Version& version) {
  std::vector<std::string> arguments = {version.arguments.at(0)};
  if (arguments[0] == "add") {
    if (version.formula.empty() && !is_effect_name(version.name))
      throw InputError(fmt::format("{}: expected the name of an effect", shown(version.name)));
    arguments.push_back(version.formula.empty() ? version.name : formula_name(version.id));
  } else if (arguments[0] != "fit") {
    throw InputError("arguments: expected add or fit");
  }
  Version parent = state.version(version.parent);
  parent.left_out = version.left_out;
  const auto about_it = about(state, parent, kLeftOut);
  arguments.insert(arguments.end(), about_it.begin(), about_it.end());
  arguments.insert(arguments.end(), {"--out", model_name(version.id)});
  return arguments;
}

Session::Session(fs::path folder, const fs::path& data, const Session* before)
    : folder_(fs::absolute(std::move(folder))) {
  const fs::path set = fs::canonical(data);
  expect_text(set);
  expect_text(folder_);
  std::error_code other;
  if (fs::equivalent(folder_, set, other))
    throw UsageError(fmt::format("--session {}: is the folder of the set itself: name another one",
                                 folder_.string()));
  const fs::path file = path_inside(folder_, kSession);
  const bool is_new = !fs::exists(file);
  const fs::path nominal = is_new ? nominal_of(set) : "";
  if (is_new) make_output_folder(folder_);
  lock_ = before && fs::equivalent(before->folder_, folder_, other)
              ? before->lock_
              : std::make_shared<const FolderLock>(folder_);
  // It is looked at once more: another program may have begun it meanwhile.
  if (fs::exists(file)) {
    read(set);
  } else {
    begin(set, nominal);
  }
}

void Session::read(const fs::path& data) {
  const fs::path file = folder_ / kSession;
  const json found = read_json(file, "a session of the workbench");
  try {
    state_ = session_from(found);
  } catch (const json::exception&) {
    throw InputError(fmt::format(
        "{}: is no session of the workbench: a field is missing, or of another kind of value",
        file.string()));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", file.string(), error.what()));
  }
  if (state_.data != data.string())
    throw InputError(
        fmt::format("{}: is a session of {}, expected one of {}: name another folder "
                    "with --session",
                    folder_.string(), shown(state_.data), data.string()));
  expect_models(state_);  // A session that is opened again may stand on another disk.
  // The program may have been ended between the two files that a step writes.
  const std::string table = left_out_table(state_.version(state_.current).left_out);
  const fs::path left_out = path_inside(folder_, kLeftOut);
  if (!fs::exists(left_out) || read_file(left_out) != table) OutputFile(left_out).fill(table);
}

void Session::begin(const fs::path& data, const fs::path& nominal) {
  SessionState next{.data = data.string()};
  next.versions.push_back(
      {.id = "001", .name = nominal.stem().string(), .copied = nominal.string()});
  next.current = "001";
  write_part(model_name("001"), read_file(nominal));
  save(std::move(next));
}

fs::path Session::model(const std::string& id) const {
  return path_inside(folder_, model_name(id));
}

fs::path Session::cache(const std::string& id) const {
  return path_inside(folder_, "cache/" + id);
}

void Session::write_part(const std::string& name, const std::string& text) const {
  try {
    const fs::path file = path_inside(folder_, name);
    make_output_folder(file.parent_path());
    OutputFile(file).fill(text);
  } catch (const InputError& error) {
    throw not_saved(error);
  }
}

void Session::expect_models(const SessionState& state) const {
  for (const Version& version : state.versions) {
    if (!fs::exists(model(version.id)))
      throw InputError(fmt::format("{}: is missing", model(version.id).string()));
  }
}

// Both files are whole on the disk before one takes its place.
void Session::write(const SessionState& next) const {
  try {
    expect_models(next);
    OutputFile left_out(path_inside(folder_, kLeftOut)), session(path_inside(folder_, kSession));
    left_out.write(left_out_table(next.version(next.current).left_out));
    session.write(to_json(next).dump(1) + "\n");
    left_out.sync();
    session.commit();
    left_out.commit();
  } catch (const InputError& error) {
    throw not_saved(error);
  }
}

void Session::save(SessionState next) {
  next.revision = state_.revision + 1;
  write(next);
  state_ = std::move(next);
}

void Session::keep(SessionState next) {
  write(next);
  state_ = std::move(next);
}

void Session::expect(uint64_t revision) const {
  if (revision == state_.revision) return;
  throw Refusal(409, "the session was changed meanwhile, perhaps in another tab: load it again",
                {{"revision", state_.revision}});
}

std::string left_out_table(const std::vector<LeftOut>& left_out) {
  std::vector<std::pair<int, std::string>> rows;
  for (const LeftOut& one : left_out) {
    for (const int line : one.lines) rows.emplace_back(line, one.reason);
  }
  std::sort(rows.begin(), rows.end());
  std::string table = "row,reason\n";
  for (const auto& [line, reason] : rows) table += fmt::format("{},{}\n", line, reason);
  return table;
}

}  // namespace seam::tools
