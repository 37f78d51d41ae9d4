// Statistics of values that runs kept, and how far those of as many other runs would lie off.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace seam::measurement {

// mean, spread (sample standard deviation), rms, min, max, largest (the largest amount), median,
// rate (the share of runs whose value is not 0), quantile_P (P from 0 to 1, linear between values).
class RunStatistic {
 public:
  // Throws InputError with the names that there are.
  static RunStatistic named(const std::string& name);

  const std::string& name() const { return name_; }
  // Of at least one value; the order of values does not matter.
  double of(std::vector<double> values) const;
  bool is_rate() const { return name_ == "rate"; }

 private:
  std::string name_;
  double quantile_ = 0;
};

// One statistic of one column of a table of runs.
struct ColumnStatistic {
  size_t column = 0;
  RunStatistic statistic;
};

struct StatisticsOfRuns {
  std::vector<double> value;   // NaN where fewer than half of the runs gave a number.
  Eigen::MatrixXd covariance;  // Of these values from the finite number of runs.
};

// By statistic. `alike` runs that follow each other have the same settings but for their seeds:
// each such stratum is drawn again with replacement, all columns of a run together (bootstrap after
// Efron 1979), so that statistics of the same runs vary together, and settings that measured and
// simulated runs share count for no scatter; the variance that few runs of a stratum hide is made
// up for by alike / (alike - 1). With one run of a kind all runs are one stratum, which is
// cautious. By counters, so that equal tables give equal bits. A rate has at least the variance
// that a uniform prior leaves (Laplace): a rate of 0 in 12 runs is not known to be 0.
StatisticsOfRuns statistics_of(const std::vector<std::vector<double>>& runs, size_t alike,
                               const std::vector<ColumnStatistic>& wanted);

// The covariance of statistics over tables with `drawn` runs of each setting, from a table that has
// `alike` of each: more runs than one table has tell its errors better.
Eigen::MatrixXd covariance_of(const std::vector<std::vector<double>>& runs, size_t alike,
                              size_t drawn, const std::vector<ColumnStatistic>& wanted);

}  // namespace seam::measurement
