#include "tools/workbench/session.h"

#include <algorithm>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"
#include "sim_core/input/json_input.h"
#include "tools/pages/refusal.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kFormat = "seam-session/1";

json to_json(const Version& version) {
  json left_out = json::array();
  for (const LeftOut& one : version.left_out)
    left_out.push_back({{"lines", one.lines}, {"reason", one.reason}});
  return {
      {"id", version.id},           {"parent", version.parent},       {"name", version.name},
      {"note", version.note},       {"arguments", version.arguments}, {"copied", version.copied},
      {"formula", version.formula}, {"left_out", std::move(left_out)}};
}

Version version_from(const json& json) {
  Version version{.id = json.at("id"),
                  .parent = json.at("parent"),
                  .name = json.at("name"),
                  .note = json.at("note"),
                  .arguments = json.at("arguments"),
                  .copied = json.at("copied"),
                  .formula = json.at("formula")};
  for (const auto& one : json.at("left_out"))
    version.left_out.push_back({one.at("lines"), one.at("reason")});
  const bool plain =
      !version.id.empty() && version.id.find_first_not_of("0123456789") == std::string::npos;
  if (!plain) throw InputError("versions: id: expected digits");
  return version;
}

// The model that comes with a set.
fs::path nominal_of(const fs::path& data) {
  for (const char* name : {"nominal.yaml", "model.yaml"}) {
    if (fs::is_regular_file(data / name)) return data / name;
  }
  throw InputError(fmt::format(
      "{}: found no nominal.yaml, expected the model to begin with beside measurement.yaml",
      data.string()));
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
  return fmt::format("{:03}", versions.size() + 1);
}

json to_json(const SessionState& state) {
  json versions = json::array();
  for (const Version& version : state.versions) versions.push_back(to_json(version));
  return {{"format", kFormat},
          {"revision", state.revision},
          {"data", state.data},
          {"current", state.current},
          {"undone", state.undone},
          {"selection", state.selection},
          {"versions", std::move(versions)}};
}

SessionState session_from(const json& json) {
  if (json.value("format", "") != kFormat)
    throw InputError(fmt::format("format: expected \"{}\"", kFormat));
  SessionState state{.revision = json.at("revision"),
                     .data = json.at("data"),
                     .current = json.at("current"),
                     .undone = json.at("undone"),
                     .selection = json.at("selection")};
  for (const auto& version : json.at("versions")) state.versions.push_back(version_from(version));
  for (size_t i = 0; i < state.versions.size(); ++i) {
    const std::string& id = state.versions[i].id;
    if (state.find(id) != &state.versions[i])
      throw InputError(fmt::format("versions: two are {}, expected each once", id));
  }
  if (!state.find(state.current)) throw InputError("current: expected one of the versions");
  return state;
}

Session::Session(fs::path folder, const fs::path& data) : folder_(fs::absolute(std::move(folder))) {
  const fs::path file = folder_ / "session.json";
  if (!fs::exists(file)) {
    begin(fs::canonical(data));
    return;
  }
  try {
    state_ = session_from(read_json(file, "a session of the workbench"));
  } catch (const json::exception& error) {
    throw InputError(fmt::format("{}: {}", file.string(), error.what()));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", file.string(), error.what()));
  }
  if (state_.data != fs::canonical(data).string())
    throw InputError(
        fmt::format("{}: is a session of {}, expected one of {}: name another folder "
                    "with --session",
                    folder_.string(), state_.data, data.string()));
  // The program may have been ended between the two files that a step writes.
  write_left_out(state_);
}

void Session::begin(const fs::path& data) {
  const fs::path nominal = nominal_of(data);
  SessionState next{.data = data.string()};
  next.versions.push_back(
      {.id = "001", .name = nominal.stem().string(), .copied = nominal.string()});
  next.current = "001";
  make_output_folder(folder_);
  make_output_folder(folder_ / "versions");
  OutputFile(model("001")).fill(read_file(nominal));
  save(std::move(next));
}

fs::path Session::model(const std::string& id) const {
  return folder_ / "versions" / (id + ".yaml");
}

fs::path Session::cache(const std::string& id) const {
  fs::path folder = folder_ / "cache" / id;
  make_output_folder(folder_ / "cache");
  make_output_folder(folder);
  return folder;
}

void Session::write_left_out(const SessionState& next) const {
  const std::string table = left_out_table(next.version(next.current).left_out);
  const fs::path file = folder_ / "left-out.csv";
  if (!fs::exists(file) || read_file(file) != table) OutputFile(file).fill(table);
}

void Session::write(const SessionState& next) const {
  try {
    write_left_out(next);
    OutputFile(folder_ / "session.json").fill(to_json(next).dump(1) + "\n");
  } catch (const InputError& error) {
    throw Refusal(507,
                  fmt::format("not saved: {}; what was saved before is still there", error.what()));
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
