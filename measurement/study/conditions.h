// What recordings are like and made sets are not, done to the sets of a study: few groups, uneven
// time steps, a smooth misfit, errors that wander, gross errors in bursts.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace seam::measurement {

struct Conditions {
  int groups = 0;       // As many are kept of the protocol; 0: all.
  bool uneven = false;  // Time steps vary by up to a third.
  double misfit = 0;    // Root mean square of a smooth change of all that is measured, and
  double wander = 0;    // of an error that wanders along each series: both in noise units.
  bool bursts = false;  // One row in a hundred is off by 30 noise units, three in a row.

  bool any() const { return groups > 0 || uneven || misfit > 0 || wander > 0 || bursts; }
  bool of_tables() const { return uneven || misfit > 0 || wander > 0 || bursts; }
  std::string text() const;  // For people; empty where there are none.
};

// Before sets are made of a protocol: groups and time steps.
void arrange_protocol(const Conditions& conditions, const std::filesystem::path& folder);
// Afterwards: what is added to a set that was made.
void disturb_set(const Conditions& conditions, uint64_t seed, const std::filesystem::path& folder);

}  // namespace seam::measurement
