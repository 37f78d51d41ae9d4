// Each test projects the residual on a few smooth functions of a covariate and compares the result
// with its exact covariance under the model: sums of b' S b over the parts of S (values, samples'
// patterns, columns, rows). No inverse of S is needed, and directions that refitted parameters
// explain are projected out first, so that estimates made from the same data do not matter.
#include "measurement/kinds/photometry/photometry_structure.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>

#include "effects/stages/geometry.h"
#include "measurement/numerics/legendre.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/regression.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Test {
  Structure structure;
  double chi2 = 0;
  int freedom = 0;
};

// The chi-square of statistics T with covariance C, in the directions in which C has any size.
std::pair<double, int> chi2_of(const VectorXd& t, const MatrixXd& c, const VectorXd& reference) {
  VectorXd scale(t.size());
  for (Eigen::Index i = 0; i < t.size(); ++i)
    scale[i] = reference[i] > 0 ? 1 / std::sqrt(reference[i]) : 0;
  const MatrixXd unit = scale.asDiagonal() * c * scale.asDiagonal();
  const VectorXd s = scale.cwiseProduct(t);
  const SymmetricEigen eigen = symmetric_eigen(unit);
  double chi2 = 0;
  int freedom = 0;
  for (Eigen::Index i = 0; i < t.size(); ++i) {
    // Directions that the parameters have absorbed are rounding.
    if (eigen.values[i] < 1e-6) continue;
    const double along = eigen.vectors.col(i).dot(s);
    chi2 += along * along / eigen.values[i];
    ++freedom;
  }
  return {chi2, freedom};
}

// A place in the reduced data: a sample of a level.
struct Place {
  size_t level;
  int u, v, channel;
  double x, y, radius;  // -1 to 1, -1 to 1, 0 to 1.
};
using Basis = std::function<void(const Place&, double gain, VectorXd& out)>;

