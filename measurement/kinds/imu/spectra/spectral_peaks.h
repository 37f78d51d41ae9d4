// Narrow lines that stand out of a smooth spectrum, and how finely it is cut near them.
#pragma once

#include <cstddef>
#include <vector>

namespace seam::measurement {

// In radians a sample.
struct SpectralPeak {
  double omega = 0, width = 0;
};

// Lines of all stretches over a spectrum that fits them, added up in even cells: cell i is at i
// times the distance of the longest stretch's lines.
struct WhiteLines {
  double step = 0;  // Radians a sample from cell to cell.
  std::vector<double> power, count;
};

// Peaks that no chance makes, the clearest first; those that bands of this share show anyhow (they
// hold this share of the lines below them) are none.
std::vector<SpectralPeak> peaks_of(const WhiteLines& lines, double share);

// How wide a band at omega may be: a quarter of a peak's width, or a sixth of the distance from it.
double finest_at(const std::vector<SpectralPeak>& peaks, double omega);

// A Lorentzian of height 1.
double height_at(const SpectralPeak& peak, double omega);

}  // namespace seam::measurement
