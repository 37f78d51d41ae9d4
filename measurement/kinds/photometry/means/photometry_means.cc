#include "measurement/kinds/photometry/means/photometry_means.h"

#include <algorithm>
#include <cmath>

#include "effects/stages/geometry.h"
#include "measurement/kinds/photometry/likelihood/photometry_likelihood.h"
#include "measurement/kinds/photometry/structure/photometry_mean_tests.h"

namespace seam::measurement {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Columns = std::vector<std::vector<double>>;

// Means over cells of all frames in all, at most: a search looks at some hundred functions of them
// within seconds. And cells of the image, at least and at most: a function of the place changes
// direction a few times over it, and patterns of all cells are inverted together.
constexpr double kMostMeans = 12'000;
constexpr double kLeastCells = 48, kMostCells = 192;

double cells_for(const PhotometryData& data) {
  const double each = std::min(kMostMeans / static_cast<double>(data.frames.size()), kMostCells);
  return std::max(each, kLeastCells) / data.channels;
}

// Averages of what is predicted, and the noise of a mean. Values that are certain, as those of a
// field that is clipped, say nothing: their cells are left out.
LevelMeans level_means(const ImageCells& cells, const PhotometryData& data,
                       const PhotometryPrediction& prediction, size_t level,
                       const std::vector<char>& left_out) {
  const LevelPrediction& predicted = prediction.levels[level];
  const CertainValues certain(data, prediction.chain);
  LevelMeans out{.dark_s = data.levels[level].dark_s()};
  out.values = cells.sums(left_out, [](size_t) { return 1.0; });
  const VectorXd each = out.values.cwiseMax(1).cwiseInverse();
  const auto average = [&](const std::vector<double>& values) {
    return each.cwiseProduct(cells.sums(left_out, [&](size_t i) { return values[i]; })).eval();
  };
  out.mean = average(predicted.mean);
  out.offset_slope = average(predicted.offset_slope);
  out.gain_slope = average(predicted.gain_slope);
  const VectorXd sure = cells.sums(left_out, [&](size_t i) {
    return certain.is_certain(predicted.mean[i], predicted.variance[i]) ? 1.0 : 0.0;
  });
  out.sigma = average(predicted.variance).cwiseProduct(each).cwiseMax(0).cwiseSqrt();
  for (Index k = 0; k < cells.count(); ++k) {
    if (out.values[k] == 0 || sure[k] > 0) out.sigma[k] = 0;
  }
  return out;
}

// How far the means of one frame are predicted to lie from those of its level.
VectorXd frame_shift(const ImageCells& cells, const PhotometryData& data,
                     const LevelPrediction& level, size_t place, const VectorXd& values,
                     const std::vector<char>& left_out) {
  const std::vector<double>& rows = level.row_shift[place];
  const auto channels = static_cast<size_t>(data.channels);
  const size_t row_samples = static_cast<size_t>(data.width_px) * channels;
  return cells
      .sums(left_out, [&](size_t i) { return rows[i / row_samples * channels + i % channels]; })
      .cwiseQuotient(values.cwiseMax(1));
}

// Predicted means by frame and cell.
std::vector<double> predicted_means(const ImageCells& cells, const PhotometryData& data,
                                    const PhotometrySums& sums,
                                    const PhotometryPrediction& prediction,
                                    const std::vector<LevelMeans>& levels,
                                    const std::vector<char>& left_out) {
  const auto means = static_cast<size_t>(cells.count());
  std::vector<double> all(data.frames.size() * means);
  for (size_t l = 0; l < levels.size(); ++l) {
    for (size_t place = 0; place < sums.levels[l].frames.size(); ++place) {
      VectorXd own = levels[l].mean;
      if (prediction.moves)
        own += frame_shift(cells, data, prediction.levels[l], place, levels[l].values, left_out);
      const auto frame = static_cast<size_t>(sums.levels[l].frames[place]);
      std::copy(own.begin(), own.end(), all.begin() + static_cast<std::ptrdiff_t>(frame * means));
    }
  }
  return all;
}

std::vector<double> predicted_means(const ImageCells& cells, const MeanSource& source,
                                    const Model& model, double set_noise_dn) {
  const PhotometryPrediction prediction = predict(source.data, *source.sums, model, set_noise_dn);
  std::vector<LevelMeans> levels;
  for (size_t l = 0; l < prediction.levels.size(); ++l)
    levels.push_back(level_means(cells, source.data, prediction, l, {}));
  return predicted_means(cells, source.data, *source.sums, prediction, levels, {});
}

}  // namespace

