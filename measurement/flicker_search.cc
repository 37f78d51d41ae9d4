// The frequency of lamps from rows: each frame's rows give an amplitude at a coarse grid of
// frequencies; the frames' stamps then sharpen it coherently.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>

#include "effects/timing.h"
#include "measurement/linear_algebra.h"
#include "measurement/photometry_starts.h"
#include "sim_core/maths.h"

namespace seam::measurement {
namespace {

using Complex = std::complex<double>;

// Residual light of rows relative to the predicted light, with weights.
struct RowLight {
  std::vector<double> frame_time_s;
  std::vector<double> row_delay_s;                // Of the middle of each row's window after the stamp.
  std::vector<std::vector<double>> relative;      // By frame, by row.
  std::vector<double> weight;                     // By frame: inverse variance of a relative value.
};

std::vector<double> row_delays(const PhotometryData& data, const Model& model) {
  const effects::Timing timing = effects::timing_of(model);
  std::vector<double> delays;
  for (int v = 0; v < data.height_px; ++v) delays.push_back(timing.row_start_after_stamp_s(v, 0));
  return delays;
}

RowLight row_light(const PhotometryView& view, const Model& model, const PhotometryPrediction& prediction) {
  const PhotometryData& data = view.data;
  const effects::Timing timing = effects::timing_of(model);
  RowLight out;
  out.row_delay_s = row_delays(data, model);
  for (size_t l = 0; l < view.sums.levels.size(); ++l) {
    const LevelSums& sum = view.sums.levels[l];
    const LevelPrediction& level = prediction.levels[l];
    if (sum.frames.empty()) continue;
    std::vector<double> gain(data.height_px, 0), mean(data.height_px, 0);
    double variance = 0;
    const double share = 1.0 / (data.width_px * data.channels);
    for (size_t i = 0; i < level.mean.size(); ++i) {
      const size_t v = i / (static_cast<size_t>(data.width_px) * data.channels);
      gain[v] += share * level.gain_slope[i];
      mean[v] += share * level.mean[i];
      variance += level.variance[i] / static_cast<double>(level.mean.size());
    }
    double size = 0;
    for (const double g : gain) size += g * g / data.height_px;
    if (!(size > 0.01)) continue;
    // A smooth field over rows is no wave: a cubic of the level's mean residual is taken out.
    Eigen::MatrixXd basis(data.height_px, 4);
    Eigen::VectorXd residual(data.height_px);
    for (int v = 0; v < data.height_px; ++v) {
      const double x = 2.0 * v / std::max(1, data.height_px - 1) - 1;
      basis.row(v) << 1, x, x * x, x * x * x;
      double seen = 0;
      for (int c = 0; c < data.channels; ++c) seen += sum.row_mean[static_cast<size_t>(v) * data.channels + c] / data.channels;
      residual[v] = (seen - mean[v]) / gain[v];
    }
    const bool waves = timing.line_delay_s != 0;
    Eigen::VectorXd smooth = Eigen::VectorXd::Constant(data.height_px, residual.mean());
    if (waves) {
      const Eigen::MatrixXd q = column_basis(basis);
      smooth = q * (q.transpose() * residual);
    }
    for (const int frame : sum.frames) {
      std::vector<double> relative;
      for (int v = 0; v < data.height_px; ++v) {
        double seen = 0;
        for (int c = 0; c < data.channels; ++c)
          seen += data.row_mean[frame][static_cast<size_t>(v) * data.channels + c] / data.channels;
        relative.push_back((seen - mean[v]) / gain[v] - smooth[v]);
      }
      out.frame_time_s.push_back(data.frames[frame].time_s + 0.5 * data.levels[l].exposure_s);
      out.relative.push_back(std::move(relative));
      out.weight.push_back(size * data.width_px * data.channels / variance);
    }
  }
  return out;
}

// Which frequencies can be seen.
struct Band {
  double readout_s;   // Time from the first row to the last.
  double highest_hz;
};

// Without rows in time only the frames' stamps tell, up to half their rate.
Band band_of(const PhotometryData& data, const std::vector<double>& row_delay_s, double span_s, size_t frames) {
  const double readout = std::abs(row_delay_s.back() - row_delay_s.front());
  const auto steps = static_cast<double>(std::max<size_t>(2, frames) - 1);
  const double period = data.frame_period_s > 0 ? data.frame_period_s : span_s / steps;
  const auto rows = static_cast<double>(row_delay_s.size());
  return {readout, readout > 0 ? std::min(1500.0, 0.45 * rows / readout) : 0.5 / period};
}

Complex frame_amplitude(const RowLight& rows, size_t frame, double frequency) {
  const double w = 2 * maths::kPi * frequency;
  Complex sum = 0;
  const auto& relative = rows.relative[frame];
  const double step = rows.row_delay_s.size() > 1 ? rows.row_delay_s[1] - rows.row_delay_s[0] : 0;
  const Complex turn = std::polar(1.0, -w * step);
  Complex phase = std::polar(1.0, -w * rows.row_delay_s[0]);
  for (const double r : relative) sum += r * phase, phase *= turn;
  return sum / static_cast<double>(relative.size());
}

}  // namespace

double flicker_looks(const PhotometryData& data, const Model& model) {
  size_t frames = 0;
  for (const PhotometryLevel& level : data.levels) frames += level.illumination == 0 ? 0 : level.frames.size();
  const double span = data.frames.back().time_s - data.frames.front().time_s;
  const Band band = band_of(data, row_delays(data, model), std::abs(span), data.frames.size());
  // As many as the frames' stamps tell, for each wave that the readout tells.
  return std::max(1.0, static_cast<double>(frames) * std::max(1.0, band.highest_hz * band.readout_s));
}

std::vector<std::vector<double>> flicker_starts(const PhotometryView& view, const Model& model,
                                                const PhotometryPrediction& prediction) {
  const RowLight rows = row_light(view, model, prediction);
  const size_t frames = rows.frame_time_s.size();
  if (frames == 0) return {{100, 0.01, 0}};
  const auto [first, last] = std::minmax_element(rows.frame_time_s.begin(), rows.frame_time_s.end());
  const double span = std::max(*last - *first, 1e-3);
  const auto [readout, highest] = band_of(view.data, rows.row_delay_s, span, frames);
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
        sum += amplitude[f] * std::polar(1.0, -2 * maths::kPi * f0 * (rows.frame_time_s[f] - *first));
      }
      if (std::norm(sum) > best.power) best = {std::norm(sum), f0, sum};
    }
  }
  double weight = 0;
  for (const double w : rows.weight) weight += w;
  const Complex a = best.amplitude * 2.0 / weight;
  // residual = Re(a exp(i w (t - first))) = |a| sin(w t + arg a + pi/2 - w first).
  const double phase = maths::wrap_angle(std::arg(a) + 0.5 * maths::kPi -
                                         std::remainder(2 * maths::kPi * best.frequency * *first, 2 * maths::kPi));
  const double depth = std::clamp(std::abs(a), 1e-4, 0.9);
  return {{best.frequency, depth, phase}};
}

}  // namespace seam::measurement
