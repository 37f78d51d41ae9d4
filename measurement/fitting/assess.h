// One model held against one set: its refitted parameters on training groups and its score on
// held-out groups.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "measurement/problem/problem.h"

namespace seam::measurement {

struct Assessment {
  Model model;  // Unknowns at their estimates.
  std::vector<Unknown> unknowns;
  Fit fit;
  Score held;           // On held-out groups, pooled over folds.
  double total_ll = 0;  // Log-likelihood of training and held-out groups together.
  double error = 0;     // sqrt(chi2 / (N - nuisances)) on held-out groups.
  bool valid = false;

  double held_ll() const { return held.log_likelihood; }
};

// Parameters that comparisons refit: `free` ones and those fitted earlier (with a sigma).
std::vector<Unknown> refitted_unknowns(const Model& model);

Assessment assess(const Problem& problem, const Model& model, const std::vector<Unknown>& unknowns);

// Of a Memo: all that what is worked out beside an assessment depends on.
std::vector<double> key_of(const Problem& problem, const Assessment& assessment);
void add_to_key(const std::string& text, std::vector<double>& key);

// The same, fitted to these groups of `shown` (this problem, or its beginnings) instead of to all
// that may be.
Assessment assess_fitted_to(const Problem& problem, const Problem& shown, const Groups& groups,
                            const Model& model, const std::vector<Unknown>& unknowns);

// Throws InputError where observations are too few for their unknowns, so that an error means
// nothing: poses and starts of the held-out groups, or these and the parameters of all groups.
void check_enough(const Problem& problem, const Assessment& assessment);

// The same without any fit.
Assessment assess_fixed(const Problem& problem, const Model& model);

// Writes the fit's sigmas into the model's parameters. `free` marks stay.
void write_sigmas(Model& model, const std::vector<Unknown>& unknowns, const Fit& fit);

// How many scalars take part.
size_t count_used(const Problem& problem);

}  // namespace seam::measurement