PhotometryMeans::PhotometryMeans(MeanSource whole, MeanSource quick, const Facts& of_values,
                                 double set_noise_dn, bool channels_share)
    : whole_(std::move(whole)),
      quick_(std::move(quick)),
      set_noise_dn_(set_noise_dn),
      share_(channels_share || whole_.data.channels == 1),
      cells_(whole_.data, grid_of(quick_.data, cells_for(whole_.data))),
      quick_cells_(quick_.data, cells_.grid()) {
  for (const PhotometryFrame& frame : whole_.data.frames) level_of_frame_.push_back(frame.level);
  for (const PhotometryLevel& level : whole_.data.levels)
    blank_.push_back(std::isnan(level.illumination));
  fill_facts(of_values);
}

void PhotometryMeans::fill_facts(const Facts& of_values) {
  const PhotometryData& data = whole_.data;
  facts_.set = of_values.set;
  facts_.groups = of_values.groups;
  facts_.tests_neighbours = false;
  facts_.values_of_scalar =
      static_cast<double>(data.samples()) / static_cast<double>(cells_.count());
  for (int c = 0; c < data.channels; ++c) facts_.channels.push_back({.name = "dn"});
  Covariate column{.name = "column"}, row{.name = "row"}, radius{.name = "radius"},
      time{.name = "time"}, light{.name = "illumination"}, exposure{.name = "exposure_s"};
  const CellGrid grid = cells_.grid();
  for (size_t f = 0; f < data.frames.size(); ++f) {
    const PhotometryLevel& level = data.levels[static_cast<size_t>(data.frames[f].level)];
    for (Index k = 0; k < cells_.count(); ++k) {
      facts_.row_of.push_back(static_cast<int>(facts_.rows()));
      facts_.channel_of.push_back(cells_.channel_of(k));
      if (cells_.channel_of(k) + 1 < data.channels) continue;
      const double u = (cells_.column_of(k) + 0.5) / grid.columns * data.sensor_width() - 0.5,
                   v = (cells_.row_of(k) + 0.5) / grid.rows * data.sensor_height() - 0.5;
      facts_.line_of_row.push_back(of_values.line_of_row[f]);
      facts_.group_of_row.push_back(of_values.group_of_row[f]);
      facts_.time_of_row.push_back(of_values.time_of_row[f]);
      column.values.push_back(u), row.values.push_back(v);
      radius.values.push_back(effects::rho(u, v, data.sensor_width(), data.sensor_height()));
      time.values.push_back(of_values.time_of_row[f]);
      light.values.push_back(level.light());
      exposure.values.push_back(level.exposure_s);
    }
  }
  facts_.covariates = {column, row, radius, time, light, exposure};
}

Evaluation PhotometryMeans::evaluate(const Model& model, const Groups& groups,
                                     const Evaluation*) const {
  const PhotometryData& data = whole_.data;
  const PhotometrySums& sums = *whole_.sums;
  const PhotometryPrediction prediction = predict(data, sums, model, set_noise_dn_);
  Evaluation out;
  out.valid = !prediction.falls;
  if (!out.valid) return out;
  const std::vector<char> odd = outstanding_samples(
      {.data = data, .sums = sums, .set_noise_dn = set_noise_dn_, .channels_share = share_},
      prediction);
  std::vector<LevelMeans> levels;
  for (size_t l = 0; l < prediction.levels.size(); ++l)
    levels.push_back(level_means(cells_, data, prediction, l, odd));
  const std::vector<double> predicted =
      predicted_means(cells_, data, sums, prediction, levels, odd);
  auto errors = std::make_shared<const MeanErrors>(cells_, prediction.chain, std::move(levels),
                                                   level_of_frame_, share_, blank_);
  const size_t n = facts_.scalars();
  out.used.assign(n, 0), out.residual.assign(n, 0), out.sigma.assign(n, 1);
  out.log_det.assign(facts_.groups.size(), 0);
  out.nuisances = prediction.nuisances;
  for (size_t f = 0; f < data.frames.size(); ++f) {
    const std::vector<uint16_t>& image = data.images[f];
    const LevelMeans& level = errors->levels()[static_cast<size_t>(level_of_frame_[f])];
    const VectorXd sum = cells_.sums(odd, [&](size_t i) { return static_cast<double>(image[i]); });
    for (Index k = 0; k < cells_.count(); ++k) {
      const size_t i = scalar_of(f, k);
      if (!(level.sigma[k] > 0)) continue;
      out.used[i] = groups[static_cast<size_t>(facts_.group_of(i))];
      out.residual[i] = sum[k] / level.values[k] - predicted[i];
      out.sigma[i] = level.sigma[k];
    }
  }
  out.whitened = whitened(*errors, out.residual);
  out.reusable = std::move(errors);
  return out;
}

