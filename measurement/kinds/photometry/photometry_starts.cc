#include "measurement/kinds/photometry/photometry_starts.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "effects/questions.h"
#include "effects/registry.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/robust.h"

namespace seam::measurement {
namespace {

using Values = std::vector<double>;

std::shared_ptr<const EffectDefinition> shared(const EffectDefinition& effect) {
  if (auto known = effects::find_effect(effect.name)) return known;
  return std::make_shared<const EffectDefinition>(effect);
}

Model with(const Model& model, const EffectDefinition& effect, const Values& values) {
  std::vector<effects::ParameterValue> given;
  for (const double value : values) given.push_back({.value = value});
  Model out = model;
  out.set(shared(effect), std::move(given));
  return out;
}

// What fixed patterns leave of the levels' squared residuals: a part that is the same at each and
// one in proportion to the square of the gain. Levels count by how well they are known: unweighted,
// what the brightest leave by their gain would be that of the dark.
class PatternParts {
 public:
  void add(double left, double gain2, double square) {
    const double w = 1 / std::max(square * square, 1e-12);
    w_ += w, x_ += w * gain2, y_ += w * left, xx_ += w * gain2 * gain2, xy_ += w * gain2 * left;
  }
  // Of the dark; nothing where the levels do not tell the two apart, or leave none.
  std::optional<double> dark() const {
    const double across = w_ * xx_ - x_ * x_;
    if (!(across > 1e-6 * w_ * xx_)) return std::nullopt;
    const double dark = (xx_ * y_ - x_ * xy_) / across;
    return dark > 0 ? std::optional(dark) : std::nullopt;
  }

