#include "scheduler/replay/player.h"

#include <fmt/format.h>

#include <algorithm>

#include "scheduler/wire/wire.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {
namespace {

// Whether two answers make the same difference to the run, by their bytes on the wire.
bool same_decision(const Answer& a, const Answer& b, const std::vector<std::string>& robots) {
  Turn turn_a, turn_b;
  turn_a.answers = {a};
  turn_b.answers = {b};
  for (Turn* turn : {&turn_a, &turn_b}) turn->answers[0].decision.debug.clear();
  return encode_turn(SimTime(), turn_a, robots) == encode_turn(SimTime(), turn_b, robots);
}

}  // namespace

std::optional<Turn> TurnReader::turn(
    SimTime now, std::span<const std::shared_ptr<const Observation>> observations) {
  std::optional<LogRecord> record = cursor_.next();
  if (!record) return std::nullopt;
  TurnRecord& logged = std::get<TurnRecord>(*record);
  if (logged.time != now) {
    throw InputError(
        fmt::format("the log decides at {} ns next, the re-run asks at {} ns: a part "
                    "of the log is missing, or it belongs to another run",
                    logged.time.ns(), now.ns()));
  }
  bool fits = logged.turn.answers.size() == observations.size();
  for (size_t i = 0; fits && i < observations.size(); ++i) {
    fits = logged.turn.answers[i].robot == observations[i]->robot;
  }
  if (!fits) {
    throw InputError(
        fmt::format("the log answers for other robots than were asked at {} ns", now.ns()));
  }
  return std::move(logged.turn);
}

std::optional<Turn> LogSource::decide(
    SimTime now, std::span<const std::shared_ptr<const Observation>> observations) {
  return turns_.turn(now, observations);
}

std::optional<Turn> MixedSource::decide(
    SimTime now, std::span<const std::shared_ptr<const Observation>> observations) {
  std::optional<Turn> live = live_.decide(now, observations);
  if (!live || log_is_over_) return live;
  std::optional<Turn> logged = turns_.turn(now, observations);
  if (!logged) {
    log_is_over_ = true;
    report_.departs_ns = std::min<int64_t>(report_.departs_ns, now.ns());
    if (!report_.live_since) report_.live_since = now;
    return live;
  }
  std::vector<std::string> robots;
  for (const Answer& answer : logged->answers) {
    robots.resize(std::max<size_t>(robots.size(), static_cast<size_t>(answer.robot) + 1), "r");
  }
  for (size_t i = 0; i < logged->answers.size(); ++i) {
    mix(now, logged->answers[i], live->answers[i], robots);
  }
  for (SupervisorAction& action : live->actions) logged->actions.push_back(std::move(action));
  return logged;
}

// Replaces the log's answer where the live client drives; else compares the two.
void MixedSource::mix(SimTime now, Answer& logged, Answer& live,
                      const std::vector<std::string>& robots) {
  const bool acts = now >= options_.live_from && options_.live_robots.contains(logged.robot);
  const bool both = logged.outcome == Outcome::decided && live.outcome == Outcome::decided;
  const bool same = both && same_decision(logged, live, robots);
  if (both && !report_.first_otherwise.contains(logged.robot)) {
    if (same)
      ++report_.alike[logged.robot];
    else
      report_.first_otherwise.emplace(logged.robot, MixedReport::Otherwise{now, logged, live});
  }
  if (acts) {
    if (!same && now.ns() < report_.departs_ns) report_.departs_ns = now.ns();
    logged = std::move(live);
    if (!report_.live_since) report_.live_since = now;
  } else if (both) {
    ++report_.compared_decisions;
    report_.different_decisions += !same;
  }
}

}  // namespace seam::scheduler
