// What a person does at the desk: each change is a version, or moves to one.
#include <algorithm>

#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "tools/pages/refusal.h"
#include "tools/workbench/desk.h"
#include "tools/workbench/formula.h"
#include "tools/workbench/look/columns.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostVersions = 999;
constexpr size_t kMostNote = 10'000;  // Of a note or reason.

void check_effect_name(const std::string& name) {
  const bool plain = !name.empty() && name.size() <= 100 && name.front() != '-' &&
                     name.find_first_not_of(
                         "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                         "0123456789_@-") == std::string::npos;
  if (!plain) throw UsageError("effect: expected the name of an effect of the catalogue");
}

std::string model_name(const std::string& id) {
  return "versions/" + id + ".yaml";
}

// A line of a table: no commas, no line ends.
std::string one_cell(std::string reason) {
  for (char& c : reason) {
    if (c == ',') c = ';';
    if (static_cast<unsigned char>(c) < ' ' || c == '"') c = ' ';
  }
  const size_t first = reason.find_first_not_of(' ');
  if (first == std::string::npos)
    throw UsageError("reason: found none, expected why these rows are left out");
  return reason.substr(first, reason.find_last_not_of(' ') - first + 1);
}

// Takes the lines out of all that is left out.
void take_out(std::vector<LeftOut>& left_out, const std::vector<int>& lines) {
  for (LeftOut& one : left_out) {
    std::erase_if(one.lines, [&](int line) { return std::ranges::binary_search(lines, line); });
  }
  std::erase_if(left_out, [](const LeftOut& one) { return one.lines.empty(); });
}

// A version with the same model, whose rows differ.
Version same_model(const SessionState& state, const std::string& name) {
  const Version& current = state.version(state.current);
  return {.id = state.next_id(),
          .parent = current.id,
          .name = name,
          .copied = model_name(current.id),
          .left_out = current.left_out};
}

}  // namespace

std::unique_lock<std::mutex> Desk::only_change() {
  std::unique_lock change(changing_, std::try_to_lock);
  if (!change) throw Refusal(409, "another change is being computed: wait for it, or cancel it");
  return change;
}

void Desk::save(SessionState next) {
  session_->save(std::move(next));
  events_.publish("state", state_unlocked());
}

std::vector<std::string> Desk::about(const Version& version, const std::string& left_out) const {
  std::vector<std::string> arguments = {"--model", model_name(version.id), "--data",
                                        session_->state().data};
  if (!version.left_out.empty()) {
    arguments.push_back("--leave-out");
    arguments.push_back(left_out);
  }
  return arguments;
}

std::vector<std::string> Desk::of_current() {
  const std::lock_guard lock(mutex_);
  return about(session().state().version(session().state().current), "left-out.csv");
}

void Desk::look(const Version& version) {
  const std::string folder = "cache/" + version.id;
  const fs::path cache = session_->cache(version.id);
  LookJob job{
      .opened = opened_, .version = version.id, .folder = session_->folder(), .commands = {}};
  if (!version.left_out.empty())
    write_file_atomically(cache / "left-out.csv", left_out_table(version.left_out));
  const std::vector<std::string> about_it = about(version, folder + "/left-out.csv");
  const Looked& looked = looked_[version.id];
  if (!looked.ended()) {
    std::vector<std::string> command = {"workbench", session_->state().data, "--look", folder};
    command.insert(command.end(), about_it.begin(), about_it.begin() + 2);
    command.insert(command.end(), about_it.begin() + 4, about_it.end());
    job.commands.push_back(std::move(command));
  }
  if (!looked.diagnose.is_object()) {
    std::vector<std::string> command = {"diagnose"};
    command.insert(command.end(), about_it.begin(), about_it.end());
    for (const std::string& word : {std::string("--json"), folder + "/diagnose.json",
                                    std::string("--report"), folder + "/report.html"})
      command.push_back(word);
    job.commands.push_back(std::move(command));
  }
  if (!job.commands.empty()) looking_->want(std::move(job));
}