 private:
  double w_ = 0, x_ = 0, y_ = 0, xx_ = 0, xy_ = 0;
};

// Moments of the residuals, summed over levels and samples.
effects::SensorExcess excess_of(const PhotometryView& view,
                                const PhotometryPrediction& prediction) {
  effects::SensorExcess out;
  const PhotometryData& data = view.data;
  double n = 0, xy = 0, xx = 0, x = 0, po = 0, pg = 0, pgg = 0, count = 0;
  double row_sum = 0, row_count = 0, column_sum = 0, column_count = 0;
  PatternParts patterns;
  for (size_t l = 0; l < view.sums.levels.size(); ++l) {
    const LevelSums& sum = view.sums.levels[l];
    const LevelPrediction& level = prediction.levels[l];
    const auto frames = static_cast<double>(sum.frames.size());
    if (frames == 0) continue;
    std::vector<double> column(static_cast<size_t>(data.width_px), 0);
    double variance = 0, left_here = 0, gain2_here = 0, square_here = 0;
    for (size_t i = 0; i < sum.mean.size(); ++i) {
      const double r = sum.mean[i] - level.mean[i];
      // Without noise the file's steps hide the slope: then it is that of the light.
      const double signal = std::max(0.0, level.mean[i] - prediction.chain.black_dn);
      const double gain = level.gain_slope[i] > 0 ? level.gain_slope[i] : signal;
      const double g2 = gain * gain, shot = gain * data.levels[l].gain;
      const double left = r * r - level.variance[i] / frames;
      left_here += left, gain2_here += g2, square_here += r * r;
      po += left, pg += left * g2, pgg += g2 * g2, count += 1;
      column[i / data.channels % data.width_px] += r / (data.height_px * data.channels);
      variance += level.variance[i];
      if (frames < 2) continue;
      const double v =
          sum.scatter[i] / ((frames - 1) * (1 - 1.0 / data.width_px)) - level.variance[i];
      n += 1, out.temporal_dn2 += v, xy += v * shot, xx += shot * shot, x += shot;
    }
    const auto samples = static_cast<double>(sum.mean.size());
    patterns.add(left_here / samples, gain2_here / samples, square_here / samples);
    variance /= samples;
    for (const double c : column)
      column_sum += c * c - variance / (frames * data.height_px * data.channels);
    column_count += data.width_px;
    for (size_t f = 0; f < sum.frames.size() && frames > 1; ++f) {
      for (size_t row = 0; row < data.rows(); ++row) {
        const double d =
            data.row_mean[sum.frames[f]][row] - sum.row_mean[row] - level.row_shift[f][row];
        row_sum += d * d * frames / (frames - 1) - variance / data.width_px;
        row_count += 1;
      }
    }
  }
  if (n > 0) out.temporal_dn2 /= n;
  if (xx > 0) out.per_signal_dn = xy / xx;
  // A noise in the dark that is told too wide, since it stands for this one, leaves a slope all the
  // same.
  const double across = n > 0 ? xx - x * x / n : 0;
  if (across > 1e-6 * xx)
    out.per_signal_dn = std::max(out.per_signal_dn, (xy - x * out.temporal_dn2) / across);
  if (count > 0) out.pattern_dn2 = patterns.dark().value_or(po / count);
  if (pgg > 0) out.pattern_of_gain = pg / pgg;
  if (row_count > 0) out.row_dn2 = row_sum / row_count;
  if (column_count > 0) out.column_dn2 = column_sum / column_count;
  return out;
}

// Straight from neutral: the least-squares step of the parameters on which the mean depends.
Values linear_start(const PhotometryView& view, const Model& model, const EffectDefinition& effect,
                    const PhotometryPrediction& base) {
  Values neutral;
  for (const auto& p : effect.parameters) neutral.push_back(p.neutral);
  const auto n = static_cast<Eigen::Index>(neutral.size());
  std::vector<PhotometryPrediction> moved;
  Values step;
  for (size_t k = 0; k < neutral.size(); ++k) {
    const auto& p = effect.parameters[k];
    double h = 1e-3 * p.scale;
    if (p.neutral + h > p.max) h = -h;
    Values values = neutral;
    values[k] += h;
    step.push_back(h);
    moved.push_back(predict(view.data, view.sums, with(model, effect, values), view.set_noise_dn));
  }
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n), slope(n);
  for (size_t l = 0; l < base.levels.size(); ++l) {
    const LevelSums& sum = view.sums.levels[l];
    for (size_t i = 0; i < sum.mean.size(); ++i) {
      const double w = static_cast<double>(sum.frames.size()) / base.levels[l].variance[i];
      for (Eigen::Index k = 0; k < n; ++k)
        slope[k] = (moved[k].levels[l].mean[i] - base.levels[l].mean[i]) / step[k];
      normal.noalias() += w * slope * slope.transpose();
      right += w * (sum.mean[i] - base.levels[l].mean[i]) * slope;
    }
  }
  for (Eigen::Index k = 0; k < n; ++k) normal(k, k) += 1e-9 * normal(k, k) + 1e-30;
  const Eigen::VectorXd solution = solve_symmetric(normal, right);
  Values start = neutral;
  for (size_t k = 0; k < neutral.size(); ++k) {
    const auto& p = effect.parameters[k];
    double value = p.neutral + solution[static_cast<Eigen::Index>(k)];
    if (!std::isfinite(value)) value = p.neutral;
    start[k] = std::clamp(value, p.min, p.max);
  }
  return start;
}

Values best_of(const PhotometryView& view, const Model& model, const EffectDefinition& effect,
               const std::vector<Values>& choices) {
  double best = -std::numeric_limits<double>::infinity();
  Values chosen = choices.front();
  for (const Values& values : choices) {
    const double here = log_likelihood(view, with(model, effect, values));
    if (here > best) best = here, chosen = values;
  }
  return chosen;
}

std::vector<Values> full_choices(const PhotometryView& view,
                                 const PhotometryPrediction& prediction) {
  double top = 0, low = 1e300;
  for (const LevelSums& sum : view.sums.levels) {
    for (const double mean : sum.mean) top = std::max(top, mean), low = std::min(low, mean);
  }
  double highest = 0;
  for (const auto& level : prediction.levels) {
    for (const double mean : level.mean) highest = std::max(highest, mean);
  }
  std::vector<Values> choices;
  for (int i = 0; i <= 16; ++i)
    choices.push_back({std::max(0.6, low + (std::max(top, 1.0) - low) * (0.4 + 0.6 * i / 16))});
  for (const double above : {0.5, 1.0, 2.0, 4.0, 8.0}) choices.push_back({top + above});
  return choices;
}

// The likeliest of an effect's shapes, each as large as the residual means ask for.
Values best_shape(const PhotometryView& view, const Model& model, const EffectDefinition& effect,
                  const PhotometryPrediction& base, std::vector<Values> shapes) {
  for (Values& shape : shapes) {
    const PhotometryPrediction moved =
        predict(view.data, view.sums, with(model, effect, shape), view.set_noise_dn);
    double slope2 = 0, slope_residual = 0;
    for (size_t l = 0; l < base.levels.size(); ++l) {
      const LevelSums& sum = view.sums.levels[l];
      for (size_t i = 0; i < sum.mean.size(); ++i) {
        const double w = static_cast<double>(sum.frames.size()) / base.levels[l].variance[i];
        const double slope = moved.levels[l].mean[i] - base.levels[l].mean[i];
        slope2 += w * slope * slope;
        slope_residual += w * slope * (sum.mean[i] - base.levels[l].mean[i]);
      }
    }
    const effects::Parameter& size = effect.parameters.front();
    if (slope2 > 0)
      shape.front() = std::clamp(shape.front() * slope_residual / slope2, size.min, size.max);
  }
  return best_of(view, model, effect, shapes);
}

// Samples that stand out of the residual means: their share, and how far out they are in DN or, for
// those of another gain, relative to the light.
struct Outstanding {
  double share = 0, size = 0;
};
Outstanding outstanding(const PhotometryView& view, const PhotometryPrediction& prediction,
                        bool of_gain) {
  std::vector<double> residual(view.data.samples(), 0), weight(view.data.samples(), 0);
  for (size_t l = 0; l < prediction.levels.size(); ++l) {
    const LevelSums& sum = view.sums.levels[l];
    const LevelPrediction& level = prediction.levels[l];
    for (size_t i = 0; i < sum.mean.size(); ++i) {
      const double w = static_cast<double>(sum.frames.size()) / level.variance[i];
      const double slope = of_gain ? level.gain_slope[i] : 1;
      residual[i] += w * slope * (sum.mean[i] - level.mean[i]);
      weight[i] += w * slope * slope;
    }
  }
  for (size_t i = 0; i < residual.size(); ++i) residual[i] /= std::max(weight[i], 1e-300);
  const double centre = median_of(residual);
  std::vector<double> from_centre = residual, high;
  for (double& r : from_centre) r -= centre;
  const double sigma = robust_sigma(from_centre);
  for (const double r : from_centre) {
    const bool odd = of_gain ? r < -6 * sigma : std::abs(r) > 6 * sigma;
    if (odd) high.push_back(r + centre);
  }
  const auto all = static_cast<double>(residual.size());
  if (high.empty()) return {1 / all, of_gain ? -0.3 : 20};
  return {std::min(static_cast<double>(high.size()) / all, 0.1), median_of(high)};
}

Values odd_start(const PhotometryView& view, const Model& model, const EffectDefinition& effect) {
  const bool of_gain = effects::sensor_of(with(model, effect, {0.01, 0.5})).weak_fraction > 0;
  const auto prediction = predict(view.data, view.sums, model, view.set_noise_dn);
  const Outstanding odd = outstanding(view, prediction, of_gain);
  return {odd.share, of_gain ? std::max(0.0, 1 + odd.size) : odd.size};
}

std::optional<double> by_cells(const PhotometryView& view, const Model& model) {
  if (view.cells == nullptr) return std::nullopt;
  return cell_log_likelihood(view.data, view.sums, *view.cells, model, view.set_noise_dn,
                             view.channels_share, view.near);
}

}  // namespace

