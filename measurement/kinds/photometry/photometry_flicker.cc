// The residual light of flat fields' rows, in which the frequency of lamps is sought.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "effects/stages/timing.h"
#include "measurement/imaging/flicker_search.h"
#include "measurement/kinds/photometry/photometry_starts.h"
#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {
namespace {

// Of the rows that are kept.
std::vector<double> delays_of(const PhotometryData& data, const Model& model) {
  const std::vector<double> all = row_delays(model, data.sensor_height());
  std::vector<double> delays;
  for (int v = 0; v < data.height_px; ++v) delays.push_back(all[static_cast<size_t>(data.row(v))]);
  return delays;
}

RowLight row_light(const PhotometryView& view, const Model& model,
                   const PhotometryPrediction& prediction) {
  const PhotometryData& data = view.data;
  const effects::Timing timing = effects::timing_of(model);
  RowLight out;
  out.row_delay_s = delays_of(data, model);
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
      const double x = 2.0 * data.row(v) / std::max(1, data.sensor_height() - 1) - 1;
      basis.row(v) << 1, x, x * x, x * x * x;
      double seen = 0;
      for (int c = 0; c < data.channels; ++c)
        seen += sum.row_mean[static_cast<size_t>(v) * data.channels + c] / data.channels;
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

}  // namespace

double flicker_looks(const PhotometryData& data, const Model& model) {
  size_t frames = 0;
  for (const PhotometryLevel& level : data.levels)
    frames += level.illumination == 0 ? 0 : level.frames.size();
  const double span = std::abs(data.frames.back().time_s - data.frames.front().time_s);
  return flicker_looks(delays_of(data, model), {data.frames.size(), span, data.frame_period_s},
                       frames);
}

std::vector<std::vector<double>> flicker_starts(const PhotometryView& view, const Model& model,
                                                const PhotometryPrediction& prediction) {
  return {strongest_flicker(row_light(view, model, prediction), view.data.frame_period_s)};
}

}  // namespace seam::measurement
