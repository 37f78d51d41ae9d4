#include "measurement/kinds/photometry/likelihood/photometry_likelihood.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/imaging/sensor_response.h"
#include "measurement/kinds/photometry/likelihood/photometry_changes.h"
#include "measurement/kinds/photometry/likelihood/photometry_rows.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

// Variance below which a value is certain, DN^2.
constexpr double kCertain = 2e-3;

// Means over time of every sample, with fixed patterns as random effects.
class PatternPart {
 public:
  PatternPart(const PhotometryData& data, const PhotometrySums& sums,
              const PhotometryPrediction& prediction, bool share)
      : data_(data),
        sums_(sums),
        prediction_(prediction),
        chain_(prediction.chain),
        share_(share),
        rows_(data, sums, share) {
    lamps_ = prediction.chain.lamp_sigma > 0;
    for (size_t l = 0; l < sums.levels.size(); ++l) {
      if (!sums.levels[l].frames.empty()) present_.push_back(l);
    }
    const size_t count = present_.size();
    for (auto* v : {&r_, &inverse_, &solved_, &slope_, &column_}) v->resize(count);
    loads_.resize(count);
  }

  Quadratic run() {
    if (!has_patterns() && !lamps_) return plain();
    structured_ = chain_.row_sigma_dn > 0 || chain_.column_sigma_dn > 0;
    if (chain_.hot_fraction > 0 || chain_.weak_fraction > 0) choose_odd();
    if (lamps_ && !structured_) {
      lamp_score_.assign(present_.size(), 0);
      lamp_precision_.assign(present_.size() * present_.size(), 0);
    }
    each_sample([&](size_t i, int v, int, int c) { add_sample(i, v, c); });
    if (chain_.column_sigma_dn > 0) add_columns();
    if (structured_) {
      rows_.add(chain_, total_);
    } else if (lamps_) {
      add_lamps_to_means(sums_, chain_.lamp_sigma, lamp_score_, lamp_precision_, total_);
    }
    return total_;
  }

 private:
  template <typename F>
  void each_sample(F&& f) const {
    size_t i = 0;
    for (int v = 0; v < data_.height_px; ++v) {
      for (int u = 0; u < data_.width_px; ++u) {
        for (int c = 0; c < data_.channels; ++c, ++i) f(i, v, u, c);
      }
    }
  }

  bool has_patterns() const {
    return chain_.has_pixel_patterns() || chain_.hot_fraction > 0 || chain_.weak_fraction > 0 ||
           chain_.row_sigma_dn > 0 || chain_.column_sigma_dn > 0;
  }

  Quadratic plain() const {
    Quadratic total;
    for (const size_t l : present_) {
      const LevelSums& sum = sums_.levels[l];
      const LevelPrediction& level = prediction_.levels[l];
      double chi2 = 0;
      for (size_t i = 0; i < sum.mean.size(); ++i) {
        const double r = sum.mean[i] - level.mean[i];
        chi2 += r * r / level.variance[i];
      }
      total.chi2 += chi2 * static_cast<double>(sum.frames.size());
    }
    return total;
  }

  void load_sample(size_t i) {
    for (size_t k = 0; k < present_.size(); ++k) {
      const LevelSums& sum = sums_.levels[present_[k]];
      const LevelPrediction& level = prediction_.levels[present_[k]];
      r_[k] = residual(k, i);
      inverse_[k] = static_cast<double>(sum.frames.size()) / level.variance[i];
      slope_[k] = level.offset_slope[i];
      loads_[k] = pattern_loads(chain_, data_.levels[present_[k]], level.offset_slope[i],
                                level.gain_slope[i]);
    }
  }

  PatternInverse effects_of_sample() const {
    if (!chain_.has_pixel_patterns()) return {};
    return pattern_inverse(loads_.data(), inverse_.data(), present_.size());
  }

  // out = Sigma^-1 x of this sample; returns x' Sigma^-1 x.
  double solve(const PatternInverse& patterns, const std::vector<double>& x,
               std::vector<double>& out) const {
    PatternLoads b = PatternLoads::Zero();
    for (size_t k = 0; k < x.size(); ++k) b += inverse_[k] * x[k] * loads_[k];
    const PatternLoads e = patterns.core * b;
    double sum = 0;
    for (size_t k = 0; k < x.size(); ++k) {
      out[k] = inverse_[k] * (x[k] - loads_[k].dot(e));
      sum += out[k] * x[k];
    }
    return sum;
  }

