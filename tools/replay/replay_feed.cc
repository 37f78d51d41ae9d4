// `seam replay feed F --robot R --client CMD`: a recorded run given to another program, without
// simulating what would follow.
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/logs/decision_list.h"
#include "app/logs/log_copy.h"
#include "app/logs/log_search.h"
#include "app/logs/open_loop.h"
#include "app/logs/replay_match.h"
#include "app/session/run_session.h"
#include "app/session/session_outputs.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "sim_core/input/shown_text.h"
#include "tools/command.h"
#include "tools/replay/replay.h"

namespace seam::tools {
namespace {

// Of decisions that differ: so many are shown field by field, and so many stand in the JSON.
constexpr size_t kShown = 5, kListed = 10'000;

struct FeedSettings {
  std::string file;
  StandIn stand_in;
  std::string expect, write_expected;
  std::string log;
  bool force = false;
  std::string json;
};

// What a program decided and logged in a robot's place.
struct Fed {
  app::DecisionList logged, found;
  std::map<SimTime, std::vector<scheduler::DebugItem>> notes;
  std::map<SimTime, uint64_t> frames;  // The newest that it had been sent.
  uint64_t frames_from_log = 0, frames_drawn = 0;
  double sim_s = 0, wall_s = 0;
  bool interrupted = false;
};

Fed feed_program(const scheduler::Log& log, const FeedSettings& settings) {
  // Cameras of robots whose frames nobody looks at are not made ready.
  app::Simulator simulator = app::make_simulator(log.header(), {.cameras_when_used = true});
  const int robot = app::robot_number(simulator.scenario, settings.stand_in.robot);
  simulator.world.sense_only(static_cast<size_t>(robot));
  app::SessionOptions session;
  session.state_hashes = false;
  session.inputs = {settings.file, settings.expect, settings.log};
  for (const RobotSpec& one : simulator.scenario.robots) session.commands[one.id] = {};
  settings.stand_in.set_up(session);
  app::OneRobotsFrames frames(log, *simulator.renderer, robot);
  session.renderer = &frames;
  app::SessionOutputs outputs(session);
  const app::JointNames joints(log.header());
  Fed fed{.logged = {settings.stand_in.robot, {}}, .found = {settings.stand_in.robot, {}}};
  std::optional<uint64_t> newest;
  const auto note = [&](const app::FedDecision& decision) {
    const SimTime time = decision.seen.time;
    fed.logged.decisions[time] = app::orders_of(decision.logged, joints);
    fed.found.decisions[time] = app::orders_of(decision.fed, joints);
    if (!decision.seen.frames.empty()) newest = decision.seen.frames.back()->frame_index;
    if (newest) fed.frames[time] = *newest;
    if (!settings.log.empty()) fed.notes[time] = decision.fed.decision.debug;
  };
  const app::SessionSummary summary =
      app::run_session(simulator, session, outputs, [&](scheduler::LiveSource& live) {
        return std::make_unique<app::OpenLoop>(log, live, robot, note, fed.interrupted);
      });
  fed.sim_s = summary.sim_s, fed.wall_s = summary.wall_s;
  fed.frames_from_log = frames.from_log(), fed.frames_drawn = frames.drawn();
  return fed;
}

// Adds what the program logged where its decision is the log's; returns how many items.
size_t write_log(const scheduler::Log& log, const FeedSettings& settings, const Fed& fed,
                 mcap::Output& output) {
  const auto& robots = log.header().robots;
  const int robot =
      static_cast<int>(std::ranges::find(robots, settings.stand_in.robot) - robots.begin());
  size_t added = 0;
  app::copy_log(log, output, [&](scheduler::TurnRecord& turn) {
    const auto notes = fed.notes.find(turn.time);
    if (notes == fed.notes.end() ||
        fed.logged.decisions.at(turn.time) != fed.found.decisions.at(turn.time))
      return false;
    bool changed = false;
    for (scheduler::Answer& answer : turn.turn.answers) {
      if (answer.robot != robot) continue;
      std::vector<scheduler::DebugItem>& items = answer.decision.debug;
      const size_t own = items.size();
      for (const scheduler::DebugItem& item : notes->second) {
        // What the run itself logged stays.
        const auto same = [&](const scheduler::DebugItem& other) {
          return other.kind == item.kind && other.name == item.name;
        };
        if (std::any_of(items.begin(), items.begin() + static_cast<ptrdiff_t>(own), same)) continue;
        items.push_back(item);
        ++added, changed = true;
      }
    }
    return changed;
  });
  output.close();
  return added;
}

nlohmann::ordered_json json_of(const Fed& fed, const std::vector<app::OtherDecision>& others,
                               const std::string& beside) {
  nlohmann::ordered_json json = {{"format", "seam-feed/1"},
                                 {"robot", fed.found.robot},
                                 {"compared_with", beside},
                                 {"decisions", fed.found.decisions.size()},
                                 {"different", others.size()},
                                 {"frames_from_log", fed.frames_from_log},
                                 {"frames_drawn", fed.frames_drawn},
                                 {"sim_s", fed.sim_s},
                                 {"wall_s", fed.wall_s},
                                 {"others", nlohmann::ordered_json::array()}};
  for (const app::OtherDecision& other : others) {
    if (json["others"].size() == kListed) break;
    nlohmann::ordered_json one = {{"time_ns", other.time.ns()},
                                  {"frame", nullptr},
                                  {"fields", nlohmann::ordered_json::array()},
                                  {"view", app::view_query(other.time, fed.found.robot)}};
    if (const auto frame = fed.frames.find(other.time); frame != fed.frames.end())
      one["frame"] = frame->second;
    for (const app::DecisionField& field : other.fields)
      one["fields"].push_back({{"field", field.name}, {"a", field.a}, {"b", field.b}});
    json["others"].push_back(std::move(one));
  }
  return json;
}

void print(const Fed& fed, const std::vector<app::OtherDecision>& others,
           const std::string& beside) {
  std::printf("%s: %zu decisions in %.6g s, fed in %.2f s (%.0f x real time)",
              shown(fed.found.robot).c_str(), fed.found.decisions.size(), fed.sim_s, fed.wall_s,
              fed.wall_s > 0 ? fed.sim_s / fed.wall_s : 0);
  if (fed.frames_from_log + fed.frames_drawn > 0)
    std::printf("; %llu frames from the log, %llu drawn again",
                static_cast<unsigned long long>(fed.frames_from_log),
                static_cast<unsigned long long>(fed.frames_drawn));
  std::printf("\n");
  if (others.empty()) {
    std::printf("all as in %s\n", shown(beside).c_str());
    return;
  }
  std::printf("%zu differ, the first at %s; %s, and the program:\n", others.size(),
              app::seconds(others.front().time).c_str(), shown(beside).c_str());
  for (size_t i = 0; i < std::min(kShown, others.size()); ++i) {
    const auto frame = fed.frames.find(others[i].time);
    std::printf(
        "%s%s\n", app::seconds(others[i].time).c_str(),
        frame == fed.frames.end() ? "" : fmt::format(", from frame {}", frame->second).c_str());
    std::fputs(shown_lines(app::to_text(others[i].fields)).c_str(), stdout);
  }
  if (others.size() > kShown) std::printf("... %zu more: --json\n", others.size() - kShown);
}

void feed(const FeedSettings& settings) {
  const OutputRules rules{.inputs = {settings.file}};
  OutputFile json(settings.json, rules), expected(settings.write_expected, rules);
  const scheduler::Log log = scheduler::Log::open(settings.file);
  std::unique_ptr<mcap::Output> copy;
  if (!settings.log.empty()) {
    OutputRules log_rules = rules;
    log_rules.overwrite = settings.force;
    copy = mcap::create_file(settings.log, log_rules);
  }
  std::optional<app::DecisionList> wanted;
  if (!settings.expect.empty()) {
    wanted = app::decision_list_from(settings.expect);
    if (wanted->robot != settings.stand_in.robot)
      throw UsageError(fmt::format("--expect {}: its decisions are of '{}', expected those of '{}'",
                                   settings.expect, wanted->robot, settings.stand_in.robot));
  }
  const Fed fed = feed_program(log, settings);
  if (fed.interrupted) throw InputError("stopped before the log's end");
  const std::string beside = wanted ? settings.expect : "the log";
  const auto others = app::other_decisions(wanted ? *wanted : fed.logged, fed.found);
  print(fed, others, beside);
  if (expected) expected.fill(app::to_json(fed.found));
  if (json)
    json.fill(json_of(fed, others, beside)
                  .dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) +
              "\n");
  if (copy) {
    const size_t added = write_log(log, settings, fed, *copy);
    std::printf("%s: the log with %zu more values, texts and drawings\n",
                shown(settings.log).c_str(), added);
  }
  // Whoever writes what is expected from now on, or adds values, asked for no verdict.
  if (!others.empty() && (wanted || settings.write_expected.empty())) throw ExitCode{1};
}

}  // namespace

