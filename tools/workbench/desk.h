// What the page works at: one opened set with its session, what is known of each version, and the
// engine. Every change is saved before it is shown.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/workbench/events.h"
#include "tools/workbench/look/columns.h"
#include "tools/workbench/looked.h"
#include "tools/workbench/looking.h"
#include "tools/workbench/session/session.h"

namespace seam::tools {

// In the folder of what was computed of a version: of what it was computed.
inline constexpr const char* kKey = "key.txt";

class Desk {
 public:
  Desk();

  Events& events() { return events_; }
  // Opens the session of a set, begins one where there is none.
  void open(const std::filesystem::path& data, const std::filesystem::path& session);
  // Places that the page may offer, for the state.
  void offer(nlohmann::json recent, nlohmann::json samples, nlohmann::json named);

  nlohmann::json state();
  nlohmann::json search(const std::string& version);
  std::string script();
  // A file of what was computed of a version, the first of these that is there; empty where none is
  // yet. Throws Refusal where none will come.
  std::filesystem::path computed(const std::string& version, const std::vector<std::string>& names);
  std::filesystem::path model(const std::string& version);
  std::filesystem::path set_folder();
  nlohmann::json line(int64_t row);

  void add(uint64_t revision, const std::string& effect);
  // An effect as a formula: its stage and the lines that follow it in a file of effects.
  void add_formula(uint64_t revision, const std::string& stage, const std::string& name,
                   const std::string& text);
  void refit(uint64_t revision);
  void undo(uint64_t revision);
  void redo(uint64_t revision);
  void go_to(uint64_t revision, const std::string& version);
  void note(uint64_t revision, const std::string& version, const std::string& text);
  using Ranges = std::vector<std::pair<int64_t, int64_t>>;
  void leave_out(uint64_t revision, const Ranges& ranges, const std::string& reason);
  void take_back(uint64_t revision, const Ranges& ranges);
  void select(const Ranges& ranges);
  void cancel();
  // Runs a command that makes a set to be opened next; `what` names it while it runs.
  void prepare(const std::string& what, const std::vector<std::string>& command,
               const std::filesystem::path& folder);
  // The answer of a command that reads alone and writes JSON to the file behind its last option.
  nlohmann::json ask(std::vector<std::string> command, const std::string& name);
  // Of the model and set, as commands name them in the session's folder.
  std::vector<std::string> of_current();

 private:
  Session& session();  // Throws Refusal where nothing is open.
  // Throws Refusal (409) while another change is computed: two would make one version twice.
  std::unique_lock<std::mutex> only_change();
  // Whether what was computed is of the session that is open, and of a version that it has.
  bool is_open(uint64_t opened, const std::string& version) const;
  // Runs a command that changes something, or that answers; `what` names it while it runs.
  void run_job(const std::string& what, const std::vector<std::string>& command,
               const std::filesystem::path& folder);
  void show_job(nlohmann::json job);
  // Another version is the current one; the step says which, or throws.
  void move(uint64_t revision, const std::function<void(SessionState&)>& step);
  void change_rows(uint64_t revision, const std::string& name, const Ranges& ranges,
                   const std::function<void(std::vector<LeftOut>&, const std::vector<int>&)>& edit);
  void save(SessionState next);
  void commit(Version version);
  void make(uint64_t revision, Version version);
  Looked looked_before(const Version& version) const;
  const std::vector<int>& lines_of_rows() const;
  std::vector<int> lines_of(const Ranges& ranges) const;
  void look_at_current();
  void look(const Version& version);
  void said(const LookJob& job, const nlohmann::json& event);
  void ended(const LookJob& job, const std::string& trouble, bool cancelled);
  nlohmann::json set_json() const;
  nlohmann::json version_json(const Version& version) const;
  nlohmann::json state_unlocked() const;

  Events events_;
  mutable std::mutex mutex_;
  std::mutex changing_;  // One change at a time, which may take long.
  std::unique_ptr<Session> session_;
  std::string set_key_;  // Of the set when it was opened.
  uint64_t opened_ = 0;  // How many sessions were: versions of two may have one name.
  std::map<std::string, Looked> looked_;
  mutable std::vector<int> lines_;  // Of all rows of the set; empty: not known yet.
  nlohmann::json set_;              // What is known of it before any look.
  nlohmann::json job_;              // A change that is computed, and how far it is; null: none.
  nlohmann::json look_;             // The same of a look.
  std::string command_;             // What the last click was.
  nlohmann::json recent_ = nlohmann::json::array(), samples_ = nlohmann::json::array(),
                 named_ = nlohmann::json::array();
  std::unique_ptr<Looking> looking_;  // The last: it calls the others.
};

}  // namespace seam::tools
