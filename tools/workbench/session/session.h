// A session of the workbench: models as they came about, in a folder that a person can read
// (docs/workbench.md, "What a session is"). What the page shows as saved is in its files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tools/workbench/session/folder_lock.h"

namespace seam::tools {

inline constexpr size_t kMostVersions = 999;

// Rows of observations that are left out for one reason, by their lines in the file.
struct LeftOut {
  std::vector<int> lines;
  std::string reason;
};

struct Version {
  std::string id;      // "003": the name of versions/003.yaml.
  std::string parent;  // Empty: none.
  std::string name;    // What came with it: an effect, "nominal", "left out".
  std::string note;
  // How it was made, run in the session's folder: arguments of `seam`; empty: a copy of `copied`.
  std::vector<std::string> arguments;
  std::string copied;
  std::string formula;            // The text of effects/ID.yaml, where its effect is a formula.
  std::vector<LeftOut> left_out;  // Before it was made.
};

// What is in session.json.
struct SessionState {
  uint64_t revision = 0;
  std::string data;  // The folder of the set, absolute.
  std::string current;
  std::vector<std::string> undone;  // What redo goes to, the next one last.
  std::vector<std::pair<int64_t, int64_t>>
      selection;  // Rows, the first and the last of each range.
  std::vector<Version> versions;

  const Version* find(const std::string& id) const;
  const Version& version(const std::string& id) const;  // Throws Refusal.
  std::string next_id() const;                          // Likewise, where there is no room.
};

class Session {
 public:
  // Opens the session in this folder, or begins one with a copy of the set's model. `before`: the
  // session that was open in this program, if any, which may be the same. Throws InputError for a
  // session of another set, for one that cannot be read, and for one that another program has open.
  Session(std::filesystem::path folder, const std::filesystem::path& data, const Session* before);

  const SessionState& state() const { return state_; }
  const std::filesystem::path& folder() const { return folder_; }
  // Throws InputError where a link leads out of the session's folder; likewise `cache`.
  std::filesystem::path model(const std::string& id) const;
  // The folder of what can be computed again; it may not be there yet.
  std::filesystem::path cache(const std::string& id) const;

  // Writes the next state, with its left-out.csv, and then has it. Throws Refusal (507) where that
  // cannot be written, or a model of a version is gone: all is as before.
  void save(SessionState next);
  // A model or formula of a version that is saved next. Throws Refusal (507).
  void write_part(const std::string& name, const std::string& text) const;
  // The same of what is no step of the work (a selection): the revision stays.
  void keep(SessionState next);
  // Throws Refusal (409) for a revision that is not the present one.
  void expect(uint64_t revision) const;

 private:
  void begin(const std::filesystem::path& data, const std::filesystem::path& nominal);
  void read(const std::filesystem::path& data);
  void write(const SessionState& next) const;
  // Throws InputError where the model of a version is gone.
  void expect_models(const SessionState& state) const;

  std::filesystem::path folder_;
  std::shared_ptr<const FolderLock> lock_;
  SessionState state_;
};

std::string model_name(const std::string& id);    // In the session's folder.
std::string formula_name(const std::string& id);  // Likewise.
// A text as it can stand in a cell of a table: one line, no commas, no blanks around.
std::string one_cell(std::string text);
bool is_effect_name(const std::string& name);
// `--model MODEL --data DATA` of a version, and `--leave-out` with this table where rows are left
// out.
std::vector<std::string> about(const SessionState& state, const Version& version,
                               const std::string& left_out);
// The command that makes a version from its parent: `add` or `fit`, as its first argument says.
std::vector<std::string> arguments_of(const SessionState& state, const Version& version);

// The table that `--leave-out` reads.
std::string left_out_table(const std::vector<LeftOut>& left_out);

// A shell script that ends in the same versions and left-out.csv, in a folder that it is given.
std::string script_of(const SessionState& state);
// What made a version, as a person would type it in the session's folder.
std::string command_of(const Version& version);

nlohmann::json to_json(const SessionState& state);
// Throws InputError, or json::exception, for what this program would not have written.
SessionState session_from(const nlohmann::json& json);

}  // namespace seam::tools