void add_replay_feed(app::Command replay) {
  app::Command command = replay.add_subcommand(
      "feed",
      "Gives what a robot received in a log to another program, at full speed, and lists where it\n"
      "decides otherwise; what it decides has no effect");
  auto settings = std::make_shared<FeedSettings>();
  command.add_option("F", settings->file, "The log").required();
  command.add_option("--robot", settings->stand_in.robot, "The robot whose place the program takes")
      .required();
  add_stand_in_options(command, settings->stand_in);
  command.add_option("--expect", settings->expect,
                     "Compares with the decisions of this file in place of the log's: a test");
  command.add_option("--write-expected", settings->write_expected,
                     "Writes the program's decisions here, for --expect (seam-decisions/1)");
  command.add_option("--log", settings->log,
                     "Writes a copy of the log to which the values, texts and drawings that the\n"
                     "program logs are added, where its decision is the log's");
  command.add_flag("--force", settings->force, "Replaces a log that exists");
  command.add_option("--json", settings->json, "Write what differs as seam-feed/1 to this file");
  command.footer(
      "Exit code 0: all decisions are equal; 1: some differ. Frames come from the log where it "
      "has\n"
      "them as pictures, and are drawn again elsewhere.\n"
      "Example: seam replay feed swing.mcap --robot red1 --client 'head_swing' --write-expected "
      "expected.json\n"
      "Example: seam replay feed swing.mcap --robot red1 --client 'head_swing' --expect "
      "expected.json");
  command.callback([settings] { feed(*settings); });
}

}  // namespace seam::tools
