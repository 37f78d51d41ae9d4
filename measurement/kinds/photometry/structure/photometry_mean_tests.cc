#include "measurement/kinds/photometry/structure/photometry_mean_tests.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "effects/stages/geometry.h"
#include "measurement/kinds/photometry/likelihood/photometry_rows.h"
#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Of sample i at level l.
PatternLoads loads_of(const PhotometryData& data, const PhotometryPrediction& prediction, size_t l,
                      size_t i) {
  const LevelPrediction& level = prediction.levels[l];
  return pattern_loads(prediction.chain, data.levels[l], level.offset_slope[i],
                       level.gain_slope[i]);
}

}  // namespace

SamplePlace place_of(const PhotometryData& data, size_t level, int u, int v, int channel) {
  const auto centred = [](double x, int n) { return n > 1 ? 2 * x / (n - 1) - 1 : 0.0; };
  return {level,
          u,
          v,
          channel,
          centred(data.column(u), data.sensor_width()),
          centred(data.row(v), data.sensor_height()),
          effects::rho(data.column(u), data.row(v), data.sensor_width(), data.sensor_height())};
}

std::vector<char> outstanding_samples(const PhotometryView& view,
                                      const PhotometryPrediction& prediction) {
  const auto& chain = prediction.chain;
  if (chain.hot_fraction <= 0 && chain.weak_fraction <= 0) return {};
  std::vector<char> outstanding(view.data.samples(), 0);
  for (size_t i = 0; i < outstanding.size(); ++i) {
    double cold = 0, hot = 0, weak = 0;
    for (size_t l = 0; l < prediction.levels.size(); ++l) {
      const LevelSums& sum = view.sums.levels[l];
      if (sum.frames.empty()) continue;
      const LevelPrediction& level = prediction.levels[l];
      const double w = 1 / (level.variance[i] / static_cast<double>(sum.frames.size()) +
                            loads_of(view.data, prediction, l, i).squaredNorm());
      const double r = sum.mean[i] - level.mean[i];
      const auto square_from = [&](const std::vector<double>& mean) {
        if (mean.empty()) return std::numeric_limits<double>::infinity();
        const double own = r - (mean[i] - level.mean[i]);
        return w * own * own;
      };
      cold += w * r * r, hot += square_from(level.hot_mean), weak += square_from(level.weak_mean);
    }
    outstanding[i] = std::min(hot, weak) < cold;
  }
  return outstanding;
}

double small_step(const effects::Parameter& parameter, double value) {
  double h = 1e-3 * std::max(std::isfinite(parameter.scale) ? parameter.scale : 1, std::abs(value));
  if (parameter.name == "frequency_hz") h = 1e-4;
  return value + h > parameter.max ? -h : h;
}

MeanTests::MeanTests(const PhotometryView& view, const Model& model)
    : view_(view),
      data_(view.data),
      prediction_(predict(data_, view.sums, model, view.set_noise_dn)) {
  for (const auto& effect : model.effects()) {
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      const auto& parameter = effect.definition->parameters[i];
      if (!effect.parameters[i].refitted() || parameter.integer) continue;
      add_direction(model, effect.definition->name, i, effect.parameters[i].value, parameter);
    }
  }
  outstanding_ = outstanding_samples(view, prediction_);
}

