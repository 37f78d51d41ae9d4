// A session as a shell script.
#include <fmt/format.h>

#include "sim_core/input/shell_word.h"
#include "tools/workbench/session/session.h"

namespace seam::tools {
namespace {

// A file of this content, whatever lines it has.
std::string written(const std::string& file, const std::string& content) {
  return fmt::format("printf %s {} > {}\n", shell_word(content), file);
}

}  // namespace

std::string command_of(const Version& version) {
  const std::string to = fmt::format("versions/{}.yaml", version.id);
  if (version.arguments.empty()) return fmt::format("cp {} {}", shell_word(version.copied), to);
  std::string command = "seam";
  for (const std::string& argument : version.arguments) command += " " + shell_word(argument);
  return command;
}

std::string script_of(const SessionState& state) {
  std::string script =
      "#!/bin/sh\n"
      "# The versions of a session of `seam workbench`, made again: sh THIS.sh [FOLDER]\n"
      "set -eu\n"
      "seam() { command \"${SEAM:-seam}\" \"$@\"; }\n"
      "folder=${1:-session-again}\n"
      "mkdir -p \"$folder/versions\" \"$folder/effects\"\n"
      "cd \"$folder\"\n";
  std::string table;
  const auto leave_out = [&](const Version& version) {
    const std::string next = left_out_table(version.left_out);
    if (next != table) script += written("left-out.csv", next);
    table = next;
  };
  for (const Version& version : state.versions) {
    script += "\n";
    if (!version.note.empty()) {
      script += "# ";
      for (const char c : version.note) script += c == '\n' || c == '\r' ? ' ' : c;
      script += "\n";
    }
    if (!version.arguments.empty()) leave_out(version);
    if (!version.formula.empty())
      script += written(fmt::format("effects/{}.yaml", version.id), version.formula);
    script += command_of(version) + "\n";
  }
  script += "\n";
  leave_out(state.version(state.current));
  return script;
}

}  // namespace seam::tools