void Desk::look_at_current() {
  const std::lock_guard lock(mutex_);
  if (!session_) return;
  const Version& current = session_->state().version(session_->state().current);
  const Looked& looked = looked_[current.id];
  if (looked.trouble.empty() && !looked.cancelled) look(current);
}

// A new version behind the current one, made by a command that ends with `--out`. `before` is
// written to effects/ID.yaml first, where it is not empty.
void Desk::make(uint64_t revision, Version version, std::vector<std::string> command) {
  const auto change = only_change();
  fs::path folder;
  {
    const std::lock_guard lock(mutex_);
    session().expect(revision);
    const SessionState& now = session_->state();
    if (now.versions.size() >= kMostVersions)
      throw Refusal(400, "a session has at most 999 versions: begin another one");
    const Version& current = now.version(now.current);
    version.id = now.next_id();
    version.parent = current.id;
    version.left_out = current.left_out;
    if (!version.formula.empty()) {
      make_output_folder(session_->folder() / "effects");
      write_file_atomically(session_->folder() / "effects" / (version.id + ".yaml"),
                            version.formula);
      command.push_back("effects/" + version.id + ".yaml");
    }
    const auto about_it = about(current, "left-out.csv");
    command.insert(command.end(), about_it.begin(), about_it.end());
    command.push_back("--out");
    command.push_back(model_name(version.id));
    version.arguments = command;
    folder = session_->folder();
    job_ = {{"what", command[0] + " " + version.name}, {"done", 0}, {"of", 0}};
    events_.publish("state", state_unlocked());
  }
  try {
    looking_->run_alone(command, folder);
  } catch (...) {
    {
      const std::lock_guard lock(mutex_);
      job_ = nullptr;
      events_.publish("state", state_unlocked());
    }
    look_at_current();
    throw;
  }
  commit(std::move(version));
}

// The version is the current one from now on.
void Desk::commit(Version version) {
  {
    const std::lock_guard lock(mutex_);
    SessionState next = session_->state();
    job_ = nullptr;
    command_ = command_of(version);
    next.current = version.id;
    next.undone.clear();
    next.versions.push_back(std::move(version));
    save(std::move(next));
  }
  look_at_current();
}

void Desk::add(uint64_t revision, const std::string& effect) {
  check_effect_name(effect);
  make(revision, {.name = effect}, {"add", effect});
}

void Desk::add_formula(uint64_t revision, const std::string& stage, const std::string& name,
                       const std::string& text) {
  make(revision, {.name = name, .formula = formula_file(stage, name, text)}, {"add"});
}

void Desk::refit(uint64_t revision) {
  make(revision, {.name = "refitted"}, {"fit"});
}

void Desk::move(uint64_t revision, const std::function<void(SessionState&)>& step) {
  const auto change = only_change();
  {
    const std::lock_guard lock(mutex_);
    session().expect(revision);
    SessionState next = session_->state();
    step(next);
    command_ = command_of(next.version(next.current));
    save(std::move(next));
  }
  look_at_current();
}

void Desk::go_to(uint64_t revision, const std::string& version) {
  move(revision, [&](SessionState& next) {
    next.current = next.version(version).id;
    next.undone.clear();
  });
}

void Desk::undo(uint64_t revision) {
  move(revision, [](SessionState& next) {
    const Version& current = next.version(next.current);
    if (current.parent.empty()) throw Refusal(400, "there is nothing to undo");
    next.undone.push_back(current.id);
    next.current = current.parent;
  });
}

void Desk::redo(uint64_t revision) {
  move(revision, [](SessionState& next) {
    if (next.undone.empty()) throw Refusal(400, "there is nothing to redo");
    next.current = next.undone.back();
    next.undone.pop_back();
  });
}

