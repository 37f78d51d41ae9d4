#include "app/logs/log_search.h"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/logs/log_signals.h"
#include "effects/formulas/formula.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr std::string_view kAge = ".age_s";
constexpr std::string_view kTime = "time_s";
// How finely ages and the time grow between the log's own samples.
constexpr SimDuration kTick = SimDuration::from_ns(10'000'000);

std::string trimmed(std::string_view text) {
  const size_t first = text.find_first_not_of(" \t\n");
  if (first == text.npos) return "";
  return std::string(text.substr(first, text.find_last_not_of(" \t\n") - first + 1));
}

// What an expression reads: a variable's value, or its age.
struct Read {
  size_t signal = 0;  // Its place among those asked for.
  bool age = false;
  bool time = false;
};

struct Reads {
  std::vector<Read> variables;
  std::vector<std::string> signals;

  explicit Reads(const std::vector<std::string>& names) {
    for (const std::string& name : names) {
      Read read{.age = name.ends_with(kAge), .time = name == kTime};
      const std::string signal = read.age ? name.substr(0, name.size() - kAge.size()) : name;
      const auto found = std::ranges::find(signals, signal);
      read.signal = static_cast<size_t>(found - signals.begin());
      if (found == signals.end()) signals.push_back(signal);
      variables.push_back(read);
    }
  }
  bool grow() const {
    return std::ranges::any_of(variables, [](const Read& read) { return read.age || read.time; });
  }
};

// Goes through a log's samples in the order of time and notes where the condition holds.
class Search {
 public:
  Search(const Reads& reads, const LogSignals& signals, const effects::Formula& formula,
         SimDuration at_least, size_t most)
      : reads_(reads),
        signals_(signals),
        formula_(formula),
        at_least_(at_least),
        most_(most),
        last_(signals.instant.size()),
        inputs_(reads.variables.size()) {
    for (size_t i = 0; i < last_.size(); ++i)
      if (signals.instant[i]) last_[i] = 0;
    since_.resize(last_.size());
  }

  std::vector<LogHit> run() {
    const std::vector<SignalSample>& samples = signals_.samples;
    SimTime tick;
    size_t next = 0;
    while (hits_.size() < most_) {
      const bool ticks = reads_.grow() && tick <= signals_.end;
      if (next == samples.size() && !ticks) break;
      const SimTime now = next == samples.size() ? tick
                          : ticks                ? std::min(tick, samples[next].time)
                                                 : samples[next].time;
      if (now > signals_.end) break;
      while (tick <= now) tick = tick + kTick;
      bool instants = false;
      for (; next < samples.size() && samples[next].time == now; ++next) {
        const size_t signal = samples[next].name;
        last_[signal] = samples[next].value;
        since_[signal] = now;
        instants |= signals_.instant[signal];
      }
      look(now);
      if (!instants) continue;
      for (size_t i = 0; i < last_.size(); ++i)
        if (signals_.instant[i]) last_[i] = 0;
      look(now);
    }
    if (begin_ && hits_.size() < most_) end_hit(signals_.end, true);
    return std::move(hits_);
  }

 private:
  bool holds(SimTime now) {
    for (size_t i = 0; i < inputs_.size(); ++i) {
      const Read& read = reads_.variables[i];
      if (read.time) {
        inputs_[i] = now.s();
      } else if (read.age) {
        inputs_[i] = (now - since_[read.signal]).s();
      } else if (const auto& value = last_[read.signal]) {
        inputs_[i] = *value;
      } else {
        return false;
      }
    }
    const double value = formula_(inputs_);
    return value != 0 && value == value;
  }
  void look(SimTime now) {
    const bool now_holds = holds(now);
    if (now_holds && !begin_) begin_ = now;
    if (!now_holds && begin_) end_hit(now, false);
  }
  void end_hit(SimTime end, bool until_end_of_log) {
    if (end - *begin_ >= at_least_) hits_.push_back({*begin_, end, until_end_of_log});
    begin_.reset();
  }

  const Reads& reads_;
  const LogSignals& signals_;
  const effects::Formula& formula_;
  const SimDuration at_least_;
  const size_t most_;
  std::vector<std::optional<double>> last_;
  std::vector<SimTime> since_;
  std::vector<double> inputs_;
  std::optional<SimTime> begin_;
  std::vector<LogHit> hits_;
};

// With the names that it reads.
std::pair<effects::Formula, std::vector<std::string>> formula_of(const std::string& expression) {
  using effects::Formula;
  using effects::Names;
  try {
    auto names = Formula::names_in(expression, Names::dotted);
    return {Formula(expression, names, Names::dotted), names};
  } catch (const InputError& error) {
    throw UsageError(fmt::format(
        "condition: {}; expected an expression such as 'red1.ball_area_px == 0 && time_s > 5'",
        error.what()));
  }
}

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
  const auto [formula, names] = formula_of(condition.expression);
  const Reads reads(names);
  const LogSignals signals = read_signals(log, reads.signals);
  return {Search(reads, signals, formula, condition.at_least, most).run(),
          robot_in(reads.signals, log.header().robots)};
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
