// Where a carrier of curves acts, by the values of a variable there: in which waves and bumps are
// looked for without a fit to each.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "measurement/problem/problem.h"
#include "measurement/suggest/vocabulary.h"
#include "measurement/suggest/wave_search.h"

namespace seam::measurement {

// Observations of a variable where a carrier acts, and how much it does.
struct Along {
  Term carrier;
  std::string variable;
  std::vector<size_t> scalars;
  std::vector<double> at, weight;
  Arrives arrives;
};

// A variable's values by row; empty where the set has it by no name.
std::vector<double> values_of(const Vocabulary& vocabulary, const Facts& facts,
                              const std::string& variable);

// Of a carrier that is 1 in one channel, with the nuisances at rest: what they take of a curve, the
// residuals have lost to them already. Nothing for any other.
std::optional<Along> along_channel(const Vocabulary& vocabulary, const Problem& problem,
                                   const Evaluation& here, const Term& carrier,
                                   const std::string& variable);

// The same of one that acts at a place of the problem's, on a target or on a motor.
std::optional<Along> along_place(const Vocabulary& vocabulary,
                                 const std::vector<FieldPlace>& places, const Facts& facts,
                                 const Evaluation& here, const Term& carrier,
                                 const std::string& variable);

// From what a carrier changes by itself and with a variable, whose value at each residual is what
// it would change beside what a constant would: that is exact where the output stands for the
// residual itself, and near enough to find a frequency or a place where it acts for long on what
// comes later, and no nuisance follows.
Along along_changes(const Evaluation& here, const std::vector<double>& alone,
                    const std::vector<double>& by_variable);

}  // namespace seam::measurement
