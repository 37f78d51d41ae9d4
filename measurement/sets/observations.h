// What can be said of a set's observations before any model is held against them: rows that stand
// twice, places outside the image, values that no measurement has.
#pragma once

#include <string>
#include <vector>

#include "measurement/sets/set.h"

namespace seam::measurement {

// Where the observations of a kind stand; each kind states its own (kinds.h).
struct ObservationTable {
  std::string file;  // Its name under `files:`.
  // The columns that tell one observation from another; those that a table lacks count as equal.
  // Empty: equal rows are different observations.
  std::vector<std::string> keys;
  std::vector<std::string> measured;  // The columns that were measured.
  // The first two measured columns are a place in the camera's image, u and v in pixels.
  bool in_image = false;
};

// What is wrong with the data and what is only odd, each as "file:line: column c: ...".
struct Concerns {
  std::vector<std::string> errors;
  std::vector<std::string> warnings;
  size_t rows_twice = 0;     // Rows equal to an earlier one in keys and measured values.
  size_t measured_anew = 0;  // Rows with the keys of an earlier one and other values.
  size_t outside_image = 0;
};

// Whether nothing is measured yet: the table has none of the measured columns.
bool is_protocol(const MeasurementSet& set, const ObservationTable& observations);

Concerns concerns_of(const MeasurementSet& set, const ObservationTable& observations);

}  // namespace seam::measurement