bool cells_stand_for(const PhotometryView& view, const Model& model) {
  return by_cells(view, model).has_value();
}

double log_likelihood(const PhotometryView& view, const Model& model) {
  const double of_filter = view.log_mixing * static_cast<double>(view.sums.values);
  if (const auto fast = by_cells(view, model)) return *fast - of_filter;
  const auto prediction = predict(view.data, view.sums, model, view.set_noise_dn);
  return score_photometry(view.data, view.sums, prediction, view.channels_share).log_likelihood -
         of_filter;
}

std::optional<std::pair<double, double>> straight_response(const PhotometryView& view) {
  std::vector<std::pair<double, double>> points;
  for (size_t l = 0; l < view.data.levels.size(); ++l) {
    const PhotometryLevel& level = view.data.levels[l];
    const auto& means = view.sums.levels[l].mean;
    if (means.empty() || std::isnan(level.illumination) || level.whole.at_top > 0.005) continue;
    double sum = 0;
    for (const double mean : means) sum += mean;
    points.emplace_back(level.light(), sum / static_cast<double>(means.size()));
  }
  std::vector<double> slopes, blacks;
  for (size_t i = 0; i < points.size(); ++i) {
    for (size_t k = 0; k < i; ++k) {
      const double apart = points[i].first - points[k].first;
      if (apart != 0) slopes.push_back((points[i].second - points[k].second) / apart);
    }
  }
  if (slopes.empty()) return std::nullopt;
  const double gain = median_of(slopes);
  for (const auto& [light, mean] : points) blacks.push_back(mean - gain * light);
  if (!(gain > 0)) return std::nullopt;
  return std::pair{gain, median_of(blacks)};
}

std::vector<Values> photometry_starts(const PhotometryView& view, const PhotometryView& whole,
                                      const Model& model, const EffectDefinition& effect,
                                      const NoiseLikeness& noise) {
  const PhotometryPrediction prediction = predict(view.data, view.sums, model, view.set_noise_dn);
  const effects::StartRule& rule = effects::start_rule(effect, effects::kPhotometry);
  switch (rule.search) {
    case effects::StartSearch::frequency:
      if (effect.stage == effects::Stage::sensor) return {strongest_wave(view, prediction)};
      return flicker_starts(view, model, prediction);
    case effects::StartSearch::listed:
      return {best_of(view, model, effect, rule.values)};
    case effects::StartSearch::shapes:
      return {best_shape(view, model, effect, prediction, rule.values)};
    case effects::StartSearch::ceiling:
      return {best_of(view, model, effect, full_choices(view, prediction))};
    case effects::StartSearch::outliers:
      return {odd_start(whole, model, effect)};
    case effects::StartSearch::converter_bits: {
      std::vector<Values> choices;
      for (int bits = view.data.fewest_bits; bits < view.data.file_bits; ++bits)
        choices.push_back({static_cast<double>(bits)});
      if (choices.empty()) return {};
      return {best_of(view, model, effect, choices)};
    }
    case effects::StartSearch::excess: {
      effects::SensorExcess excess = excess_of(view, prediction);
      excess.likeness_in_row = noise.along_rows, excess.likeness_in_column = noise.along_columns;
      return {effect.start_from_excess(excess)};
    }
    default:
      break;
  }
  return {linear_start(view, model, effect, prediction)};
}

}  // namespace seam::measurement