std::vector<double> PhotometryMeans::whitened(const MeanErrors& errors,
                                              const std::vector<double>& column) const {
  const Eigen::Map<const VectorXd> values(column.data(), static_cast<Index>(column.size()));
  const MatrixXd out = errors.whitened(values);
  return {out.data(), out.data() + out.size()};
}

// Spreads move no mean; what they change of the errors is no direction of the residuals.
Columns PhotometryMeans::jacobian(const Model& model, const std::vector<Unknown>& unknowns,
                                  const Groups&, const Evaluation& here) const {
  const auto& errors = *static_cast<const MeanErrors*>(here.reusable.get());
  const std::vector<double> before = predicted_means(quick_cells_, quick_, model, set_noise_dn_);
  Columns columns;
  for (const Unknown& unknown : unknowns) {
    const effects::ModelEffect& effect = *model.find(unknown.effect);
    const auto& parameter = effect.definition->parameters[unknown.parameter];
    const double value = effect.parameters[unknown.parameter].value;
    const double h = small_step(parameter, value);
    Model moved = model;
    moved.set_value(unknown.effect, unknown.parameter, value + h);
    std::vector<double> change = predicted_means(quick_cells_, quick_, moved, set_noise_dn_);
    for (size_t i = 0; i < change.size(); ++i)
      change[i] = here.used[i] ? (before[i] - change[i]) / h : 0;
    columns.push_back(whitened(errors, change));
  }
  return columns;
}

Columns PhotometryMeans::following(const Model&, const Groups&, const Evaluation& here,
                                   Columns columns) const {
  const auto& errors = *static_cast<const MeanErrors*>(here.reusable.get());
  const auto n = static_cast<Index>(facts_.scalars()), count = static_cast<Index>(columns.size());
  MatrixXd in_dn(n, count);
  for (Index k = 0; k < count; ++k) {
    for (Index i = 0; i < n; ++i) {
      const auto scalar = static_cast<size_t>(i);
      in_dn(i, k) = columns[static_cast<size_t>(k)][scalar] * here.sigma[scalar];
    }
  }
  const MatrixXd out = errors.whitened(in_dn);
  for (Index k = 0; k < count; ++k)
    std::copy(out.col(k).begin(), out.col(k).end(), columns[static_cast<size_t>(k)].begin());
  return columns;
}

std::vector<FieldPlace> PhotometryMeans::field_places(const Model&, const Evaluation& here) const {
  const auto& errors = *static_cast<const MeanErrors*>(here.reusable.get());
  const PhotometryData& data = whole_.data;
  const Covariate &column = facts_.covariates[0], &row = facts_.covariates[1],
                  &radius = facts_.covariates[2], &time = facts_.covariates[3];
  const double span = data.frames.back().time_s - data.frames.front().time_s;
  double longest = 0;
  for (const PhotometryLevel& level : data.levels) longest = std::max(longest, level.exposure_s);
  std::vector<double> light(facts_.scalars(), 0), grows = light, glows = light;
  for (size_t f = 0; f < data.frames.size(); ++f) {
    const LevelMeans& level = errors.levels()[static_cast<size_t>(level_of_frame_[f])];
    const double after = span > 0 ? (data.frames[f].time_s - data.frames.front().time_s) / span : 0;
    const double exposure = data.levels[static_cast<size_t>(level_of_frame_[f])].exposure_s;
    for (Index k = 0; k < cells_.count(); ++k) {
      const size_t i = scalar_of(f, k);
      if (!here.used[i]) continue;
      light[i] = level.gain_slope[k] / here.sigma[i];
      grows[i] = light[i] * after;
      if (longest > 0) glows[i] = level.offset_slope[k] / here.sigma[i] * exposure / longest;
    }
  }
  return {{.slopes = {std::move(light)}, .covariates = {column, row, radius, time}},
          {.slopes = {std::move(grows)}, .covariates = {column, row}, .part = "time"},
          {.slopes = {std::move(glows)}, .covariates = {column, row}, .part = "exposure_s"}};
}

}  // namespace seam::measurement
