// How often something happened.
#pragma once

namespace seam::measurement {

// A count of successes and the interval that holds the true rate with 95 % (Wilson 1927).
struct Rate {
  int hits = 0;
  int trials = 0;
  double value() const { return trials > 0 ? static_cast<double>(hits) / trials : 0; }
  double low() const;
  double high() const;
};

}  // namespace seam::measurement
