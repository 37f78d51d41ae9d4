#include "app/logs/log_search.h"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/logs/log_signals.h"
#include "app/signals/signal_expression.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

// How finely ages and the time grow between the log's own samples.
constexpr SimDuration kTick = SimDuration::from_ns(10'000'000);

std::string trimmed(std::string_view text) {
  const size_t first = text.find_first_not_of(" \t\n");
  if (first == text.npos) return "";
  return std::string(text.substr(first, text.find_last_not_of(" \t\n") - first + 1));
}

// Goes through a log's samples in the order of time and notes where the condition holds.
class Search {
 public:
  Search(const std::vector<std::string>& names, const LogSignals& signals,
         const SignalExpression& expression, SimDuration at_least, size_t most)
      : signals_(signals),
        expression_(expression),
        at_least_(at_least),
        most_(most),
        values_(names) {}

  std::vector<LogHit> run() {
    const std::vector<SignalSample>& samples = signals_.samples;
    SimTime tick;
    size_t next = 0;
    while (hits_.size() < most_) {
      const bool ticks = expression_.grows() && tick <= signals_.end;
      if (next == samples.size() && !ticks) break;
      const SimTime now = next == samples.size() ? tick
                          : ticks                ? std::min(tick, samples[next].time)
                                                 : samples[next].time;
      if (now > signals_.end) break;
      while (tick <= now) tick = tick + kTick;
      bool instants = false;
      for (; next < samples.size() && samples[next].time == now; ++next) {
        values_.set(samples[next].name, now, samples[next].value);
        instants |= values_.is_event(samples[next].name);
      }
      look(now);
      if (!instants) continue;
      values_.end_instant();
      look(now);
    }
    if (begin_ && hits_.size() < most_) end_hit(signals_.end, true);
    return std::move(hits_);
  }

 private:
  void look(SimTime now) {
    // A condition is false until all that it reads has had a value, and where it is no number.
    const double value = expression_.value(now, values_).value_or(0);
    const bool now_holds = value != 0 && value == value;
    if (now_holds && !begin_) begin_ = now;
    if (!now_holds && begin_) end_hit(now, false);
  }
  void end_hit(SimTime end, bool until_end_of_log) {
    if (end - *begin_ >= at_least_) hits_.push_back({*begin_, end, until_end_of_log});
    begin_.reset();
  }

  const LogSignals& signals_;
  const SignalExpression& expression_;
  const SimDuration at_least_;
  const size_t most_;
  SignalValues values_;
  std::optional<SimTime> begin_;
  std::vector<LogHit> hits_;
};

// The first robot that these names are of.
std::string robot_in(const std::vector<std::string>& names,
                     const std::vector<std::string>& robots) {
  for (const std::string& name : names) {
    for (const std::string& robot : robots) {
      std::string id = robot;
      std::ranges::replace(id, '-', '_');
      if (name.starts_with(id + ".") || name.starts_with("truth." + id + ".")) return robot;
    }
  }
  return "";
}

}  // namespace

LogCondition condition_from(const std::string& text) {
  constexpr std::string_view kFor = " for ";
  const size_t at = text.rfind(kFor);
  if (at == text.npos) return {trimmed(text), SimDuration()};
  const std::string length = trimmed(std::string_view(text).substr(at + kFor.size()));
  double value = 0;
  const auto [end, error] = std::from_chars(length.data(), length.data() + length.size(), value);
  const std::string unit = trimmed(std::string_view(end, length.data() + length.size()));
  const double scale = unit == "s" ? 1 : unit == "ms" ? 1e-3 : 0;
  if (error != std::errc() || scale == 0 || !(value >= 0 && value * scale < 9e9)) {
    throw UsageError(fmt::format(
        "condition: found 'for {}', expected how long it must hold, as in 'for 0.5 s' or "
        "'for 20 ms'",
        length));
  }
  return {trimmed(std::string_view(text).substr(0, at)),
          SimTime::from_s(value * scale) - SimTime()};
}

LogHits find_in(const scheduler::Log& log, const std::string& text, size_t most) {
  const LogCondition condition = condition_from(text);
  std::vector<std::string> names;
  const SignalExpression expression(condition.expression, "condition", names);
  const LogSignals signals = read_signals(log, names);
  return {Search(names, signals, expression, condition.at_least, most).run(),
          robot_in(names, log.header().robots)};
}

std::string view_query(SimTime time, const std::string& robot) {
  return fmt::format("?t={:.3f}", time.s()) + (robot.empty() ? "" : "&robot=" + robot);
}

std::string to_json(const LogHits& found, const std::string& condition, int indent) {
  nlohmann::ordered_json json = {{"format", "seam-find/1"},
                                 {"when", condition},
                                 {"count", found.hits.size()},
                                 {"hits", nlohmann::ordered_json::array()}};
  for (const LogHit& hit : found.hits) {
    // A quotient, whose decimal digits are those of the nanoseconds.
    json["hits"].push_back({{"begin_s", static_cast<double>(hit.begin.ns()) / 1e9},
                            {"end_s", static_cast<double>(hit.end.ns()) / 1e9},
                            {"begin_ns", hit.begin.ns()},
                            {"end_ns", hit.end.ns()},
                            {"until_end_of_log", hit.until_end_of_log},
                            {"view", view_query(hit.begin, found.robot)}});
  }
  return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace seam::app