class MeanTests {
 public:
  MeanTests(const PhotometryView& view, const Model& model)
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
    find_outstanding();
  }

  const PhotometryPrediction& prediction() const { return prediction_; }

  Test run(const std::string& covariate, int count, const Basis& basis) const {
    const auto fitted = static_cast<Eigen::Index>(directions_.size());
    const Eigen::Index n = count + fitted;
    VectorXd statistic = VectorXd::Zero(n), b = VectorXd::Zero(n), own(n), offset(n), gain(n);
    MatrixXd covariance = MatrixXd::Zero(n, n), gram = MatrixXd::Zero(n, n);
    const auto& chain = prediction_.chain;
    std::vector<VectorXd> columns(chain.column_sigma_dn > 0 ? data_.width_px : 0,
                                  VectorXd::Zero(n));
    const double row2 = chain.row_sigma_dn * chain.row_sigma_dn;
    std::vector<VectorXd> rows(row2 > 0 ? view_.sums.levels.size() : 0, VectorXd::Zero(n));
    double weights = 0;
    size_t i = 0;
    for (int v = 0; v < data_.height_px; ++v) {
      for (auto& row : rows) row.setZero();
      for (int u = 0; u < data_.width_px; ++u) {
        for (int c = 0; c < data_.channels; ++c, ++i) {
          if (outstanding_[i]) continue;
          offset.setZero(), gain.setZero();
          for (size_t l = 0; l < view_.sums.levels.size(); ++l) {
            const LevelSums& sum = view_.sums.levels[l];
            if (sum.frames.empty()) continue;
            const LevelPrediction& level = prediction_.levels[l];
            const double own2 = level.variance[i] / static_cast<double>(sum.frames.size());
            const double w = weight(own2, level, i);
            const Place place = place_of(l, u, v, c);
            own.setZero();
            VectorXd& features = b;
            features.setZero();
            basis(place, level.gain_slope[i], features);
            for (Eigen::Index k = 0; k < fitted; ++k) features[count + k] = directions_[k][l][i];
            statistic += w * residual(l, i) * features;
            gram.selfadjointView<Eigen::Lower>().rankUpdate(features, w);
            covariance.selfadjointView<Eigen::Lower>().rankUpdate(features, w * w * own2);
            weights += w;
            if (chain.pixel_offset_sigma_dn > 0 || !columns.empty())
              offset += w * level.offset_slope[i] * features;
            if (chain.pixel_gain_sigma > 0) gain += w * level.gain_slope[i] * features;
            if (!rows.empty()) rows[l] += w * level.offset_slope[i] * features;
          }
          const double o2 = chain.pixel_offset_sigma_dn * chain.pixel_offset_sigma_dn;
          if (o2 > 0) covariance.selfadjointView<Eigen::Lower>().rankUpdate(offset, o2);
          const double g2 = chain.pixel_gain_sigma * chain.pixel_gain_sigma;
          if (g2 > 0) covariance.selfadjointView<Eigen::Lower>().rankUpdate(gain, g2);
          if (!columns.empty()) columns[u] += offset;
        }
      }
      for (size_t l = 0; l < rows.size(); ++l) {
        if (view_.sums.levels[l].frames.empty()) continue;
        covariance.selfadjointView<Eigen::Lower>().rankUpdate(
            rows[l], row2 / static_cast<double>(view_.sums.levels[l].frames.size()));
      }
    }
    for (const VectorXd& column : columns) {
      covariance.selfadjointView<Eigen::Lower>().rankUpdate(
          column, chain.column_sigma_dn * chain.column_sigma_dn);
    }
    const MatrixXd full_gram = gram.selfadjointView<Eigen::Lower>();
    const MatrixXd full_covariance = covariance.selfadjointView<Eigen::Lower>();
    return reduce(covariate, count, statistic, full_covariance, full_gram, weights);
  }

  Place place_of(size_t level, int u, int v, int c) const {
    const auto centred = [](double x, int n) { return n > 1 ? 2 * x / (n - 1) - 1 : 0.0; };
    return {level,
            u,
            v,
            c,
            centred(u, data_.width_px),
            centred(v, data_.height_px),
            effects::rho(u, v, data_.width_px, data_.height_px)};
  }

 private:
  double residual(size_t l, size_t i) const {
    return view_.sums.levels[l].mean[i] - prediction_.levels[l].mean[i];
  }

  double weight(double own2, const LevelPrediction& level, size_t i) const {
    const auto& chain = prediction_.chain;
    const double o = chain.pixel_offset_sigma_dn * level.offset_slope[i];
    const double g = chain.pixel_gain_sigma * level.gain_slope[i];
    return 1 / (own2 + o * o + g * g);
  }

  // Samples with a hot offset are not part of the mean's structure.
  void find_outstanding() {
    outstanding_.assign(data_.samples(), 0);
    if (prediction_.chain.hot_fraction <= 0) return;
    for (size_t i = 0; i < outstanding_.size(); ++i) {
      double cold = 0, hot = 0;
      for (size_t l = 0; l < prediction_.levels.size(); ++l) {
        if (view_.sums.levels[l].frames.empty()) continue;
        const LevelPrediction& level = prediction_.levels[l];
        const double w = weight(
            level.variance[i] / static_cast<double>(view_.sums.levels[l].frames.size()), level, i);
        const double r = residual(l, i);
        const double h = r - (level.hot_mean[i] - level.mean[i]);
        cold += w * r * r, hot += w * h * h;
      }
      outstanding_[i] = hot < cold;
    }
  }

  void add_direction(const Model& model, const std::string& effect, size_t index, double value,
                     const effects::Parameter& parameter) {
    Model moved = model;
    double h =
        1e-3 * std::max(std::isfinite(parameter.scale) ? parameter.scale : 1, std::abs(value));
    if (parameter.name == "frequency_hz") h = 1e-4;
    if (value + h > parameter.max) h = -h;
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

  Test reduce(const std::string& covariate, int count, const VectorXd& statistic,
              const MatrixXd& covariance, const MatrixXd& gram, double weights) const {
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
    Test test{.chi2 = chi2, .freedom = freedom};
    test.structure = {
        .residual = "dn", .moment = "mean", .covariate = covariate, .strength = std::sqrt(square)};
    return test;
  }

  const PhotometryView& view_;
  const PhotometryData& data_;
  PhotometryPrediction prediction_;
  std::vector<std::vector<std::vector<double>>> directions_;  // By parameter, level, sample.
  std::vector<char> outstanding_;
};