  void add_sample(size_t i, int v, int c) {
    load_sample(i);
    const size_t count = present_.size();
    const PatternInverse patterns = effects_of_sample();
    total_.chi2 += solve(patterns, r_, solved_);
    total_.log_det += patterns.log_det;
    if (!structured_) {
      if (lamps_) add_to_lamps(i, patterns);
      return;
    }
    const size_t unit = rows_.unit(v, c);
    double* score = rows_.score(unit);
    double* precision = rows_.precision(unit);
    for (size_t k = 0; k < count; ++k) {
      rows_.add_slopes(unit, k, 1, prediction_.levels[present_[k]].gain_slope[i], slope_[k]);
      score[k] += slope_[k] * solved_[k];
      precision[k * count + k] += slope_[k] * slope_[k] * inverse_[k];
      const PatternLoads e = inverse_[k] * (patterns.core * loads_[k]);
      if (e.isZero(0)) continue;
      for (size_t l = 0; l < count; ++l)
        precision[k * count + l] -= slope_[k] * slope_[l] * inverse_[l] * loads_[l].dot(e);
    }
  }

  // A sample is hot or weak where that is likelier; its residual is then taken from that mean.
  void choose_odd() {
    const double share[3] = {1 - chain_.hot_fraction - chain_.weak_fraction, chain_.hot_fraction,
                             chain_.weak_fraction};
    is_odd_.assign(data_.samples(), 0);
    for (size_t i = 0; i < is_odd_.size(); ++i) {
      size_t best = 0;
      double highest = -std::numeric_limits<double>::infinity();
      for (size_t kind = 0; kind < 3; ++kind) {
        if (kind > 0 && !(share[kind] > 0)) continue;
        is_odd_[i] = static_cast<char>(kind);
        load_sample(i);
        const double here =
            -0.5 * solve(effects_of_sample(), r_, solved_) + std::log(std::max(share[kind], 1e-6));
        if (here > highest) highest = here, best = kind;
      }
      is_odd_[i] = static_cast<char>(best);
      total_.log_det -= 2 * std::log(std::max(share[best], 1e-6));
    }
  }

  double residual(size_t k, size_t i) const {
    const LevelPrediction& level = prediction_.levels[present_[k]];
    const char kind = is_odd_.empty() ? 0 : is_odd_[i];
    const double mean = kind == 1   ? level.hot_mean[i]
                        : kind == 2 ? level.weak_mean[i]
                                    : level.mean[i];
    return sums_.levels[present_[k]].mean[i] - mean;
  }

  // Of sample i, which is loaded and solved.
  void add_to_lamps(size_t i, const PatternInverse& patterns) {
    const size_t count = present_.size();
    for (size_t k = 0; k < count; ++k) {
      const double g = prediction_.levels[present_[k]].gain_slope[i];
      lamp_score_[k] += g * solved_[k];
      lamp_precision_[k * count + k] += g * g * inverse_[k];
      const PatternLoads e = g * inverse_[k] * (patterns.core * loads_[k]);
      if (e.isZero(0)) continue;
      for (size_t l = 0; l < count; ++l)
        lamp_precision_[k * count + l] -=
            prediction_.levels[present_[l]].gain_slope[i] * inverse_[l] * loads_[l].dot(e);
    }
  }

  // Beside what their rows have in common.
  void add_columns() {
    struct Column {
      double info = 0, score = 0;
    };
    const double variance = chain_.column_sigma_dn * chain_.column_sigma_dn;
    std::vector<Column> columns(static_cast<size_t>(data_.width_px) *
                                (share_ ? 1 : data_.channels));
    std::vector<double> offset;
    each_sample([&](size_t i, int v, int u, int c) {
      if (u == 0 && (c == 0 || !share_)) {
        if (c == 0) offset.clear();
        const auto own = rows_.estimate(rows_.unit(v, c));
        offset.insert(offset.end(), own.begin(), own.end());
      }
      load_sample(i);
      Column& column = columns[share_ ? u : static_cast<size_t>(u) * data_.channels + c];
      column.info += solve(effects_of_sample(), slope_, column_);
      const double* own = &offset[share_ ? 0 : c * present_.size()];
      for (size_t k = 0; k < column_.size(); ++k)
        column.score += column_[k] * (r_[k] - slope_[k] * own[k]);
    });
    // Their mean over columns is taken with the rows.
    const double share = (data_.width_px - 1.0) / data_.width_px;
    for (const Column& column : columns) {
      const double info = variance * column.info;
      total_.chi2 -= variance * column.score * column.score / (1 + info);
      total_.log_det += share * std::log1p(info);
    }
  }

