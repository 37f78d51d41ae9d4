// Whether a cause without a name explains a set better than the effects that were found: a smooth
// function of what residuals may depend on competes with them on the scale of log-evidence.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "measurement/fitting/assess.h"

namespace seam::measurement {

// A model with some of the effects that a search found, and its log-evidence: log-likelihood of all
// groups less the price of its parameters.
struct Explanation {
  const Assessment* assessment = nullptr;
  double log_evidence = 0;
};

struct UnnamedCause {
  size_t beside = 0;  // The explanation that it stands beside: effects added after it imitate it.
  std::vector<std::string> depends_on;  // Covariates.
  double lead = 0;         // Log-evidence ahead of the last explanation, all of whose causes have names.
  double noise_units = 0;  // Root mean square of what it changes.
  double takes = 0;        // Of the squared residuals beyond the noise: a share.
  double error_before = 0, error_after = 0;  // Of all observations, without and with it.
};

// The best of all fields beside all explanations, which are ordered by growth, where it is ahead of
// the last one by more than a tie and held-out groups agree. `width` is that of a tie, `material`
// the least change in noise units that counts.
std::optional<UnnamedCause> unnamed_cause(const Problem& problem,
                                          const std::vector<Explanation>& explanations,
                                          double width, double material);

}  // namespace seam::measurement
