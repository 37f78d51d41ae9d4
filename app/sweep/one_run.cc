#include "app/sweep/one_run.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "app/session/run_session.h"
#include "app/session/session_outputs.h"
#include "app/simulator.h"
#include "app/sweep/sweep_progress.h"
#include "sim_core/base/error.h"
#include "sim_core/base/hash.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* kEnds[] = {"finished", "stopped", "aborted"};
constexpr size_t kMostErrorBytes = 16'000;

// Why a run failed, and under it what its behaviours printed last.
std::string error_of(const SessionSummary& summary) {
  std::string text = summary.abort_reason;
  for (const std::string& line : summary.last_lines) text += "\n" + line;
  return text;
}

std::string key_of(const std::string& scenario_text, const Scenario& scenario, const Makers& makers,
                   ProgramPrints& prints) {
  Hasher hasher;
  hasher.add(std::string_view(makers.program));
  hasher.add(std::string_view(scenario_text));
  for (const RobotSpec& robot : scenario.robots) {
    const auto& command = robot.behaviour.command;
    if (!command.empty()) hasher.add(std::string_view(prints.of(command, robot.id)));
  }
  return to_hex(hasher.digest());
}

// All that formulas may read, by name.
std::map<std::string, std::optional<double>> known_numbers(const SweepPlan& plan,
                                                           const RunRecord& record) {
  std::map<std::string, std::optional<double>> known;
  const RunSettings settings = plan.settings(record.run);
  for (size_t i = 0; i < settings.values.size(); ++i)
    known[plan.parameters()[i]] = number_of(settings.values[i]);
  known["seed"] = static_cast<double>(record.seed);
  known["sim_s"] = record.sim_s;
  known["frames"] = static_cast<double>(record.frames);
  known["decisions"] = static_cast<double>(record.decisions);
  known["red_score"] = record.red_score;
  known["blue_score"] = record.blue_score;
  return known;
}

std::string unlogged_text(const KeptValue& value, uint64_t run, const LoggedSummaries& logged) {
  std::vector<std::string> names;
  for (const auto& [key, summary] : logged)
    if (key.first == value.robot) names.push_back(key.second);
  std::string known = names.empty() ? ", and no other" : suggestion_for(value.name, names);
  if (!known.ends_with('?')) known += '.';
  return fmt::format(
      "{}: robot '{}' logged no value '{}' in run {}{} Where only some runs log it, write "
      "{{name: {}, optional: true}}",
      value.where, value.robot, value.name, run, known, value.name);
}

// Values that were logged, and formulas over them: one that reads what is missing, or that gives no
// number, is missing too.
void keep_values(const SweepPlan& plan, const LoggedSummaries& logged, RunRecord& record) {
  auto known = known_numbers(plan, record);
  const auto keep = [&](const std::string& column, std::optional<double> value) {
    if (value && !std::isfinite(*value)) value.reset();
    known[column] = value;
    record.kept.push_back(value);
  };
  for (const KeptValue& value : plan.keep().values) {
    const auto found = logged.find({value.robot, value.name});
    if (found == logged.end() && !value.optional)
      record.unlogged.push_back(unlogged_text(value, record.run, logged));
    const bool counts = value.statistic == Statistic::count;
    keep(value.column, found != logged.end() ? std::optional(found->second.get(value.statistic))
                                             : (counts ? std::optional(0.0) : std::nullopt));
  }
  for (const KeptFormula& formula : plan.keep().formulas) {
    std::vector<double> values;
    for (const std::string& name : formula.reads)
      if (known[name]) values.push_back(*known[name]);
    const bool whole = values.size() == formula.reads.size();
    keep(formula.column, whole ? std::optional(formula.formula(values)) : std::nullopt);
  }
}

