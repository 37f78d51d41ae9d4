// A statistic of results against one or two parameters, each point with its 95 % interval.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/sweep/results.h"

namespace seam::app {

// Of the values of one point:
//   mean      Student's t interval
//   deviation sample standard deviation (n - 1), chi-squared interval
//   median    interval between order statistics, by the binomial distribution
//   rate      share of values other than 0, Wilson's interval
enum class CurveStatistic : uint8_t { mean, deviation, median, rate };
inline constexpr const char* kCurveStatistics[] = {"mean", "deviation", "median", "rate"};

struct Estimate {
  double value = 0;
  std::optional<double> low, high;  // Nothing where there are too few values.
};
Estimate estimate_of(CurveStatistic statistic, std::vector<double> values);

struct CurvePoint {
  std::string x;   // As tables show it.
  std::string by;  // Of the second parameter; empty without one.
  size_t count = 0;
  Estimate estimate;
};

// Points in the order in which the plan first comes to them. `over`, `by` and `value` are columns
// of the table; throws UsageError for another name, InputError where a value is no number. Blank
// values and failed runs are left out.
std::vector<CurvePoint> curve_of(const ResultsFile& results, CurveStatistic statistic,
                                 const std::string& value, const std::string& over,
                                 const std::string& by);

}  // namespace seam::app
