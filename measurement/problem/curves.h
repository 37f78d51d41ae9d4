// Curves by which a field describes its sensors (an Allan deviation), for kinds that have some.
#pragma once

#include <string>
#include <vector>

#include "effects/model.h"

namespace seam::measurement {

struct CurvePoint {
  double at = 0, value = 0;
  double sigma = 0;     // Standard error of the measured value.
  double expected = 0;  // By the model; NaN where it says nothing.
};
// On logarithmic axes.
struct Curve {
  std::string title;                   // "Allan deviation of wx"
  std::string of;                      // The channel.
  std::string at_name, at_unit, unit;  // "averaged over", "s"; of the values.
  std::vector<CurvePoint> points;
};

class HasCurves {
 public:
  virtual ~HasCurves() = default;
  // What was measured, and what this model gives instead.
  virtual std::vector<Curve> curves(const effects::Model& model) const = 0;
};

}  // namespace seam::measurement
