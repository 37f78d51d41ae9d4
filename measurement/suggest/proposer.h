// A formula of one stage, grown from what a model leaves: sparse regression on products and
// curves of the stage's variables, one term after another.
#pragma once

#include <optional>
#include <vector>

#include "measurement/fitting/assess.h"
#include "measurement/suggest/vocabulary.h"

namespace seam::measurement {

// A formula beside a model, and how the model does with it.
struct Formula {
  const Vocabulary* vocabulary = nullptr;
  std::vector<Term> terms;
  Assessment assessment;  // Its coefficients are the last unknowns.
  double merit = 0;  // Total log-likelihood less the price of its numbers in units of the misfit.
  // The same less the price of its numbers and of the terms that were looked at for each: on the
  // scale of a named explanation's merit.
  double log_evidence = 0;
};

// Each term is looked for on about 4,000 residuals, where there are more, and taken if it helps on
// held-out groups; nothing where the first does not. Grows no further where two terms
// lead nowhere.
std::optional<Formula> formula_of(const Problem& problem, const Assessment& base,
                                  const Vocabulary& vocabulary);

}  // namespace seam::measurement