void run_it(const SweepPlan& plan, Scenario scenario, const Makers& makers, ProgramPrints& prints,
            const OneRunOptions& options, RunRecord& record) {
  Simulator simulator = make_simulator(
      std::move(scenario), {.render_workers = options.render_workers, .cameras_when_used = true});
  record.key = key_of(simulator.header.scenario_text, simulator.scenario, makers, prints);
  SessionOptions session{.force = true,
                         .progress = false,
                         .show_printed = false,
                         .wall_limit_s = plan.wall_limit_s(),
                         .standbys = options.standbys};
  const std::string name = fmt::format("run_{:06}", record.run);
  const fs::path log = options.files / (name + ".mcap");
  const fs::path partial = partial_log(options.files, record.run);
  // Of a run whose process was killed: it begins anew.
  std::error_code unknown;
  if (plan.keep().logs) fs::remove(partial, unknown);
  if (plan.keep().logs) session.log = partial.string();
  if (plan.keep().frames) session.frames = (options.files / name).string();
  SessionSummary summary;
  {
    SessionOutputs outputs(session);
    summary = run_session(simulator, session, outputs);
  }
  record.end = kEnds[static_cast<size_t>(summary.end)];
  if (summary.end == scheduler::EndReason::stopped) {
    fs::remove(partial, unknown);
    return;
  }
  if (plan.keep().logs) fs::rename(partial, log);
  record.notes = summary.clamped_lines;
  record.notes.insert(record.notes.end(), summary.refused_lines.begin(),
                      summary.refused_lines.end());
  record.sim_s = summary.sim_s;
  record.frames = summary.frames;
  record.decisions = summary.decisions;
  record.fingerprint = to_hex(summary.fingerprint);
  // What half a run gives is no result: nothing of it is averaged by accident.
  if (summary.end == scheduler::EndReason::aborted) {
    record.error = error_of(summary);
    return;
  }
  if (summary.has_score) {
    record.red_score = summary.red_score;
    record.blue_score = summary.blue_score;
  }
  keep_values(plan, summary.logged, record);
}

Json json_of(const std::optional<double>& value) {
  return value ? Json(*value) : Json();
}

}  // namespace

fs::path partial_log(const fs::path& files, uint64_t run) {
  return files / fmt::format("run_{:06}.part", run);
}

RunRecord make_run(const SweepPlan& plan, uint64_t run, const Makers& makers, ProgramPrints& prints,
                   const OneRunOptions& options) {
  RunRecord record{.run = run};
  const Stopwatch watch;
  try {
    Scenario scenario = plan.scenario(run);
    record.seed = scenario.seed;
    if (options.move) options.move(scenario);
    run_it(plan, std::move(scenario), makers, prints, options, record);
  } catch (const std::exception& error) {
    record.error = error.what();
  }
  record.wall_s = watch.s();
  // Of much that was printed the end says most.
  if (record.error.size() > kMostErrorBytes) {
    const std::string first = record.error.substr(0, record.error.find('\n'));
    const std::string last = record.error.substr(record.error.size() - kMostErrorBytes / 2);
    record.error = first.substr(0, kMostErrorBytes / 2) + "\n..." + last;
  }
  return record;
}

std::string to_text(const RunRecord& record) {
  Json kept = Json::array();
  for (const auto& value : record.kept) kept.push_back(json_of(value));
  const Json json = {{"run", record.run},
                     {"key", record.key},
                     {"error", record.error},
                     {"seed", record.seed},
                     {"end", record.end},
                     {"sim_s", record.sim_s},
                     {"wall_s", record.wall_s},
                     {"frames", record.frames},
                     {"decisions", record.decisions},
                     {"fingerprint", record.fingerprint},
                     {"red_score", json_of(record.red_score)},
                     {"blue_score", json_of(record.blue_score)},
                     {"kept", kept},
                     {"unlogged", record.unlogged},
                     {"notes", record.notes}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

RunRecord record_from_text(const std::string& text) {
  const Json json = Json::parse(text);
  RunRecord record{.run = json.at("run"),
                   .key = json.at("key"),
                   .error = json.at("error"),
                   .seed = json.at("seed"),
                   .end = json.at("end"),
                   .sim_s = json.at("sim_s"),
                   .wall_s = json.at("wall_s"),
                   .frames = json.at("frames"),
                   .decisions = json.at("decisions"),
                   .fingerprint = json.at("fingerprint"),
                   .unlogged = json.at("unlogged"),
                   .notes = json.at("notes")};
  const auto score = [&](const char* key) {
    return json.at(key).is_null() ? std::nullopt : std::optional(json.at(key).get<int>());
  };
  record.red_score = score("red_score");
  record.blue_score = score("blue_score");
  for (const Json& value : json.at("kept"))
    record.kept.push_back(value.is_null() ? std::nullopt : std::optional(value.get<double>()));
  return record;
}

}  // namespace seam::app
