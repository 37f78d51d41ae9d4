// An expression over signals (record_signals.h) in the language of models' formulas:
//
//   truth.red1.ball_distance_m < 0.3 && red1.ball_area_px.age_s > 1
//
// NAME.age_s is the time since the last value of NAME, since the start before the first. Without a
// value for all else that it reads it has none itself.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "effects/formulas/formula.h"
#include "sim_core/base/time.h"

namespace seam::app {

// The newest values of signals, by their places in a list of names.
class SignalValues {
 public:
  // Events are 0 until they come.
  explicit SignalValues(const std::vector<std::string>& names);

  void set(size_t name, SimTime time, double value);
  // Events are 0 again.
  void end_instant();
  const std::optional<double>& last(size_t name) const { return last_[name]; }
  SimTime since(size_t name) const { return since_[name]; }
  bool is_event(size_t name) const { return is_event_[name]; }

 private:
  std::vector<std::optional<double>> last_;
  std::vector<SimTime> since_;
  std::vector<bool> is_event_;
};

class SignalExpression {
 public:
  // Adds the signals that it reads to `signals`, where they are not there. Throws UsageError for a
  // syntax error; `what` is the expression's name in it.
  SignalExpression(const std::string& text, const std::string& what,
                   std::vector<std::string>& signals);

  std::optional<double> value(SimTime now, const SignalValues& values) const;
  // Whether it reads the time or an age, which change without a new value.
  bool grows() const;

 private:
  // What a variable of the formula reads.
  struct Read {
    size_t signal = 0;
    bool age = false;
    bool time = false;
  };

  std::vector<Read> reads_;
  effects::Formula formula_;
};

}  // namespace seam::app