void Desk::note(uint64_t revision, const std::string& version, const std::string& text) {
  if (text.size() > kMostNote) throw UsageError("note: is too long");
  const std::lock_guard lock(mutex_);
  session().expect(revision);
  SessionState next = session_->state();
  const auto found = std::ranges::find(next.versions, next.version(version).id, &Version::id);
  found->note = text;
  save(std::move(next));
}

std::vector<int> Desk::lines_of(const Ranges& ranges) const {
  const std::vector<int>& all = lines_of_rows();
  std::vector<int> lines;
  for (const auto& [from, to] : ranges) {
    if (from < 0 || to < from || to >= static_cast<int64_t>(all.size()))
      throw UsageError(
          fmt::format("ranges: found {} to {}, expected rows below {}", from, to, all.size()));
    for (int64_t row = from; row <= to; ++row) lines.push_back(all[static_cast<size_t>(row)]);
  }
  if (lines.empty()) throw UsageError("ranges: found no row, expected those that are chosen");
  std::sort(lines.begin(), lines.end());
  lines.erase(std::unique(lines.begin(), lines.end()), lines.end());
  return lines;
}

void Desk::leave_out(uint64_t revision, const Ranges& ranges, const std::string& reason) {
  if (reason.size() > kMostNote) throw UsageError("reason: is too long");
  const auto change = only_change();
  Version version;
  {
    const std::lock_guard lock(mutex_);
    session().expect(revision);
    const std::vector<int> lines = lines_of(ranges);
    version = same_model(session_->state(), "left out: " + one_cell(reason));
    take_out(version.left_out, lines);
    const auto same = std::ranges::find(version.left_out, one_cell(reason), &LeftOut::reason);
    if (same == version.left_out.end()) {
      version.left_out.push_back({lines, one_cell(reason)});
    } else {
      same->lines.insert(same->lines.end(), lines.begin(), lines.end());
      std::sort(same->lines.begin(), same->lines.end());
    }
    fs::copy_file(session_->folder() / version.copied, session_->model(version.id),
                  fs::copy_options::overwrite_existing);
  }
  commit(std::move(version));
}

void Desk::take_back(uint64_t revision, const Ranges& ranges) {
  const auto change = only_change();
  Version version;
  {
    const std::lock_guard lock(mutex_);
    session().expect(revision);
    version = same_model(session_->state(), "taken back");
    take_out(version.left_out, lines_of(ranges));
    fs::copy_file(session_->folder() / version.copied, session_->model(version.id),
                  fs::copy_options::overwrite_existing);
  }
  commit(std::move(version));
}

void Desk::select(const Ranges& ranges) {
  const std::lock_guard lock(mutex_);
  SessionState next = session().state();
  next.selection = ranges;
  session_->keep(std::move(next));
}

void Desk::cancel() {
  looking_->cancel();
}

void Desk::prepare(const std::string& what, const std::vector<std::string>& command,
                   const fs::path& folder) {
  const auto change = only_change();
  const auto show = [&](nlohmann::json job) {
    const std::lock_guard lock(mutex_);
    job_ = std::move(job);
    events_.publish("state", state_unlocked());
  };
  show({{"what", what}, {"done", 0}, {"of", 0}});
  try {
    looking_->run_alone(command, folder);
  } catch (...) {
    show(nullptr);
    look_at_current();
    throw;
  }
  show(nullptr);
}

nlohmann::json Desk::ask(std::vector<std::string> command, const std::string& name) {
  const auto change = only_change();
  fs::path folder;
  {
    const std::lock_guard lock(mutex_);
    folder = session().folder();
    const std::string file = fmt::format("cache/{}/{}", session_->state().current, name);
    session_->cache(session_->state().current);
    fs::remove(folder / file);
    command.push_back(file);
  }
  const std::string file = command.back();
  try {
    looking_->run_alone(command, folder);
  } catch (...) {
    look_at_current();
    throw;
  }
  look_at_current();
  return fs::path(file).extension() == ".json" ? json_of(folder / file)
                                               : nlohmann::json((folder / file).string());
}

}  // namespace seam::tools