// Means of whole frames and of their rows against time, within levels.
class TimeTests {
 public:
  TimeTests(const PhotometryView& view, const PhotometryPrediction& prediction)
      : view_(view), data_(view.data), prediction_(prediction) {
    const double first = data_.frames.front().time_s;
    const double span = std::max(1e-9, data_.frames.back().time_s - first);
    for (size_t l = 0; l < view.sums.levels.size(); ++l) {
      const LevelSums& sum = view.sums.levels[l];
      if (sum.frames.size() < 2) continue;
      const LevelPrediction& level = prediction.levels[l];
      double variance = 0, gain = 0;
      for (size_t i = 0; i < level.mean.size(); ++i)
        variance += level.variance[i], gain += level.gain_slope[i];
      variance /= static_cast<double>(level.mean.size());
      gain /= static_cast<double>(level.mean.size());
      const double row2 = prediction.chain.row_sigma_dn * prediction.chain.row_sigma_dn;
      for (size_t f = 0; f < sum.frames.size(); ++f) {
        Frame frame;
        frame.level = l;
        frame.x = 2 * (data_.frames[sum.frames[f]].time_s - first) / span - 1;
        // Place among all of the level's frames, held out or not.
        const auto& all = data_.levels[l].frames;
        const auto place = std::find(all.begin(), all.end(), sum.frames[f]) - all.begin();
        frame.place =
            all.size() > 1
                ? 2.0 * static_cast<double>(place) / static_cast<double>(all.size() - 1) - 1
                : 0;
        frame.start = place == 0;
        frame.gain = gain;
        const double n = static_cast<double>(data_.height_px) * data_.channels;
        const int shared = view.channels_share ? data_.channels : 1;
        for (size_t row = 0; row < data_.rows(); ++row) {
          const double d =
              data_.row_mean[sum.frames[f]][row] - sum.row_mean[row] - level.row_shift[f][row];
          frame.rows.push_back(d);
          frame.mean += d / n;
        }
        frame.variance = (variance / data_.width_px + row2 * shared) / n;
        frame.row_variance = variance / data_.width_px + row2;
        frames_.push_back(std::move(frame));
      }
    }
  }

  // Smooth functions of time, and every frame a mean of its own.
  std::vector<Test> run() const {
    std::vector<Test> tests;
    if (frames_.empty()) return tests;
    for (const bool with_light : {false, true}) {
      const auto scale = [with_light](const Frame& frame) { return with_light ? frame.gain : 1.0; };
      tests.push_back(
          smooth(with_light ? "time*illumination" : "time", 8, [&](const Frame& f, VectorXd& b) {
            for (int k = 0; k < 5; ++k) b[k] = scale(f) * legendre(k + 1, f.x);
            for (int k = 0; k < 2; ++k) b[5 + k] = scale(f) * legendre(k + 1, f.place);
            b[7] = scale(f) * f.start;
          }));
    }
    tests.push_back(each_frame());
    tests.push_back(rows_in_time());
    return tests;
  }

 private:
  struct Frame {
    size_t level = 0;
    double x = 0, place = 0, start = 0, gain = 0, mean = 0, variance = 1, row_variance = 1;
    std::vector<double> rows;
  };

  Test smooth(const std::string& covariate, int count,
              const std::function<void(const Frame&, VectorXd&)>& basis) const {
    // Functions are centred within levels, as the residuals are.
    std::vector<VectorXd> features(frames_.size(), VectorXd::Zero(count));
    std::vector<VectorXd> centre(view_.sums.levels.size(), VectorXd::Zero(count));
    for (size_t f = 0; f < frames_.size(); ++f) {
      basis(frames_[f], features[f]);
      centre[frames_[f].level] +=
          features[f] / static_cast<double>(view_.sums.levels[frames_[f].level].frames.size());
    }
    VectorXd t = VectorXd::Zero(count);
    MatrixXd c = MatrixXd::Zero(count, count), reference = c;
    double weights = 0;
    for (size_t f = 0; f < frames_.size(); ++f) {
      const VectorXd b = features[f] - centre[frames_[f].level];
      const double w = 1 / frames_[f].variance;
      t += w * frames_[f].mean * b;
      c += w * b * b.transpose();
      reference += w * features[f] * features[f].transpose();
      weights += w;
    }
    const auto [chi2, freedom] = chi2_of(t, c, reference.diagonal());
    Test test{.chi2 = chi2, .freedom = freedom};
    test.structure = {.residual = "dn",
                      .moment = "mean",
                      .covariate = covariate,
                      .strength = std::sqrt(std::max(0.0, chi2 - freedom) / weights)};
    return test;
  }

  Test each_frame() const {
    Test test;
    double weights = 0;
    for (const Frame& frame : frames_)
      test.chi2 += frame.mean * frame.mean / frame.variance, weights += 1 / frame.variance;
    test.freedom = freedom_of_frames();
    test.structure = {.residual = "dn",
                      .moment = "mean",
                      .covariate = "time",
                      .strength = std::sqrt(std::max(0.0, test.chi2 - test.freedom) / weights)};
    return test;
  }

