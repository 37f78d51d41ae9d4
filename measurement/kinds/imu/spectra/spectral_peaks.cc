#include "measurement/kinds/imu/spectra/spectral_peaks.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace seam::measurement {
namespace {

constexpr size_t kLeastCells = 4;
// Of a normal error: one of a thousand sets has such a window by chance, among a million of them.
constexpr double kByChance = 6;
constexpr size_t kMostPeaks = 12;  // Harmonics of one motor; more would make bands without end.

class Sums {
 public:
  explicit Sums(const WhiteLines& lines) : power_(1, 0), count_(1, 0) {
    for (size_t i = 0; i < lines.power.size(); ++i) {
      power_.push_back(power_.back() + lines.power[i]);
      count_.push_back(count_.back() + lines.count[i]);
    }
  }
  size_t cells() const { return power_.size() - 1; }
  double power(size_t from, size_t to) const { return power_[to] - power_[from]; }
  double count(size_t from, size_t to) const { return count_[to] - count_[from]; }

 private:
  std::vector<double> power_, count_;
};

// By how many errors the cube root of a window's mean power lies above that of its neighbours
// (Wilson and Hilferty 1931).
double stands_out(const Sums& sums, size_t from, size_t wide) {
  constexpr size_t kAround = 4;  // Times the width, on either side.
  const size_t low = from > kAround * wide ? from - kAround * wide : 1;
  const size_t to = from + wide, high = std::min(sums.cells(), to + kAround * wide);
  const double count = sums.count(from, to), others = sums.count(low, high) - count;
  if (!(count >= static_cast<double>(kLeastCells)) || !(others >= count)) return 0;
  const double mean = sums.power(from, to) / count;
  const double beside = (sums.power(low, high) - sums.power(from, to)) / others;
  const auto lost = [](double freedom) { return 2 / (9 * freedom); };
  return (std::cbrt(mean / beside) - (1 - lost(count)) / (1 - lost(others))) /
         std::sqrt(lost(count) + lost(others));
}

struct Window {
  double errors = 0;
  size_t from = 0, wide = 0;
};

}  // namespace

std::vector<SpectralPeak> peaks_of(const WhiteLines& lines, double share) {
  const Sums sums(lines);
  std::vector<Window> windows;
  for (size_t wide = kLeastCells; wide < sums.cells(); wide *= 2) {
    const auto first = static_cast<size_t>(static_cast<double>(wide) / share);
    for (size_t from = first; from + wide <= sums.cells(); from += wide / 2) {
      const double errors = stands_out(sums, from, wide);
      if (errors > kByChance) windows.push_back({errors, from, wide});
    }
  }
  std::stable_sort(windows.begin(), windows.end(),
                   [](const Window& a, const Window& b) { return a.errors > b.errors; });
  std::vector<SpectralPeak> peaks;
  for (const Window& window : windows) {
    const double middle =
        static_cast<double>(window.from) + 0.5 * static_cast<double>(window.wide - 1);
    const SpectralPeak peak{middle * lines.step, static_cast<double>(window.wide) * lines.step};
    // Flanks of a peak that is there already.
    const bool known = std::any_of(peaks.begin(), peaks.end(), [&](const SpectralPeak& other) {
      return std::abs(other.omega - peak.omega) < 2 * (other.width + peak.width);
    });
    if (!known && peaks.size() < kMostPeaks) peaks.push_back(peak);
  }
  return peaks;
}

double finest_at(const std::vector<SpectralPeak>& peaks, double omega) {
  double finest = std::numeric_limits<double>::infinity();
  for (const SpectralPeak& peak : peaks)
    finest = std::min(finest, std::max(peak.width / 4, std::abs(omega - peak.omega) / 6));
  return finest;
}

double height_at(const SpectralPeak& peak, double omega) {
  const double away = 2 * (omega - peak.omega) / peak.width;
  return 1 / (1 + away * away);
}

}  // namespace seam::measurement
