#include "measurement/kinds/imu/noise_lines.h"

#include <algorithm>
#include <cmath>

#include "measurement/kinds/imu/spectra/cosine_transform.h"
#include "measurement/numerics/moments.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

constexpr double kLeastWarming_k = 0.2;
constexpr size_t kMostCells = 600, kMostModes = 64;

constexpr size_t kPowers = 4, kFlicker = 2;          // Of frequency, before the peaks.
constexpr double kPeakWidths[] = {0.25, 0.5, 1, 2};  // Times that of the window that found it.

// Calls `take` with each shape's value there, in the order of their sizes.
void each_shape_at(double omega, const std::vector<SpectralPeak>& peaks, const auto& take) {
  const double difference = 2 * std::sin(omega / 2);
  take(difference * difference), take(1.0), take(1 / difference);
  take(1 / (difference * difference));
  for (const SpectralPeak& peak : peaks) {
    for (const double wide : kPeakWidths) take(height_at({peak.omega, wide * peak.width}, omega));
  }
}

std::vector<double> shapes_at(double omega, const std::vector<SpectralPeak>& peaks) {
  std::vector<double> shapes;
  each_shape_at(omega, peaks, [&](double shape) { shapes.push_back(shape); });
  return shapes;
}

struct PooledBand {
  double power = 0, lines = 0;
  std::vector<double> shapes;
};

// By Itakura and Saito's distance, which is the likelihood of powers: multiplicative steps, in
// which sizes stay positive (Fevotte and Idier 2011).
std::vector<double> sizes_through(const std::vector<PooledBand>& bands, bool with_flicker) {
  constexpr int kSteps = 400;
  const size_t count = bands.front().shapes.size();
  std::vector<double> sizes(count, 0), up(count), down(count);
  double lines = 0;
  double most = 0;
  for (const PooledBand& band : bands) {
    for (size_t j = 0; j < kPowers; ++j) sizes[j] += band.lines * band.power / band.shapes[j];
    lines += band.lines;
    most = std::max(most, band.power);
  }
  for (size_t j = 0; j < count; ++j)
    sizes[j] = j < kPowers ? std::max(1e-300, sizes[j] / (kPowers * lines)) : most;
  if (!with_flicker) sizes[kFlicker] = 0;
  for (int step = 0; step < kSteps; ++step) {
    std::fill(up.begin(), up.end(), 0), std::fill(down.begin(), down.end(), 0);
    for (const PooledBand& band : bands) {
      double all = 0;
      for (size_t j = 0; j < count; ++j) all += sizes[j] * band.shapes[j];
      for (size_t j = 0; j < count; ++j) {
        up[j] += band.lines * band.shapes[j] * band.power / (all * all);
        down[j] += band.lines * band.shapes[j] / all;
      }
    }
    for (size_t j = 0; j < count; ++j) sizes[j] *= std::sqrt(up[j] / down[j]);
  }
  return sizes;
}

double log_likelihood(const std::vector<PooledBand>& bands, const std::vector<double>& sizes) {
  double sum = 0;
  for (const PooledBand& band : bands) {
    double all = 0;
    for (size_t j = 0; j < sizes.size(); ++j) all += sizes[j] * band.shapes[j];
    sum -= 0.5 * band.lines * (band.power / all + std::log(all));
  }
  return sum;
}

// Few lines separate flicker noise from a walk, and a walk leaves means and slopes far less
// certain: it is taken unless it is less likely by two standard errors.
std::vector<double> careful_sizes(const std::vector<PooledBand>& bands) {
  constexpr double kLessLikely = 2;
  std::vector<double> all = sizes_through(bands, true), some = sizes_through(bands, false);
  return log_likelihood(bands, some) < log_likelihood(bands, all) - kLessLikely ? all : some;
}

// Ends of bands over the lines 1 to n - 1: a share of the lines below, less near peaks, and so many
// lines at least.
std::vector<size_t> band_ends(size_t n, double share, size_t least,
                              const std::vector<SpectralPeak>& peaks) {
  std::vector<size_t> ends = {1};
  while (ends.back() < n) {
    const auto here = static_cast<double>(ends.back());
    const double fine =
        finest_at(peaks, omega_of_line(here, n)) * static_cast<double>(n) / maths::kPi;
    const auto wide = static_cast<size_t>(std::min(share * here, fine));
    size_t next = ends.back() + std::max(least, wide);
    if (n < next + least) next = n;
    ends.push_back(next);
  }
  return ends;
}

// Lines of a stretch: coefficients of its readings, and what of each the temperature explains.
struct Lines {
  std::vector<double> reading;
  std::vector<double> leverage;  // Empty: no temperature.
};

