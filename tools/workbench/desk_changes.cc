// What a person does at the desk: each change is a version, or moves to one.
#include <algorithm>

#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"
#include "tools/pages/refusal.h"
#include "tools/workbench/desk.h"
#include "tools/workbench/formula.h"
#include "tools/workbench/session/cache_key.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostNote = 10'000;  // Of a note or reason.
// Of what is chosen, which each state repeats.
constexpr size_t kMostRanges = 20'000;

// Takes the lines out of all that is left out.
void take_out(std::vector<LeftOut>& left_out, const std::vector<int>& lines) {
  for (LeftOut& one : left_out) {
    std::erase_if(one.lines, [&](int line) { return std::ranges::binary_search(lines, line); });
  }
  std::erase_if(left_out, [](const LeftOut& one) { return one.lines.empty(); });
}

// In order, neighbours as one.
Desk::Ranges merged(Desk::Ranges ranges, size_t rows) {
  if (ranges.size() > kMostRanges)
    throw UsageError(fmt::format("ranges: found {}, expected at most {}: choose fewer pieces",
                                 ranges.size(), kMostRanges));
  std::ranges::sort(ranges);
  Desk::Ranges out;
  for (const auto& [from, to] : ranges) {
    if (from < 0 || to < from || to >= static_cast<int64_t>(rows))
      throw UsageError(
          fmt::format("ranges: found {} to {}, expected rows below {}", from, to, rows));
    if (!out.empty() && from <= out.back().second + 1) {
      out.back().second = std::max(out.back().second, to);
    } else {
      out.emplace_back(from, to);
    }
  }
  return out;
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

std::vector<std::string> Desk::of_current() {
  const std::lock_guard lock(mutex_);
  const SessionState& state = session().state();
  return about(state, state.version(state.current), "left-out.csv");
}

void Desk::look(const Version& version) {
  const std::string folder = "cache/" + version.id;
  LookJob job{
      .opened = opened_, .version = version.id, .folder = session_->folder(), .commands = {}};
  try {
    make_output_folder(session_->cache(version.id));
    if (!version.left_out.empty())
      write_file_atomically(session_->cache(version.id) / "left-out.csv",
                            left_out_table(version.left_out));
    write_file_atomically(session_->cache(version.id) / kKey,
                          cache_key(set_key_, *session_, version));
  } catch (const InputError& error) {
    looked_[version.id].trouble = error.what();
    events_.publish("state", state_unlocked());
    return;
  }
  const std::vector<std::string> about_it =
      about(session_->state(), version, folder + "/left-out.csv");
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

// A new version behind the current one, made by the command that it begins with.
void Desk::make(uint64_t revision, Version version) {
  const auto change = only_change();
  fs::path folder;
  {
    const std::lock_guard lock(mutex_);
    session().expect(revision);
    const SessionState& now = session_->state();
    const Version& current = now.version(now.current);
    version.id = now.next_id();
    version.parent = current.id;
    version.left_out = current.left_out;
    version.arguments = arguments_of(now, version);
    if (!version.formula.empty()) session_->write_part(formula_name(version.id), version.formula);
    folder = session_->folder();
  }
  run_job(version.arguments[0] + " " + version.name, version.arguments, folder);
  commit(std::move(version));
}

void Desk::show_job(nlohmann::json job) {
  const std::lock_guard lock(mutex_);
  job_ = std::move(job);
  events_.publish("state", state_unlocked());
}

// The job stays in the state where the command did what it should: what follows takes it away.
void Desk::run_job(const std::string& what, const std::vector<std::string>& command,
                   const fs::path& folder) {
  show_job({{"what", what}, {"doing", ""}, {"done", 0}, {"of", 0}});
  try {
    looking_->run_alone(command, folder, [&](const nlohmann::json& event) {
      if (event.value("event", "") != "work") return;
      const std::lock_guard lock(mutex_);
      job_ = {{"what", what},
              {"doing", event.value("doing", "")},
              {"done", event.value("done", uint64_t{0})},
              {"of", event.value("of", uint64_t{0})}};
      events_.publish("job", job_);
    });
  } catch (...) {
    show_job(nullptr);
    look_at_current();
    throw;
  }
}

// The version is the current one from now on.
void Desk::commit(Version version) {
  {
    const std::lock_guard lock(mutex_);
    SessionState next = session_->state();
    job_ = nullptr;
    std::string command = command_of(version);
    next.current = version.id;
    next.undone.clear();
    next.versions.push_back(std::move(version));
    save(std::move(next));
    command_ = std::move(command);
  }
  look_at_current();
}

void Desk::add(uint64_t revision, const std::string& effect) {
  if (!is_effect_name(effect))
    throw UsageError("effect: expected the name of an effect of the catalogue");
  make(revision, {.name = effect, .arguments = {"add"}});
}

void Desk::add_formula(uint64_t revision, const std::string& stage, const std::string& name,
                       const std::string& text) {
  make(revision, {.name = name, .arguments = {"add"}, .formula = formula_file(stage, name, text)});
}

void Desk::refit(uint64_t revision) {
  make(revision, {.name = "refitted", .arguments = {"fit"}});
}

void Desk::move(uint64_t revision, const std::function<void(SessionState&)>& step) {
  const auto change = only_change();
  {
    const std::lock_guard lock(mutex_);
    session().expect(revision);
    SessionState next = session_->state();
    step(next);
    std::string command = command_of(next.version(next.current));
    save(std::move(next));
    command_ = std::move(command);
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
  for (const auto& [from, to] : merged(ranges, all.size()))
    lines.insert(lines.end(), all.begin() + from, all.begin() + to + 1);
  if (lines.empty()) throw UsageError("ranges: found no row, expected those that are chosen");
  std::sort(lines.begin(), lines.end());
  return lines;
}

// A version with the same model, whose rows left out the edit changes.
void Desk::change_rows(
    uint64_t revision, const std::string& name, const Ranges& ranges,
    const std::function<void(std::vector<LeftOut>&, const std::vector<int>&)>& edit) {
  const auto change = only_change();
  Version version;
  {
    const std::lock_guard lock(mutex_);
    session().expect(revision);
    const std::vector<int> lines = lines_of(ranges);
    version = same_model(session_->state(), name);
    take_out(version.left_out, lines);
    edit(version.left_out, lines);
    session_->write_part(model_name(version.id), read_file(session_->model(version.parent)));
  }
  commit(std::move(version));
}

void Desk::leave_out(uint64_t revision, const Ranges& ranges, const std::string& reason) {
  if (reason.size() > kMostNote) throw UsageError("reason: is too long");
  const std::string why = one_cell(reason);
  if (why.empty()) throw UsageError("reason: found none, expected why these rows are left out");
  change_rows(revision, "left out: " + why, ranges,
              [&](std::vector<LeftOut>& left_out, const std::vector<int>& lines) {
                const auto same = std::ranges::find(left_out, why, &LeftOut::reason);
                if (same == left_out.end()) {
                  left_out.push_back({lines, why});
                } else {
                  same->lines.insert(same->lines.end(), lines.begin(), lines.end());
                  std::sort(same->lines.begin(), same->lines.end());
                }
              });
}

void Desk::take_back(uint64_t revision, const Ranges& ranges) {
  change_rows(revision, "taken back", ranges, [](auto&, const auto&) {});
}

void Desk::select(const Ranges& ranges) {
  const std::lock_guard lock(mutex_);
  SessionState next = session().state();
  next.selection = merged(ranges, lines_of_rows().size());
  session_->keep(std::move(next));
}

void Desk::cancel() {
  looking_->cancel();
}

void Desk::prepare(const std::string& what, const std::vector<std::string>& command,
                   const fs::path& folder) {
  const auto change = only_change();
  run_job(what, command, folder);
  show_job(nullptr);
}

nlohmann::json Desk::ask(std::vector<std::string> command, const std::string& name) {
  const auto change = only_change();
  fs::path folder;
  {
    const std::lock_guard lock(mutex_);
    folder = session().folder();
    const std::string file = fmt::format("cache/{}/{}", session_->state().current, name);
    make_output_folder(session_->cache(session_->state().current));
    fs::remove(folder / file);
    command.push_back(file);
  }
  const std::string file = command.back();
  run_job(command.front(), command, folder);
  show_job(nullptr);
  look_at_current();
  return fs::path(file).extension() == ".json" ? json_of(folder / file)
                                               : nlohmann::json((folder / file).string());
}

}  // namespace seam::tools
