// Where rows are many, a fit goes most of its way on a few of the groups, or on the beginnings of
// long ones: they show the valley as well as all rows do, and what these say beyond is a last step
// or two.
#pragma once

#include <optional>

#include "measurement/problem/problem.h"

namespace seam::measurement {

// Groups of all rows, or of the beginnings of the groups.
struct FewRows {
  const Problem* problem = nullptr;
  Groups groups;
};

// How many residuals of them take part.
double residuals_of(const FewRows& few);

// Some of these groups, taken as if by lot, of about 4,000 residuals, or their beginnings; none
// where that would save little or few rows would not stand for all.
std::optional<FewRows> few_of(const Problem& problem, const Model& model, const Groups& groups);

// Some rows again, with so many residuals of each channel that what moves predictions by
// `material` noise units, root mean square, gains 20 units of likelihood in a channel: what they
// show nothing of is not material. None where that would save little, and where nothing is small.
std::optional<FewRows> enough_to_tell(const Problem& problem, const Model& model,
                                      const Groups& groups, double material);

// Of its scale: what a fit to a few groups leaves below this of a spread says nothing of all
// groups.
inline constexpr double kNoSpread = 1e-3;

}  // namespace seam::measurement
