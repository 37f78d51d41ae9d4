// What robots' behaviours log as values (`log_value`), summed up by robot and name.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "scheduler/loop/observer.h"

namespace seam::app {

// `std`: the standard deviation of the values about their mean, 0 of a single one.
enum class Statistic : uint8_t { last, first, mean, min, max, rms, std, count };
inline constexpr std::array<const char*, 8> kStatisticNames = {"last", "first", "mean", "min",
                                                               "max",  "rms",   "std",  "count"};

struct LoggedSummary {
  uint64_t count = 0;
  double first = 0, last = 0;
  double min = 0, max = 0;
  double sum = 0, sum_of_squares = 0;  // In the order of simulated time.
  // Welford's running mean and sum of squares about it: the difference of the sums above would lose
  // digits where values are alike.
  double running_mean = 0, sum_about_mean = 0;

  void add(double value);
  double get(Statistic statistic) const;
};

// By robot's id and name.
using LoggedSummaries = std::map<std::pair<std::string, std::string>, LoggedSummary>;

class LoggedValues final : public scheduler::SimulationObserver {
 public:
  // Names beyond so many are left out: a client may make up new ones for ever.
  static constexpr size_t kMostNames = 10000;

  void on_start(const scheduler::RunHeader& header) override;
  void on_turn(SimTime time, const scheduler::Turn& turn) override;

  const LoggedSummaries& summaries() const { return summaries_; }

 private:
  std::vector<std::string> robots_;
  LoggedSummaries summaries_;
};

}  // namespace seam::app
