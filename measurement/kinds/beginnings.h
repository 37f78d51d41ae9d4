// Few long groups: a second reading of a set, with the first rows of each group alone.
#pragma once

#include "measurement/kinds/kinds.h"

namespace seam::measurement {

// Gives the problem that was read from this set its beginnings, where rows are many and groups so
// long that some of them would be many rows, too.
void add_beginnings(const Kind& kind, MeasurementSet set, const Instruments& instruments,
                    Problem& problem);

}  // namespace seam::measurement
