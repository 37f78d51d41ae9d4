#include "measurement/kinds/photometry/structure/photometry_time_tests.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>

#include "measurement/numerics/legendre.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

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
      const double lamp = prediction.chain.lamp_sigma * gain;
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
        frame.variance = (variance / data_.width_px + row2 * shared) / n + lamp * lamp;
        frame.row_variance = variance / data_.width_px + row2;
        frames_.push_back(std::move(frame));
      }
    }
  }

  // Smooth functions of time, and every frame a mean of its own.
  std::vector<StructureTest> run() const {
    std::vector<StructureTest> tests;
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

  StructureTest smooth(const std::string& covariate, int count,
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
    StructureTest test{.chi2 = chi2, .freedom = freedom};
    test.structure = {.residual = "dn",
                      .moment = "mean",
                      .covariate = covariate,
                      .strength = std::sqrt(std::max(0.0, chi2 - freedom) / weights)};
    return test;
  }

  StructureTest each_frame() const {
    StructureTest test;
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
  StructureTest rows_in_time() const {
    constexpr int kOrders = 6;
    StructureTest test;
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

}  // namespace

std::vector<StructureTest> time_tests(const PhotometryView& view,
                                      const PhotometryPrediction& prediction) {
  return TimeTests(view, prediction).run();
}

}  // namespace seam::measurement
