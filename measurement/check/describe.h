// What a measurement set holds, for `seam check`: columns and units, groups, noise, what is odd,
// and what can be tested with it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "effects/model.h"
#include "measurement/imaging/instruments.h"
#include "measurement/sets/set.h"

namespace seam::measurement {

// "rad/s" of a column's name that ends in _radps; empty where it has no unit.
std::string unit_of(const std::string& column);

struct SetDescription {
  std::string text;  // Lines for people.
  std::vector<std::string> errors;
  std::vector<std::string> warnings;
};

// With a model also: how many points it places behind the camera, and which effects the set can
// test beside it. Throws InputError where the set cannot be read at all.
SetDescription describe_set(const MeasurementSet& set, const std::optional<effects::Model>& model,
                            const Instruments& instruments = {});

}  // namespace seam::measurement
