// Residuals of flat fields as plots need them. The mean: each sample of each level, averaged over
// the level's frames. The spread: single values of a few frames, less what their level has on
// average.
#include <cmath>

#include "effects/stages/geometry.h"
#include "measurement/kinds/photometry/likelihood/photometry_model.h"
#include "measurement/kinds/photometry/photometry_problem.h"
#include "measurement/problem/residual_view.h"

namespace seam::measurement {
namespace {

// Every k-th sample: enough for plots of a set of any size.
constexpr size_t kMostPlaces = 200'000;
constexpr size_t kSpreadFrames = 2;

double square(double x) {
  return x * x;
}

}  // namespace

ResidualView PhotometryProblem::residual_view(const Model& model, const Groups& groups) const {
  const HeldView held = view_of(model, groups);
  const auto& sum = held.sums;
  const PhotometryPrediction prediction = predict(held.view.data, *sum, model, set_noise_dn_);
  const auto& chain = prediction.chain;
  ResidualView::Channel mean{.name = "dn"}, spread{.name = "dn spread"};
  std::vector<double> row, column, radius, light, channel;
  const size_t step = std::max<size_t>(1, data_.samples() * data_.levels.size() / kMostPlaces);
  for (size_t l = 0; l < sum->levels.size(); ++l) {
    const LevelSums& level = sum->levels[l];
    if (level.frames.empty()) continue;
    const LevelPrediction& predicted = prediction.levels[l];
    const double n = static_cast<double>(level.frames.size());
    for (size_t i = l % step; i < data_.samples(); i += step) {
      const size_t pixel = i / data_.channels;
      const double u = data_.column(static_cast<int>(pixel % data_.width_px)),
                   v = data_.row(static_cast<int>(pixel / data_.width_px));
      const int at = static_cast<int>(row.size());
      row.push_back(v);
      column.push_back(u);
      radius.push_back(effects::rho(u, v, data_.sensor_width(), data_.sensor_height()));
      light.push_back(predicted.illumination * data_.levels[l].exposure_ratio);
      channel.push_back(static_cast<double>(i % data_.channels));
      // Of a mean of so many values, beside what moves all values of a pixel in proportion.
      const auto sigma_of = [&](double values, double gain2) {
        const double offsets = square(chain.pixel_offset_sigma_dn) +
                               square(chain.dark_sigma_dn_per_s * data_.levels[l].dark_s()) +
                               square(chain.column_sigma_dn) + square(chain.row_sigma_dn) / values;
        return std::sqrt(predicted.variance[i] / values +
                         offsets * square(predicted.offset_slope[i]) +
                         gain2 * square(predicted.gain_slope[i]));
      };
      mean.observed.push_back(level.mean[i]);
      mean.residual.push_back(level.mean[i] - predicted.mean[i]);
      mean.sigma.push_back(sigma_of(n, square(chain.pixel_gain_sigma)));
      mean.row.push_back(at);
      mean.value_sigma.push_back(
          sigma_of(1, square(chain.pixel_gain_sigma) + square(chain.lamp_sigma)));
      if (level.frames.size() < 3) continue;
      for (size_t k = 0; k < kSpreadFrames; ++k) {
        const double value = held.view.data.value(static_cast<size_t>(level.frames[k]), i);
        spread.residual.push_back(value - level.mean[i]);
        const double own =
            predicted.variance[i] + square(chain.row_sigma_dn * predicted.offset_slope[i]);
        spread.sigma.push_back(std::sqrt(own * (1 - 1 / n)));
        spread.row.push_back(at);
      }
    }
  }
  ResidualView view;
  view.channels = {std::move(mean), std::move(spread)};
  view.covariates = {{"row", std::move(row)},
                     {"column", std::move(column)},
                     {"radius", std::move(radius)},
                     {"illumination", std::move(light)},
                     {"channel", std::move(channel)}};
  return view;
}

}  // namespace seam::measurement
