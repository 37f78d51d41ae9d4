#include "app/session/logged_values.h"

#include <algorithm>
#include <cmath>

namespace seam::app {

void LoggedSummary::add(double value) {
  if (count == 0) first = min = max = value;
  ++count;
  last = value;
  min = std::min(min, value);
  max = std::max(max, value);
  sum += value;
  sum_of_squares += value * value;
  const double off = value - running_mean;
  running_mean += off / static_cast<double>(count);
  sum_about_mean += off * (value - running_mean);
}

double LoggedSummary::get(Statistic statistic) const {
  const auto n = static_cast<double>(count);
  switch (statistic) {
    case Statistic::last:
      return last;
    case Statistic::first:
      return first;
    case Statistic::mean:
      return sum / n;
    case Statistic::min:
      return min;
    case Statistic::max:
      return max;
    case Statistic::rms:
      return std::sqrt(sum_of_squares / n);
    case Statistic::std:
      return count < 2 ? 0 : std::sqrt(sum_about_mean / (n - 1));
    case Statistic::count:
      return n;
  }
  return 0;
}

void LoggedValues::on_start(const scheduler::RunHeader& header) {
  robots_ = header.robots;
}

void LoggedValues::on_turn(SimTime, const scheduler::Turn& turn) {
  for (const scheduler::Answer& answer : turn.answers) {
    for (const scheduler::DebugItem& item : answer.decision.debug) {
      if (item.kind != scheduler::DebugItem::Kind::value) continue;
      const std::pair key(robots_.at(static_cast<size_t>(answer.robot)), item.name);
      auto found = summaries_.find(key);
      if (found == summaries_.end()) {
        if (summaries_.size() == kMostNames) continue;
        found = summaries_.emplace(key, LoggedSummary{}).first;
      }
      found->second.add(item.value);
    }
  }
}

}  // namespace seam::app
