// The strongest wave in scattered observations of a variable.
#pragma once

#include <functional>
#include <optional>
#include <vector>

namespace seam::measurement {

// Turns what acts at each observation into what it changes there: a push changes all that comes
// later. Empty: itself.
using Arrives = std::function<void(std::vector<double>&)>;

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
                                        const std::vector<double>& rest,
                                        const Arrives& arrives = {});

}  // namespace seam::measurement
