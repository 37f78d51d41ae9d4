// An effect of one's own, proposed from the residuals of a model.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "measurement/judge/judge.h"

namespace seam::measurement {

struct Suggestion {
  std::string effect;              // Its name in `yaml`.
  std::string formula;             // "u: 0.0006 * (u - cx) * t": what it adds, with its values.
  std::vector<std::string> terms;  // "u: (u - cx) * t", without the coefficient.
  // The numbers of the formula as parameters of `yaml`, each with its standard error.
  struct Number {
    std::string parameter;
    double value = 0, sigma = 0;
  };
  std::vector<Number> numbers;
  std::vector<std::string> beside;  // Effects found by the search that the formula was fitted with.
  double error_before = 0;          // On held-out groups: of the model without the formula,
  double error = 0;                 // and with it.
  double log_evidence = 0;          // On the scale of a named explanation's merit.
  std::string yaml;                 // A file that `seam add` and `diagnose --candidates` take.
};

// Sparse regression of what the model leaves on products, waves, decays, steps, bends and bumps of
// the variables of a stage (geometry, target, joint, light, detector, locomotion). Each column of
// the regression is the change of the prediction by that term in a formula, so nuisances and the
// path from a joint to the image are in it; each term taken must help on held-out groups. Nothing
// where none does, or for kinds without formulas.
std::optional<Suggestion> suggest(const Problem& problem, const Grown& beside);

}  // namespace seam::measurement