std::vector<PooledBand> pooled(const std::vector<Lines>& all,
                               const std::vector<SpectralPeak>& peaks) {
  constexpr double kFine = 0.1;
  std::vector<PooledBand> bands;
  for (const Lines& lines : all) {
    const size_t n = lines.reading.size();
    // The first lines one by one: there the spectrum may be steep.
    const std::vector<size_t> ends = band_ends(n, kFine, 1, peaks);
    for (size_t b = 0; b + 1 < ends.size(); ++b) {
      PooledBand band;
      for (size_t k = ends[b]; k < ends[b + 1]; ++k) {
        band.power += lines.reading[k] * lines.reading[k];
        band.lines += lines.leverage.empty() ? 1 : 1 - lines.leverage[k];
      }
      // Of lines that the temperature took nearly whole nothing is left to see.
      constexpr double kLeast = 0.05;
      if (!(band.lines > kLeast)) continue;
      band.power = std::max(band.power / band.lines, 1e-300);
      band.shapes =
          shapes_at(omega_of_line(0.5 * static_cast<double>(ends[b] + ends[b + 1] - 1), n), peaks);
      bands.push_back(band);
    }
  }
  return bands;
}

WhiteLines whitened(const std::vector<Lines>& all, const SmoothSpectrum& smooth) {
  size_t longest = 0;
  for (const Lines& lines : all) longest = std::max(longest, lines.reading.size());
  WhiteLines white{.step = omega_of_line(1, longest),
                   .power = std::vector<double>(longest, 0),
                   .count = std::vector<double>(longest, 0)};
  for (const Lines& lines : all) {
    const size_t n = lines.reading.size();
    for (size_t k = 1; k < n; ++k) {
      const size_t cell = std::min(longest - 1, (2 * k * longest + n) / (2 * n));
      white.power[cell] +=
          lines.reading[k] * lines.reading[k] / smooth.at(omega_of_line(static_cast<double>(k), n));
      white.count[cell] += 1;
    }
  }
  return white;
}

SmoothSpectrum smooth_through(const std::vector<Lines>& lines, double share) {
  SmoothSpectrum smooth{.size = careful_sizes(pooled(lines, {}))};
  smooth.peaks = peaks_of(whitened(lines, smooth), share);
  if (!smooth.peaks.empty()) smooth.size = careful_sizes(pooled(lines, smooth.peaks));
  return smooth;
}

// Cells of a stretch: means of readings and temperature, dealt out to parts in turn.
struct Cells {
  std::vector<double> reading, temperature_c;
};
Cells cells_of(const ImuStretch& stretch, size_t axis, size_t parts) {
  const size_t n = stretch.rows.size();
  const size_t count = std::max(parts, std::min(kMostCells, n / 8) / parts * parts);
  Cells cells;
  for (size_t j = 0; j < count; ++j) {
    const size_t from = j * n / count, to = (j + 1) * n / count;
    double reading = 0, warmth = 0;
    for (size_t i = from; i < to; ++i) {
      reading += stretch.samples[axis][i];
      if (!stretch.temperature_c.empty()) warmth += stretch.temperature_c[i];
    }
    cells.reading.push_back(reading / static_cast<double>(to - from));
    cells.temperature_c.push_back(warmth / static_cast<double>(to - from));
  }
  return cells;
}

// Weights of cells by which the reading's dependence on temperature is estimated best, and its
// variance.
struct Regression {
  std::vector<double> weight;  // By cell.
  double variance = 0;
};
Regression regression_of(const Cells& cells, const SmoothSpectrum& smooth, size_t n) {
  const size_t count = cells.reading.size();
  const std::vector<double> lines = cosine_transform(cells.temperature_c);
  // A mean of n / count samples: their variance is that of a sample's line over as many.
  const double samples = static_cast<double>(n) / static_cast<double>(count);
  std::vector<double> weighted(count, 0);
  double information = 0;
  for (size_t k = 1; k < std::min(kMostModes, count / 4); ++k) {
    const double variance = smooth.at(omega_of_line(static_cast<double>(k), n)) / samples;
    weighted[k] = lines[k] / variance;
    information += lines[k] * lines[k] / variance;
  }
  Regression out{.weight = inverse_cosine_transform(weighted), .variance = 1 / information};
  for (double& w : out.weight) w /= information;
  return out;
}

// The dependence estimated from some of the cells.
double slope_of(const Cells& cells, const Regression& regression, size_t first, size_t step) {
  double reading = 0, warmth = 0, count = 0, up = 0, down = 0;
  for (size_t j = first; j < cells.reading.size(); j += step)
    reading += cells.reading[j], warmth += cells.temperature_c[j], ++count;
  for (size_t j = first; j < cells.reading.size(); j += step) {
    up += regression.weight[j] * (cells.reading[j] - reading / count);
    down += regression.weight[j] * (cells.temperature_c[j] - warmth / count);
  }
  return up / down;
}

