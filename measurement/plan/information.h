// What a set to be measured says of parameters: the normal equations of the kind's own predictions,
// group by group.
#pragma once

#include <vector>

#include "measurement/plan/detection.h"
#include "measurement/problem/problem.h"

namespace seam::measurement {

// Columns of whitened residuals by a model's parameters, in the coordinates in which they are
// fitted (fitting/parameter_space.h).
struct Columns {
  std::vector<Unknown> unknowns;
  std::vector<std::vector<double>> by;  // By unknown and scalar; empty where there are none.
  std::vector<double> slope;            // d value / d coordinate, by unknown.
};
Columns columns_at(const Problem& problem, const Model& model, const std::vector<Unknown>& unknowns,
                   const Evaluation& here);

// By what whitened residuals of the model `without` move where `with` is true.
std::vector<double> shift_of(const Evaluation& without, const Evaluation& with);

// Whether errors are normal and independent of each other, so that each residual depends on its
// own spread alone.
bool errors_are_independent(const Problem& problem, const Evaluation& here);

// The same two of effects of spread, where errors are independent: by log sigma times the square
// root of 2, of which a residual's square has as much information as a residual has of its mean.
Columns spread_columns_at(const Problem& problem, const Model& model,
                          const std::vector<Unknown>& unknowns);
std::vector<double> spread_shift_of(const Evaluation& without, const Evaluation& with);

// The columns and a shift, part by part as the search fits and holds out. `repeats` of the set
// count as so many sets like it. `base`: as many columns are of what is refitted anyway.
EffectLook look_of(const Problem& problem, const Evaluation& here, const Columns& columns,
                   const std::vector<double>& shift, size_t base, double repeats = 1);

}  // namespace seam::measurement
