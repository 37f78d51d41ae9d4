// The noise of one axis over frequency, by its lines: coefficients of the cosine transform of each
// stretch. Lines of a band are summed up, each over a smooth spectrum that fits them, so that a
// band may be wide where the spectrum is steep. Near peaks bands are narrow.
#pragma once

#include <array>
#include <vector>

#include "measurement/kinds/imu/imu_data.h"
#include "measurement/kinds/imu/spectra/spectral_peaks.h"

namespace seam::measurement {

// Of a band at least: the cube root of their power is nearly normal.
inline constexpr size_t kLeastLines = 4;

// The four powers of frequency of IEEE 952: rounding, white, flicker, walk, a size for each; and
// Lorentzians where peaks are, by several widths each.
struct SmoothSpectrum {
  std::vector<double> size;
  std::vector<SpectralPeak> peaks;
  double at(double omega) const;
};

// Lines k of a stretch of n: their power over the smooth spectrum, as a mean.
struct NoiseBand {
  size_t stretch = 0;
  size_t first = 0, last = 0;  // Lines, the last one behind the band's.
  double freedom = 0;          // Lines, less what the temperature took of them.
  double power = 0;
};

// What the reading of a stretch says of means.
struct StretchMean {
  double value = 0, variance = 0;
  // Beside it, where the temperature changes: how the reading follows it, a kelvin.
  double per_k = 0, per_k_variance = 0;
};

struct AxisNoise {
  SmoothSpectrum smooth;
  std::vector<NoiseBand> bands;
  // By stretch and part: readings are dealt out to so many parts, each of which has a mean of its
  // own; what all parts share (a wandering bias) is in the variance of each, times their number.
  std::vector<std::vector<StretchMean>> means;
};

// `parts`: 1, or the number of parts to which stretches are dealt out. `share`: a band holds about
// this share of the lines below it, four at least.
AxisNoise noise_of_axis(const ImuData& data, size_t axis, size_t parts, double share);

// Whether the temperature changes within a stretch by what its log can show.
bool warms(const ImuStretch& stretch);

// omega of line k of n.
double omega_of_line(double k, size_t n);

}  // namespace seam::measurement
