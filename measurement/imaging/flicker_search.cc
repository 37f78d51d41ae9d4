// The frequency of lamps from rows: each frame's rows give an amplitude at a coarse grid of
// frequencies; the frames' stamps then sharpen it coherently.
#include "measurement/imaging/flicker_search.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "effects/stages/timing.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

using Complex = std::complex<double>;

// Which frequencies can be seen.
struct Band {
  double readout_s;  // Time from the first row to the last.
  double highest_hz;
};

// Without rows in time only the frames' stamps tell, up to half their rate.
Band band_of(const std::vector<double>& row_delay_s, const FrameStamps& stamps) {
  const double readout = std::abs(row_delay_s.back() - row_delay_s.front());
  const auto steps = static_cast<double>(std::max<size_t>(2, stamps.count) - 1);
  const double period = stamps.period_s > 0 ? stamps.period_s : stamps.span_s / steps;
  const auto rows = static_cast<double>(row_delay_s.size());
  return {readout, readout > 0 ? std::min(1500.0, 0.45 * rows / readout) : 0.5 / period};
}

// Whether rows follow each other at one step; not where only some are kept.
bool are_even(const std::vector<double>& delay_s) {
  if (delay_s.size() < 3) return true;
  const double step = delay_s[1] - delay_s[0];
  return std::abs(delay_s.back() - delay_s[0] - step * static_cast<double>(delay_s.size() - 1)) <=
         1e-6 * std::abs(step);
}

Complex frame_amplitude(const RowLight& rows, size_t frame, double frequency) {
  const double w = 2 * maths::kPi * frequency;
  Complex sum = 0;
  const auto& relative = rows.relative[frame];
  if (!are_even(rows.row_delay_s)) {
    for (size_t v = 0; v < relative.size(); ++v)
      sum += relative[v] * std::polar(1.0, -w * rows.row_delay_s[v]);
    return sum / static_cast<double>(relative.size());
  }
  const double step = rows.row_delay_s.size() > 1 ? rows.row_delay_s[1] - rows.row_delay_s[0] : 0;
  const Complex turn = std::polar(1.0, -w * step);
  Complex phase = std::polar(1.0, -w * rows.row_delay_s[0]);
  for (const double r : relative) sum += r * phase, phase *= turn;
  return sum / static_cast<double>(relative.size());
}

}  // namespace

std::vector<double> row_delays(const effects::Model& model, int rows) {
  const effects::Timing timing = effects::timing_of(model);
  std::vector<double> delays;
  for (int v = 0; v < rows; ++v) delays.push_back(timing.row_start_after_stamp_s(v, 0));
  return delays;
}

double flicker_looks(const std::vector<double>& row_delay_s, const FrameStamps& stamps,
                     size_t lit_frames) {
  const Band band = band_of(row_delay_s, stamps);
  // As many as the frames' stamps tell, for each wave that the readout tells.
  return std::max(
      1.0, static_cast<double>(lit_frames) * std::max(1.0, band.highest_hz * band.readout_s));
}

std::vector<double> strongest_flicker(const RowLight& rows, double period_s) {
  const size_t frames = rows.frame_time_s.size();
  if (frames == 0) return {100, 0.01, 0};
  const auto [first, last] =
      std::minmax_element(rows.frame_time_s.begin(), rows.frame_time_s.end());
  const double span = std::max(*last - *first, 1e-3);
  const auto [readout, highest] =
      band_of(rows.row_delay_s, {.count = frames, .span_s = span, .period_s = period_s});
  const double coarse = readout > 0 ? 0.2 / readout : highest;
  const double fine = 0.15 / span;
  struct Peak {
    double power, frequency;
    Complex amplitude;
  };
  Peak best{0, 100, 0};
  for (double centre = readout > 0 ? coarse : 0.5 * highest; centre <= highest; centre += coarse) {
    std::vector<Complex> amplitude(frames);
    double incoherent = 0;
    for (size_t f = 0; f < frames; ++f) {
      amplitude[f] = rows.weight[f] * frame_amplitude(rows, f, centre);
      incoherent += std::abs(amplitude[f]);
    }
    // No phase of the frames can bring more than the sum of their sizes.
    if (incoherent * incoherent < best.power) continue;
    const double half = readout > 0 ? 0.5 * coarse : highest;
    for (double f0 = centre - half; f0 <= centre + half; f0 += fine) {
      if (f0 <= 0) continue;
      Complex sum = 0;
      for (size_t f = 0; f < frames; ++f) {
        sum +=
            amplitude[f] * std::polar(1.0, -2 * maths::kPi * f0 * (rows.frame_time_s[f] - *first));
      }
      if (std::norm(sum) > best.power) best = {std::norm(sum), f0, sum};
    }
  }
  double weight = 0;
  for (const double w : rows.weight) weight += w;
  const Complex a = best.amplitude * 2.0 / weight;
  // residual = Re(a exp(i w (t - first))) = |a| sin(w t + arg a + pi/2 - w first).
  const double phase =
      maths::wrap_angle(std::arg(a) + 0.5 * maths::kPi -
                        std::remainder(2 * maths::kPi * best.frequency * *first, 2 * maths::kPi));
  const double depth = std::clamp(std::abs(a), 1e-4, 0.9);
  return {best.frequency, depth, phase};
}

}  // namespace seam::measurement
