// The strongest wave in scattered observations of a variable.
#pragma once

#include <optional>
#include <vector>

namespace seam::measurement {

struct FoundWave {
  double frequency = 0;  // Radians a unit of the variable.
  double phase = 0;
  double amplitude = 0;
  double gain = 0;  // Of log-likelihood, residuals in units of their noise.
};

// weight * amplitude * sin(frequency * at + phase) takes the most of `rest`, an observation each;
// nothing where they are few or the variable stays.
std::optional<FoundWave> strongest_wave(const std::vector<double>& at,
                                        const std::vector<double>& weight,
                                        const std::vector<double>& rest);

}  // namespace seam::measurement