StructureTest MeanTests::run(const std::string& covariate, int count,
                             const PlaceBasis& basis) const {
  const auto fitted = static_cast<Eigen::Index>(directions_.size());
  const Eigen::Index n = count + fitted;
  VectorXd statistic = VectorXd::Zero(n), b = VectorXd::Zero(n), own(n), offset(n);
  MatrixXd patterns(n, 3), covariance = MatrixXd::Zero(n, n), gram = MatrixXd::Zero(n, n);
  const auto& chain = prediction_.chain;
  std::vector<VectorXd> columns(chain.column_sigma_dn > 0 ? data_.width_px : 0, VectorXd::Zero(n));
  const double row2 = chain.row_sigma_dn * chain.row_sigma_dn;
  std::vector<VectorXd> rows(row2 > 0 ? view_.sums.levels.size() : 0, VectorXd::Zero(n));
  const double lamp2 = chain.lamp_sigma * chain.lamp_sigma;
  std::vector<VectorXd> lamps(lamp2 > 0 ? view_.sums.levels.size() : 0, VectorXd::Zero(n));
  double weights = 0;
  size_t i = 0;
  for (int v = 0; v < data_.height_px; ++v) {
    for (auto& row : rows) row.setZero();
    for (int u = 0; u < data_.width_px; ++u) {
      for (int c = 0; c < data_.channels; ++c, ++i) {
        if (!outstanding_.empty() && outstanding_[i]) continue;
        offset.setZero(), patterns.setZero();
        for (size_t l = 0; l < view_.sums.levels.size(); ++l) {
          const LevelSums& sum = view_.sums.levels[l];
          if (sum.frames.empty()) continue;
          const LevelPrediction& level = prediction_.levels[l];
          const double own2 = level.variance[i] / static_cast<double>(sum.frames.size());
          const PatternLoads loads = loads_of(data_, prediction_, l, i);
          const double w = 1 / (own2 + loads.squaredNorm());
          const SamplePlace place = place_of(data_, l, u, v, c);
          own.setZero();
          VectorXd& features = b;
          features.setZero();
          basis(place, level.gain_slope[i], features);
          for (Eigen::Index k = 0; k < fitted; ++k) features[count + k] = directions_[k][l][i];
          statistic += w * residual(l, i) * features;
          gram.selfadjointView<Eigen::Lower>().rankUpdate(features, w);
          covariance.selfadjointView<Eigen::Lower>().rankUpdate(features, w * w * own2);
          weights += w;
          if (!columns.empty()) offset += w * level.offset_slope[i] * features;
          if (chain.has_pixel_patterns()) patterns += w * features * loads.transpose();
          if (!rows.empty()) rows[l] += w * level.offset_slope[i] * features;
          if (!lamps.empty()) lamps[l] += w * level.gain_slope[i] * features;
        }
        if (chain.has_pixel_patterns())
          covariance.selfadjointView<Eigen::Lower>().rankUpdate(patterns);
        if (!columns.empty()) columns[u] += offset;
      }
    }
    for (size_t l = 0; l < rows.size(); ++l) {
      if (view_.sums.levels[l].frames.empty()) continue;
      covariance.selfadjointView<Eigen::Lower>().rankUpdate(
          rows[l], row2 / static_cast<double>(view_.sums.levels[l].frames.size()));
    }
  }
  for (size_t l = 0; l < lamps.size(); ++l) {
    if (view_.sums.levels[l].frames.empty()) continue;
    covariance.selfadjointView<Eigen::Lower>().rankUpdate(
        lamps[l], lamp2 / static_cast<double>(view_.sums.levels[l].frames.size()));
  }
  for (const VectorXd& column : columns) {
    covariance.selfadjointView<Eigen::Lower>().rankUpdate(
        column, chain.column_sigma_dn * chain.column_sigma_dn);
  }
  const MatrixXd full_gram = gram.selfadjointView<Eigen::Lower>();
  const MatrixXd full_covariance = covariance.selfadjointView<Eigen::Lower>();
  return reduce(covariate, count, statistic, full_covariance, full_gram, weights);
}

void MeanTests::add_direction(const Model& model, const std::string& effect, size_t index,
                              double value, const effects::Parameter& parameter) {
  Model moved = model;
  const double h = small_step(parameter, value);
  moved.set_value(effect, index, value + h);
  const auto other = predict(data_, view_.sums, moved, view_.set_noise_dn);
  std::vector<std::vector<double>> direction(prediction_.levels.size());
  double size = 0;
  for (size_t l = 0; l < direction.size(); ++l) {
    for (size_t i = 0; i < prediction_.levels[l].mean.size(); ++i) {
      direction[l].push_back((other.levels[l].mean[i] - prediction_.levels[l].mean[i]) / h);
      size += direction[l].back() * direction[l].back();
    }
  }
  if (!(size > 0)) return;
  const double scale = std::sqrt(static_cast<double>(data_.samples()) / size);
  for (auto& level : direction) {
    for (double& d : level) d *= scale;
  }
  directions_.push_back(std::move(direction));
}

StructureTest MeanTests::reduce(const std::string& covariate, int count, const VectorXd& statistic,
                                const MatrixXd& covariance, const MatrixXd& gram,
                                double weights) const {
  const Eigen::Index fitted = statistic.size() - count;
  MatrixXd transform = MatrixXd::Zero(count, statistic.size());
  transform.leftCols(count).setIdentity();
  if (fitted > 0) {
    const MatrixXd normal = gram.bottomRightCorner(fitted, fitted);
    transform.rightCols(fitted) =
        -solve_any_rank(normal, gram.bottomLeftCorner(fitted, count)).transpose();
  }
  const VectorXd t = transform * statistic;
  const MatrixXd c = transform * covariance * transform.transpose();
  const auto [chi2, freedom] = chi2_of(t, c, covariance.diagonal().head(count));
  const MatrixXd g = transform * gram * transform.transpose();
  // Explained mean square, without what noise alone explains.
  const MatrixXd inverse = pseudo_inverse(g);
  const double square =
      std::max(0.0, t.dot(inverse * t) - (inverse * c).trace()) / std::max(weights, 1e-300);
  StructureTest test{.chi2 = chi2, .freedom = freedom};
  test.structure = {
      .residual = "dn", .moment = "mean", .covariate = covariate, .strength = std::sqrt(square)};
  return test;
}

}  // namespace seam::measurement
