// Where rows are many, a fit goes most of its way on a few of the groups: they show the valley as
// well as all do, and what all groups say beyond is a last step or two.
#pragma once

#include <optional>

#include "measurement/problem/problem.h"

namespace seam::measurement {

// Some of these groups, taken as if by lot, of about kFewResiduals residuals; none where that would
// save little or a few groups would not stand for all.
std::optional<Groups> few_of(const Problem& problem, const Model& model, const Groups& groups);

// Some of them again, with so many residuals of each channel that what moves predictions by
// `material` noise units, root mean square, gains 20 units of likelihood in a channel: what they
// show nothing of is not material. None where that would save little, and where nothing is small.
std::optional<Groups> enough_to_tell(const Problem& problem, const Model& model,
                                     const Groups& groups, double material);

// Of its scale: what a fit to a few groups leaves below this of a spread says nothing of all
// groups.
inline constexpr double kNoSpread = 1e-3;

}  // namespace seam::measurement