  const PhotometryData& data_;
  const PhotometrySums& sums_;
  const PhotometryPrediction& prediction_;
  const effects::SensorChain& chain_;
  bool share_;
  bool structured_ = false;
  std::vector<size_t> present_;  // Levels with frames.
  std::vector<double> r_, inverse_, solved_, slope_, column_;
  std::vector<PatternLoads> loads_;
  std::vector<char> is_odd_;  // By sample: 0, 1 hot, 2 weak; empty: none is.
  bool lamps_ = false;
  std::vector<double> lamp_score_, lamp_precision_;
  RowOffsets rows_;
  Quadratic total_;
};

}  // namespace

CertainValues::CertainValues(const PhotometryData& data, const effects::SensorChain& chain)
    : chain_(chain),
      file_bits_(data.file_bits),
      least_at_top_dn2_(data.least_at_top_dn2),
      least_at_bottom_dn2_(data.least_at_bottom_dn2) {}

bool CertainValues::is_certain(double mean, double variance) const {
  if (variance < kCertain) return true;
  const bool at_bottom = mean * mean < least_at_bottom_dn2_;
  return (variance < 1.001 * least_at_top_dn2_ && is_near_top(chain_, file_bits_, mean)) ||
         (variance < 1.001 * least_at_bottom_dn2_ && at_bottom);
}

bool CertainValues::fits(double mean, double square) const {
  const double least =
      is_near_top(chain_, file_bits_, mean) ? least_at_top_dn2_ : least_at_bottom_dn2_;
  return square < std::max(kCertain, 0.1 * least);
}

bool set_likelihood(const Quadratic& total, bool falls, const PhotometrySums& sums,
                    PhotometryScore& score) {
  if (falls || !(total.chi2 >= 0)) {
    score.chi2 = std::numeric_limits<double>::quiet_NaN();
    score.log_likelihood = -std::numeric_limits<double>::infinity();
    return false;
  }
  score.chi2 = total.chi2;
  score.log_likelihood = -0.5 * (total.chi2 + total.log_det +
                                 static_cast<double>(sums.values) * std::log(2 * maths::kPi));
  return true;
}

PhotometryScore score_photometry(const PhotometryData& data, const PhotometrySums& sums,
                                 const PhotometryPrediction& prediction, bool channels_share) {
  PhotometryScore score{.values = sums.values, .nuisances = prediction.nuisances};
  score.by_frame.assign(data.frames.size(), 0);
  const bool share = channels_share || data.channels == 1;
  TemporalPart temporal(data, prediction, share);
  const CertainValues certain(data, prediction.chain);
  Quadratic total;
  double frames = 0;
  for (size_t l = 0; l < sums.levels.size(); ++l) {
    const LevelSums& sum = sums.levels[l];
    if (sum.frames.empty()) continue;
    const Quadratic part = temporal.add(sum, prediction.levels[l], score.by_frame);
    total.chi2 += part.chi2;
    total.log_det += part.log_det;
    const auto count = static_cast<double>(sum.frames.size());
    frames += count;
    // log det of the means' variances s^2 / F and of the contrasts' s^2 differ from that of the
    // values by constants, which cancel between models.
    for (size_t i = 0; i < sum.mean.size(); ++i) {
      const double r = sum.mean[i] - prediction.levels[l].mean[i];
      if (certain.is_certain(prediction.levels[l].mean[i], prediction.levels[l].variance[i]) &&
          certain.fits(prediction.levels[l].mean[i], r * r + sum.scatter[i] / count))
        score.values -= static_cast<int64_t>(sum.frames.size());
      score.square += count * r * r + sum.scatter[i];
    }
    for (const int frame : sum.frames) {
      for (size_t row = 0; row < data.rows(); ++row) {
        const double d = data.row_mean[frame][row] - sum.row_mean[row];
        score.square += data.width_px * d * d;
      }
    }
  }
  const Quadratic pattern = PatternPart(data, sums, prediction, share).run();
  total.chi2 += pattern.chi2;
  total.log_det += pattern.log_det;
  if (!set_likelihood(total, prediction.falls, sums, score)) return score;
  double assigned = 0;
  for (const double own : score.by_frame) assigned += own;
  for (const LevelSums& sum : sums.levels) {
    for (const int frame : sum.frames)
      score.by_frame[frame] += (score.log_likelihood - assigned) / frames;
  }
  return score;
}

}  // namespace seam::measurement
