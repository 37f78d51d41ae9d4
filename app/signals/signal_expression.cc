#include "app/signals/signal_expression.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/signals/record_signals.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr std::string_view kAge = ".age_s";
constexpr std::string_view kTime = "time_s";

effects::Formula formula_of(const std::string& text, const std::string& what) {
  using effects::Formula;
  using effects::Names;
  try {
    return {text, Formula::names_in(text, Names::dotted), Names::dotted};
  } catch (const InputError& error) {
    throw UsageError(
        fmt::format("{}: {}; expected an expression such as 'red1.ball_area_px == 0 && time_s > 5'",
                    what, error.what()));
  }
}

}  // namespace

SignalValues::SignalValues(const std::vector<std::string>& names)
    : last_(names.size()), since_(names.size()) {
  for (const std::string& name : names) is_event_.push_back(app::is_event(name));
  end_instant();
}

void SignalValues::set(size_t name, SimTime time, double value) {
  last_[name] = value;
  since_[name] = time;
}

void SignalValues::end_instant() {
  for (size_t i = 0; i < last_.size(); ++i)
    if (is_event_[i]) last_[i] = 0;
}

SignalExpression::SignalExpression(const std::string& text, const std::string& what,
                                   std::vector<std::string>& signals)
    : formula_(formula_of(text, what)) {
  for (const std::string& name : effects::Formula::names_in(text, effects::Names::dotted)) {
    Read read{.age = name.ends_with(kAge), .time = name == kTime};
    const std::string signal = read.age ? name.substr(0, name.size() - kAge.size()) : name;
    const auto found = std::ranges::find(signals, signal);
    read.signal = static_cast<size_t>(found - signals.begin());
    if (found == signals.end()) signals.push_back(signal);
    reads_.push_back(read);
  }
}

bool SignalExpression::grows() const {
  return std::ranges::any_of(reads_, [](const Read& read) { return read.age || read.time; });
}

std::optional<double> SignalExpression::value(SimTime now, const SignalValues& values) const {
  std::vector<double> inputs;
  for (const Read& read : reads_) {
    if (read.time) {
      inputs.push_back(now.s());
    } else if (read.age) {
      inputs.push_back((now - values.since(read.signal)).s());
    } else if (const auto& value = values.last(read.signal)) {
      inputs.push_back(*value);
    } else {
      return std::nullopt;
    }
  }
  return formula_(inputs);
}

}  // namespace seam::app
