// Residuals as plots need them: one list a channel, with the place of each in every covariate.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "measurement/problem/problem.h"

namespace seam::measurement {

struct ResidualView {
  struct Channel {
    std::string name;
    std::vector<double> residual;  // Observed - predicted, in the channel's unit.
    std::vector<double> sigma;     // What the model states for it.
    // Where an observation is a mean of values: the standard deviation of a single value, with all
    // that it shares with others.
    std::vector<double> value_sigma;
    // What was observed, where that is no column of the set's table; else empty.
    std::vector<double> observed;
    std::vector<int> row;  // Into the covariates.
  };
  std::vector<Channel> channels;  // Those that combine two come last.
  std::vector<std::pair<std::string, std::vector<double>>> covariates;

  const Channel* channel(const std::string& name) const;
  // By row; products `a*b` are multiplied out. Empty where a name is unknown.
  std::vector<double> covariate(const std::string& name) const;
};

// Channel by channel from an evaluation of residual vectors.
ResidualView view_of(const Facts& facts, const Evaluation& evaluation);

}  // namespace seam::measurement
