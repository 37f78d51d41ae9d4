// Rows that no model of a camera could explain, found without one: corners under another's name, a
// cell that slipped, a view whose labels run the wrong way. They are left out before any fit, which
// they would steer.
#pragma once

#include "measurement/kinds/points/data/points_data.h"

namespace seam::measurement {

// By scalar; empty: none. Sentences about them go to the notes of the facts.
std::vector<char> gross_errors(const PointsData& data, Facts& facts);

}  // namespace seam::measurement