  int freedom_of_frames() const {
    int freedom = 0;
    for (const LevelSums& sum : view_.sums.levels)
      freedom += std::max(0, static_cast<int>(sum.frames.size()) - 1);
    return freedom;
  }

  // Waves that move over the rows: squares of the rows' sine and cosine parts, frame by frame.
  Test rows_in_time() const {
    constexpr int kOrders = 6;
    Test test;
    double weights = 0;
    const int channels = data_.channels;
    for (const Frame& frame : frames_) {
      for (int k = 1; k <= kOrders; ++k) {
        for (const bool sine : {false, true}) {
          double sum = 0, norm = 0;
          for (size_t row = 0; row < frame.rows.size(); ++row) {
            const double x =
                2 * maths::kPi * k * (static_cast<double>(row / channels) + 0.5) / data_.height_px;
            const double b = sine ? std::sin(x) : std::cos(x);
            sum += b * frame.rows[row], norm += b * b;
          }
          const int shared = view_.channels_share ? channels : 1;
          const double own2 = prediction_.chain.row_sigma_dn * prediction_.chain.row_sigma_dn;
          const double variance = norm * (frame.row_variance + own2 * (shared - 1));
          test.chi2 += sum * sum / variance;
          weights += norm / frame.row_variance;
        }
      }
    }
    test.freedom = 2 * kOrders * freedom_of_frames();
    test.structure = {.residual = "dn",
                      .moment = "mean",
                      .covariate = "row*time",
                      .strength = std::sqrt(std::max(0.0, test.chi2 - test.freedom) /
                                            std::max(weights, 1e-300) * 2 * kOrders)};
    return test;
  }

  const PhotometryView& view_;
  const PhotometryData& data_;
  const PhotometryPrediction& prediction_;
  std::vector<Frame> frames_;
};

// Variance in time against place and level; variance between rows from frame to frame.
std::vector<Test> spread_tests(const PhotometryView& view, const PhotometryPrediction& prediction,
                               const MeanTests& places) {
  const PhotometryData& data = view.data;
  struct Target {
    std::string covariate;
    int count;
    std::function<void(const Place&, double, VectorXd&)> basis;
  };
  const auto levels = static_cast<int>(view.sums.levels.size());
  std::vector<Target> targets;
  if (levels > 1) {
    targets.push_back({"illumination", levels, [](const Place& p, double, VectorXd& b) {
                         b[static_cast<Eigen::Index>(p.level)] = 1;
                       }});
  }
  const auto polynomial = [](double x, int count, VectorXd& b) {
    for (int k = 0; k < count; ++k) b[k] = legendre(k + 1, x);
  };
  targets.push_back(
      {"row", 4, [=](const Place& p, double, VectorXd& b) { polynomial(p.y, 4, b); }});
  targets.push_back(
      {"column", 4, [=](const Place& p, double, VectorXd& b) { polynomial(p.x, 4, b); }});
  targets.push_back({"radius", 4, [=](const Place& p, double, VectorXd& b) {
                       polynomial(2 * p.radius - 1, 4, b);
                     }});
  std::vector<VectorXd> statistic;
  std::vector<MatrixXd> covariance;
  for (const Target& target : targets) {
    statistic.push_back(VectorXd::Zero(target.count));
    covariance.push_back(MatrixXd::Zero(target.count, target.count));
  }
  double mean_variance = 0, count = 0;
  for (size_t l = 0; l < view.sums.levels.size(); ++l) {
    const LevelSums& sum = view.sums.levels[l];
    if (sum.frames.size() < 2) continue;
    const LevelPrediction& level = prediction.levels[l];
    const double freedom = (static_cast<double>(sum.frames.size()) - 1) * (1 - 1.0 / data.width_px);
    std::vector<double> z(level.mean.size());
    double square = 0, mean = 0;
    for (size_t i = 0; i < z.size(); ++i) {
      // Clipped values have too little variance left to test.
      z[i] = level.variance[i] < 0.05 ? 0 : sum.scatter[i] / (freedom * level.variance[i]) - 1;
      mean += z[i], square += z[i] * z[i];
      mean_variance += level.variance[i], count += 1;
    }
    mean /= static_cast<double>(z.size());
    // Measured, so that tails other than the Gaussian's do not matter.
    const double variance = std::max(square / static_cast<double>(z.size()) - mean * mean, 1e-12);
    VectorXd b;
    for (size_t k = 0; k < targets.size(); ++k) {
      b = VectorXd::Zero(targets[k].count);
      size_t i = 0;
      for (int v = 0; v < data.height_px; ++v) {
        for (int u = 0; u < data.width_px; ++u) {
          for (int c = 0; c < data.channels; ++c, ++i) {
            b.setZero();
            targets[k].basis(places.place_of(l, u, v, c), level.gain_slope[i], b);
            statistic[k] += z[i] / variance * b;
            covariance[k].selfadjointView<Eigen::Lower>().rankUpdate(b, 1 / variance);
          }
        }
      }
    }
  }
  std::vector<Test> tests;
  if (count == 0) return tests;
  mean_variance /= count;
  for (size_t k = 0; k < targets.size(); ++k) {
    const MatrixXd full = covariance[k].selfadjointView<Eigen::Lower>();
    const auto [chi2, freedom] = chi2_of(statistic[k], full, full.diagonal());
    Test test{.chi2 = chi2, .freedom = freedom};
    const double relative =
        std::sqrt(std::max(0.0, chi2 - freedom) / std::max(full.diagonal().maxCoeff(), 1e-300));
    test.structure = {.residual = "dn",
                      .moment = "spread",
                      .covariate = targets[k].covariate,
                      .strength = std::sqrt(mean_variance) * std::sqrt(relative)};
    tests.push_back(test);
  }
  return tests;
}

