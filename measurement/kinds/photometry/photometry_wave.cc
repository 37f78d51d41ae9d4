// The strongest wave of the residual means over the image: a transform over all directions and
// periods, on half of the step at which two waves are told apart.
#include <algorithm>
#include <cmath>
#include <complex>

#include "measurement/kinds/photometry/photometry_smooth.h"
#include "measurement/kinds/photometry/photometry_starts.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

using Complex = std::complex<double>;

// Slower waves than this many over the image are smooth fields.
constexpr double kFewestCycles = 1.5;

// The residual of each pixel over the levels that are not clipped, without its smooth part.
std::vector<double> rough_residual(const PhotometryView& view,
                                   const PhotometryPrediction& prediction) {
  const auto channels = static_cast<size_t>(view.data.channels);
  std::vector<double> residual(view.data.samples(), 0), weight(view.data.samples(), 0);
  for (size_t l = 0; l < prediction.levels.size(); ++l) {
    const LevelSums& sum = view.sums.levels[l];
    const LevelPrediction& level = prediction.levels[l];
    for (size_t i = 0; i < sum.mean.size(); ++i) {
      const double slope = level.offset_slope[i];
      const double w = slope * static_cast<double>(sum.frames.size()) / level.variance[i];
      residual[i] += w * (sum.mean[i] - level.mean[i]), weight[i] += w * slope;
    }
  }
  for (size_t i = 0; i < residual.size(); ++i) residual[i] /= std::max(weight[i], 1e-300);
  const std::vector<double> smooth = SmoothField(view.data).of(residual);
  std::vector<double> pixels(residual.size() / channels, 0);
  for (size_t i = 0; i < residual.size(); ++i)
    pixels[i / channels] += (residual[i] - smooth[i]) / static_cast<double>(channels);
  return pixels;
}

struct Frequency {
  double u = 0, v = 0;  // Cycles a pixel.
};

Complex amplitude_at(const PhotometryData& data, const std::vector<double>& pixels,
                     const Frequency& f) {
  Complex sum = 0;
  size_t i = 0;
  for (int v = 0; v < data.height_px; ++v) {
    Complex row = 0;
    for (int u = 0; u < data.width_px; ++u, ++i)
      row += pixels[i] * std::polar(1.0, -2 * maths::kPi * f.u * data.column(u));
    sum += row * std::polar(1.0, -2 * maths::kPi * f.v * data.row(v));
  }
  return 2.0 * sum / static_cast<double>(pixels.size());
}

// The strongest on a grid: rows are transformed first, then columns.
Frequency strongest_on_grid(const PhotometryData& data, const std::vector<double>& pixels) {
  const double step_u = 0.5 / data.sensor_width(), step_v = 0.5 / data.sensor_height();
  const int count_u = data.sensor_width(), count_v = data.sensor_height();
  std::vector<std::vector<Complex>> turns;  // By frequency along v, then row.
  for (int k = -count_v; k <= count_v; ++k) {
    turns.emplace_back();
    for (int v = 0; v < data.height_px; ++v)
      turns.back().push_back(std::polar(1.0, -2 * maths::kPi * k * step_v * data.row(v)));
  }
  Frequency best;
  double highest = -1;
  std::vector<Complex> rows(static_cast<size_t>(data.height_px)),
      turn(static_cast<size_t>(data.width_px));
  for (int j = 0; j <= count_u; ++j) {
    for (int u = 0; u < data.width_px; ++u)
      turn[static_cast<size_t>(u)] = std::polar(1.0, -2 * maths::kPi * j * step_u * data.column(u));
    size_t i = 0;
    for (Complex& row : rows) {
      row = 0;
      for (const Complex& t : turn) row += pixels[i++] * t;
    }
    for (int k = -count_v; k <= count_v; ++k) {
      const double cycles_u = 0.5 * j, cycles_v = 0.5 * std::abs(k);
      if (cycles_u < kFewestCycles && cycles_v < kFewestCycles) continue;
      if (j == 0 && k < 0) continue;  // The same wave upside down.
      Complex sum = 0;
      const auto& own = turns[static_cast<size_t>(k + count_v)];
      for (size_t v = 0; v < rows.size(); ++v) sum += rows[v] * own[v];
      if (std::norm(sum) > highest) highest = std::norm(sum), best = {j * step_u, k * step_v};
    }
  }
  return best;
}

}  // namespace

double wave_looks(const PhotometryData& data) {
  return std::max(1.0, 0.5 * data.sensor_width() * data.sensor_height());
}

std::vector<double> strongest_wave(const PhotometryView& view,
                                   const PhotometryPrediction& prediction) {
  const PhotometryData& data = view.data;
  const std::vector<double> pixels = rough_residual(view, prediction);
  Frequency best = strongest_on_grid(data, pixels);
  Complex amplitude = amplitude_at(data, pixels, best);
  for (double part = 0.25; part > 0.01; part /= 2) {
    const Frequency centre = best;
    for (int j = -1; j <= 1; ++j) {
      for (int k = -1; k <= 1; ++k) {
        const Frequency f{centre.u + j * part / data.sensor_width(),
                          centre.v + k * part / data.sensor_height()};
        const Complex here = amplitude_at(data, pixels, f);
        if (std::abs(here) > std::abs(amplitude)) amplitude = here, best = f;
      }
    }
  }
  if (best.u < 0) best = {-best.u, -best.v}, amplitude = std::conj(amplitude);
  // a sin(x + phase) has the amplitude a e^{i (phase - pi / 2)}.
  return {std::abs(amplitude), 1 / std::max(std::hypot(best.u, best.v), 1e-9),
          std::atan2(best.v, best.u), maths::wrap_angle(std::arg(amplitude) + maths::kPi / 2)};
}

}  // namespace seam::measurement