Lines lines_of(const ImuStretch& stretch, size_t axis, const SmoothSpectrum* smooth) {
  std::vector<double> series = stretch.samples[axis];
  const size_t n = series.size();
  Lines lines;
  if (smooth != nullptr && warms(stretch)) {
    const Cells cells = cells_of(stretch, axis, 1);
    const Regression regression = regression_of(cells, *smooth, n);
    const double slope = slope_of(cells, regression, 0, 1);
    const double mean = mean_of(stretch.temperature_c);
    for (size_t i = 0; i < n; ++i) series[i] -= slope * (stretch.temperature_c[i] - mean);
    lines.leverage = cosine_transform(stretch.temperature_c);
    double sum = 0;
    for (size_t k = 1; k < n; ++k) {
      lines.leverage[k] *= lines.leverage[k] / smooth->at(omega_of_line(static_cast<double>(k), n));
      sum += lines.leverage[k];
    }
    for (double& leverage : lines.leverage) leverage /= sum;
  }
  const double mean = mean_of(series);
  for (double& value : series) value -= mean;
  lines.reading = cosine_transform(series);
  return lines;
}

void add_bands(const Lines& lines, size_t stretch, const SmoothSpectrum& smooth, double share,
               std::vector<NoiseBand>& bands) {
  const size_t n = lines.reading.size();
  const std::vector<size_t> ends = band_ends(n, share, kLeastLines, smooth.peaks);
  for (size_t b = 0; b + 1 < ends.size(); ++b) {
    NoiseBand band{.stretch = stretch, .first = ends[b], .last = ends[b + 1]};
    band.freedom = static_cast<double>(band.last - band.first);
    for (size_t k = band.first; k < band.last; ++k) {
      band.power +=
          lines.reading[k] * lines.reading[k] / smooth.at(omega_of_line(static_cast<double>(k), n));
      if (!lines.leverage.empty()) band.freedom -= lines.leverage[k];
    }
    band.power /= band.freedom;
    bands.push_back(band);
  }
}

std::vector<StretchMean> means_of(const ImuStretch& stretch, size_t axis, size_t parts,
                                  const SmoothSpectrum& smooth) {
  const size_t n = stretch.rows.size();
  const Cells cells = cells_of(stretch, axis, parts);
  const auto count = static_cast<double>(parts);
  std::vector<StretchMean> means(parts);
  // How far the mean of a stretch lies off is not in its lines: its power is taken as that half a
  // line before the first one.
  const double variance = smooth.at(omega_of_line(0.5, n)) / static_cast<double>(n);
  const bool warming = warms(stretch);
  const Regression regression = warming ? regression_of(cells, smooth, n) : Regression{};
  for (size_t part = 0; part < parts; ++part) {
    double sum = 0, number = 0;
    for (size_t j = part; j < cells.reading.size(); j += parts) sum += cells.reading[j], ++number;
    means[part] = {.value = sum / number, .variance = variance * count};
    if (!warming) continue;
    means[part].per_k = slope_of(cells, regression, part, parts);
    means[part].per_k_variance = regression.variance * count;
  }
  return means;
}

}  // namespace

double SmoothSpectrum::at(double omega) const {
  double sum = 0;
  size_t j = 0;
  each_shape_at(omega, peaks, [&](double shape) { sum += size[j++] * shape; });
  return sum;
}

double omega_of_line(double k, size_t n) {
  return maths::kPi * k / static_cast<double>(n);
}

bool warms(const ImuStretch& stretch) {
  if (stretch.temperature_c.empty()) return false;
  const auto [low, high] =
      std::minmax_element(stretch.temperature_c.begin(), stretch.temperature_c.end());
  return *high - *low > kLeastWarming_k;
}

AxisNoise noise_of_axis(const ImuData& data, size_t axis, size_t parts, double share) {
  AxisNoise out;
  std::vector<Lines> lines;
  // What the temperature does is taken out by a spectrum, and the spectrum is that of the rest.
  for (int round = 0; round < 3; ++round) {
    lines.clear();
    for (const ImuStretch& stretch : data.stretches)
      lines.push_back(lines_of(stretch, axis, round == 0 ? nullptr : &out.smooth));
    if (round < 2) out.smooth = smooth_through(lines, share);
    if (round == 0 && std::none_of(data.stretches.begin(), data.stretches.end(), warms)) break;
  }
  for (size_t s = 0; s < data.stretches.size(); ++s) {
    add_bands(lines[s], s, out.smooth, share, out.bands);
    out.means.push_back(means_of(data.stretches[s], axis, parts, out.smooth));
  }
  return out;
}

}  // namespace seam::measurement