// Smooth functions over the image, alone and in proportion to the light.
std::vector<std::pair<std::string, Basis>> place_bases() {
  const auto series = [](double x, double scale, VectorXd& b) {
    for (int k = 0; k < 8; ++k) b[k] = scale * legendre(k + 1, x);
  };
  const auto grid = [](const Place& p, double scale, VectorXd& b) {
    int at = 0;
    for (int i = 1; i <= 3; ++i)
      for (int k = 1; k <= 3; ++k)
        if (i + k <= 5) b[at++] = scale * legendre(i, p.x) * legendre(k, p.y);
  };
  return {
      {"column", [=](const Place& p, double, VectorXd& b) { series(p.x, 1, b); }},
      {"row", [=](const Place& p, double, VectorXd& b) { series(p.y, 1, b); }},
      {"radius", [=](const Place& p, double, VectorXd& b) { series(2 * p.radius - 1, 1, b); }},
      {"row*column", [=](const Place& p, double, VectorXd& b) { grid(p, 1, b); }},
      {"column*illumination", [=](const Place& p, double g, VectorXd& b) { series(p.x, g, b); }},
      {"row*illumination", [=](const Place& p, double g, VectorXd& b) { series(p.y, g, b); }},
      {"radius*illumination",
       [=](const Place& p, double g, VectorXd& b) { series(2 * p.radius - 1, g, b); }},
      {"row*column*illumination", [=](const Place& p, double g, VectorXd& b) { grid(p, g, b); }},
  };
}

}  // namespace

std::vector<Structure> photometry_structure(const PhotometryView& view, const Model& model) {
  const MeanTests means(view, model);
  std::vector<Test> tests;
  for (const auto& [name, basis] : place_bases()) tests.push_back(means.run(name, 8, basis));
  const auto levels = static_cast<int>(view.sums.levels.size());
  tests.push_back(means.run(
      "illumination", std::min(levels, 16), [levels](const Place& p, double, VectorXd& b) {
        // Few levels: a mean for each; many: polynomials of their order.
        if (levels <= 16)
          b[static_cast<Eigen::Index>(p.level)] = 1;
        else
          for (int k = 0; k < 16; ++k)
            b[k] = legendre(k, 2.0 * static_cast<double>(p.level) / (levels - 1) - 1);
      }));
  if (view.data.channels == 3) {
    tests.push_back(means.run("channel", 6, [](const Place& p, double g, VectorXd& b) {
      b[p.channel] = 1, b[3 + p.channel] = g;
    }));
  }
  for (const Test& test : TimeTests(view, means.prediction()).run()) tests.push_back(test);
  for (const Test& test : spread_tests(view, means.prediction(), means)) tests.push_back(test);
  std::vector<Structure> found;
  for (Test& test : tests) {
    if (test.freedom == 0) continue;
    const double p =
        corrected(chi2_tail(test.chi2, test.freedom), static_cast<double>(tests.size()));
    if (!(p < 0.01)) continue;
    test.structure.p_value = p;
    found.push_back(test.structure);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Structure& a, const Structure& b) { return a.strength > b.strength; });
  return found;
}

}  // namespace seam::measurement
