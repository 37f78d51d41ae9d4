// session.json: how a state is written, and what one that is read must hold. A session may come
// from anybody: what is in it leads nowhere that this program would not have led.
#include <algorithm>
#include <limits>

#include "sim_core/base/error.h"
#include "tools/workbench/session/session.h"

namespace seam::tools {
namespace {

using nlohmann::json;

constexpr const char* kFormat = "seam-session/1";
// As far as a browser counts exactly.
constexpr uint64_t kLastRevision = uint64_t{1} << 53;

json to_json(const Version& version) {
  json left_out = json::array();
  for (const LeftOut& one : version.left_out)
    left_out.push_back({{"lines", one.lines}, {"reason", one.reason}});
  return {
      {"id", version.id},           {"parent", version.parent},       {"name", version.name},
      {"note", version.note},       {"arguments", version.arguments}, {"copied", version.copied},
      {"formula", version.formula}, {"left_out", std::move(left_out)}};
}

// The first line of observations is 2, behind the columns' names.
std::vector<int> lines_from(const json& lines) {
  std::vector<int> out;
  for (const json& line : lines) {
    if (!line.is_number_integer() || line < 2 || line > std::numeric_limits<int>::max())
      throw InputError("left_out: lines: expected lines of observations, from 2 on");
    out.push_back(line);
  }
  if (!std::is_sorted(out.begin(), out.end()))
    throw InputError("left_out: lines: expected in order");
  return out;
}

Version version_from(const json& json) {
  Version version{.id = json.at("id"),
                  .parent = json.at("parent"),
                  .name = json.at("name"),
                  .note = json.at("note"),
                  .arguments = json.at("arguments"),
                  .copied = json.at("copied"),
                  .formula = json.at("formula")};
  for (const auto& one : json.at("left_out")) {
    const std::string reason = one.at("reason");
    if (reason != one_cell(reason)) throw InputError("left_out: reason: expected one line");
    version.left_out.push_back({lines_from(one.at("lines")), reason});
  }
  return version;
}

// What a version says of itself, and of those before it.
void check_version(const SessionState& state, const Version& version) {
  const std::string about = "versions: " + version.id + ": ";
  if (version.id != state.next_id())
    throw InputError(fmt::format("{}expected {} as the id, for they are numbered in order", about,
                                 state.next_id()));
  const bool is_first = state.versions.empty();
  if (is_first != version.parent.empty() || (!is_first && !state.find(version.parent)))
    throw InputError(about + "parent: expected a version before it");
  const bool is_copy = version.arguments.empty();
  if (is_first && !is_copy) throw InputError(about + "arguments: expected none");
  if (is_first && std::filesystem::path(version.copied).parent_path() != state.data)
    throw InputError(about + "copied: expected the model beside the set");
  if (!is_copy && version.arguments != arguments_of(state, version))
    throw InputError(about + "arguments: expected a command of the workbench itself");
  if (!is_first && is_copy && version.copied != model_name(version.parent))
    throw InputError(about + "copied: expected the model of its parent");
}

}  // namespace

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
  if (!json.is_object() || !json.contains("format") || json["format"] != kFormat)
    throw InputError(fmt::format("format: expected \"{}\"", kFormat));
  const auto& revision = json.at("revision");
  if (!revision.is_number_unsigned() || revision > kLastRevision)
    throw InputError("revision: expected how many steps were saved");
  SessionState state{.revision = revision,
                     .data = json.at("data"),
                     .current = json.at("current"),
                     .undone = json.at("undone")};
  for (const auto& range : json.at("selection")) {
    if (!range.is_array() || range.size() != 2 || !range[0].is_number_unsigned() ||
        !range[1].is_number_unsigned() || range[0] > kLastRevision || range[1] > kLastRevision)
      throw InputError("selection: expected pairs of rows");
    state.selection.emplace_back(range[0], range[1]);
  }
  if (json.at("versions").size() > kMostVersions)
    throw InputError(fmt::format("versions: expected at most {}", kMostVersions));
  for (const auto& one : json.at("versions")) {
    Version version = version_from(one);
    check_version(state, version);
    state.versions.push_back(std::move(version));
  }
  if (!state.find(state.current)) throw InputError("current: expected one of the versions");
  for (const std::string& id : state.undone) {
    if (!state.find(id)) throw InputError("undone: expected some of the versions");
  }
  return state;
}

}  // namespace seam::tools
