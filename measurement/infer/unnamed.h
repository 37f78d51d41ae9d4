// Whether causes without names explain a set better than the effects that were found: smooth
// functions of what residuals may depend on compete with them on the scale of log-evidence.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "measurement/fitting/assess.h"
#include "measurement/problem/memo.h"

namespace seam::measurement {

// A model with some of the effects that a search found, and its log-evidence: log-likelihood of all
// groups less the price of its parameters.
struct Explanation {
  const Assessment* assessment = nullptr;
  double log_evidence = 0;
  // What the last explanation has beside it is noise of unknown cause, which names nothing.
  bool noise_follows = false;
};

struct UnnamedCause {
  // The explanation that it stands beside: effects added after that one imitate it.
  size_t beside = 0;
  // What each of its smooth functions depends on, the first takes the most.
  std::vector<std::vector<std::string>> depends_on;
  // Log-evidence ahead of the last explanation, all of whose causes have names.
  double lead = 0;
  double noise_units = 0;                    // Root mean square of what it changes.
  double takes = 0;                          // Of the squared residuals beyond the noise: a share.
  double error_before = 0, error_after = 0;  // Of all observations, without and with it.
};

// A smooth function that was tried beside an explanation.
struct TriedFunction {
  std::vector<std::string> covariates;
  bool is_testable = true;  // Nuisances of many groups may follow whatever it does.
  double log_evidence = 0;  // That it gains, less the price of the look.
};

// The best cause beside one explanation; its lead is what it gains.
struct CauseBeside {
  double step_gain = 0;  // Of log-likelihood, where its own parameters are fitted to all groups.
  std::optional<UnnamedCause> cause;
  std::vector<TriedFunction> tried;
};
// A search asks about most explanations several times.
using KnownCauses = Memo<CauseBeside>;

// The best cause beside one of the explanations, each of which grew from the one before it, where
// it is ahead of the last and groups that are held out agree. `material` is the least change in
// noise units that counts.
std::optional<UnnamedCause> unnamed_cause(const Problem& problem,
                                          const std::vector<Explanation>& explanations,
                                          double material, const KnownCauses& known);

// What was tried beside an explanation.
std::vector<TriedFunction> tried_beside(const Problem& problem, const Assessment& explanation,
                                        const KnownCauses& known);

// For each set of effects of an explanation: of what they take of the residuals together, in
// log-likelihood, the share that smooth functions cannot take in their place; 1 where that cannot
// be said. By one linear step of the effects that stay.
std::vector<double> own_shares(const Problem& problem, const Assessment& explanation,
                               const std::vector<std::vector<std::string>>& sets);

}  // namespace seam::measurement
