#include "measurement/kinds/photometry/structure/photometry_neighbour_tests.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "measurement/numerics/regression.h"
#include "measurement/numerics/robust.h"
#include "measurement/problem/neighbour.h"

namespace seam::measurement {
namespace {

// Single samples further out than this count as if they stood here: one hot pixel says nothing of
// its neighbours.
constexpr double kFarthest = 4;
// Of single frames so many show a correlation of 0.002, far below one that matters.
constexpr double kMostValues = 1e6;

// Sums over pairs of neighbours, in rows and in columns.
struct Pairs {
  double products[2] = {0, 0};
  double count[2] = {0, 0};
  double squares = 0, samples = 0;
  double expected[2] = {0, 0};  // Correlation that rounding makes once a filter is undone.
};

void clip(std::vector<double>& values) {
  std::vector<double> sizes = values;
  const double most = kFarthest * robust_sigma(std::move(sizes));
  for (double& value : values) value = std::clamp(value, -most, most);
}

// Rows or columns of each channel, and their means.
class Lines {
 public:
  Lines(const PhotometryData& data, bool of_rows) : data_(data), of_rows_(of_rows) {}

  size_t count() const {
    return static_cast<size_t>(of_rows_ ? data_.height_px : data_.width_px) * data_.channels;
  }
  double length() const { return of_rows_ ? data_.width_px : data_.height_px; }
  size_t of(size_t sample) const {
    const size_t channels = data_.channels, pixel = sample / channels;
    return (of_rows_ ? pixel / data_.width_px : pixel % data_.width_px) * channels +
           sample % channels;
  }
  std::vector<double> means(const std::vector<double>& values) const {
    std::vector<double> mean(count(), 0);
    for (size_t i = 0; i < values.size(); ++i) mean[of(i)] += values[i] / length();
    return mean;
  }

 private:
  const PhotometryData& data_;
  bool of_rows_;
};

// Takes the means of rows and of columns, which have tests of their own, out of each channel.
void centre(const PhotometryData& data, std::vector<double>& values) {
  for (const bool of_rows : {true, false}) {
    const Lines lines(data, of_rows);
    const std::vector<double> mean = lines.means(values);
    for (size_t i = 0; i < values.size(); ++i) values[i] -= mean[lines.of(i)];
  }
}

void add_pairs(const PhotometryData& data, const std::vector<double>& values, Pairs& pairs) {
  const size_t channels = data.channels, width = data.width_px * channels;
  size_t i = 0;
  for (int v = 0; v < data.height_px; ++v) {
    for (int u = 0; u < data.width_px; ++u) {
      // Of large images not all columns and rows are kept.
      const bool right = u + 1 < data.width_px && data.column(u + 1) == data.column(u) + 1;
      const bool below = v + 1 < data.height_px && data.row(v + 1) == data.row(v) + 1;
      for (size_t c = 0; c < channels; ++c, ++i) {
        pairs.squares += values[i] * values[i], ++pairs.samples;
        if (right) pairs.products[0] += values[i] * values[i + channels], ++pairs.count[0];
        if (below) pairs.products[1] += values[i] * values[i + width], ++pairs.count[1];
      }
    }
  }
}

// In rows (0) or in columns (1), without what taking the mean out of a line has left; 0 without
// pairs.
double correlation_of(const PhotometryData& data, const Pairs& pairs, int way) {
  if (pairs.count[way] == 0 || !(pairs.squares > 0)) return 0;
  const int length = way == 0 ? data.width_px : data.height_px;
  return pairs.products[way] / pairs.count[way] * pairs.samples / pairs.squares + 1.0 / length -
         pairs.expected[way];
}

// Of independent samples the correlation of n pairs scatters by 1 / sqrt(n). `independent`: the
// share of the samples that are, beside their own means.
StructureTest test_of(const PhotometryData& data, const std::string& covariate, const Pairs& pairs,
                      double variance, double independent) {
  StructureTest test;
  double alike = 0;
  for (int way = 0; way < 2; ++way) {
    if (pairs.count[way] == 0 || !(pairs.squares > 0)) continue;
    const double correlation = correlation_of(data, pairs, way);
    test.chi2 += independent * pairs.count[way] * correlation * correlation;
    ++test.freedom;
    alike += correlation;
  }
  if (test.freedom == 0) return test;
  test.structure = {.residual = "dn",
                    .moment = "mean",
                    .covariate = covariate,
                    .strength = std::sqrt(std::abs(alike) / test.freedom * variance)};
  return test;
}

// Whether the pixels of a row, or of a column, are alike: means of lines scatter more than pixels
// that know nothing of each other let them. `together`: levels in units of their scatter, summed;
// `own2` is the variance of a line's sum that the model has.
StructureTest of_lines(const Lines& lines, const std::string& covariate,
                       const std::vector<double>& together, double variance, double own2,
                       double unit) {
  std::vector<double> mean = lines.means(together);
  double middle = 0;
  for (const double m : mean) middle += m / static_cast<double>(mean.size());
  const double expected = variance / lines.length() + own2;
  StructureTest test{.freedom = static_cast<int>(mean.size()) - 1};
  if (!(expected > 0) || test.freedom < 1) return {};
  for (const double m : mean) test.chi2 += (m - middle) * (m - middle) / expected;
  test.structure = {
      .residual = "dn",
      .moment = "mean",
      .covariate = covariate,
      .strength = unit * std::sqrt(std::max(0.0, test.chi2 / test.freedom - 1) * expected)};
  return test;
}

// What stays over the frames, all levels of light together: neighbours, rows and columns.
std::vector<StructureTest> of_means(const PhotometryView& view,
                                    const PhotometryPrediction& prediction) {
  std::vector<double> together(view.data.samples(), 0), raw = together;
  double variance = 0, levels = 0, column = 0, row2 = 0;
  for (size_t l = 0; l < view.sums.levels.size(); ++l) {
    if (view.sums.levels[l].frames.empty()) continue;
    std::vector<double> left(together.size());
    for (size_t i = 0; i < left.size(); ++i)
      left[i] = view.sums.levels[l].mean[i] - prediction.levels[l].mean[i];
    clip(left);
    const std::vector<double> clipped = left;
    centre(view.data, left);
    const double size = robust_sigma(left);
    if (!(size > 0)) continue;
    for (size_t i = 0; i < left.size(); ++i)
      together[i] += left[i] / size, raw[i] += clipped[i] / size;
    variance += size * size, ++levels;
    column += prediction.chain.column_sigma_dn / size;
    row2 += std::pow(prediction.chain.row_sigma_dn / size, 2) /
            static_cast<double>(view.sums.levels[l].frames.size());
  }
  if (levels == 0) return {};
  Pairs pairs;
  add_pairs(view.data, together, pairs);
  const double scatter2 = pairs.squares / pairs.samples,
               unit = std::sqrt(variance / levels) / levels;
  return {test_of(view.data, kPixelNeighbour, pairs, variance / levels, 1),
          of_lines({view.data, true}, "row", raw, scatter2, row2, unit),
          of_lines({view.data, false}, "column", raw, scatter2, column * column, unit)};
}

// What changes from frame to frame.
struct FramePairs {
  Pairs pairs;
  double variance = 0, independent = 0;  // Of a sample, and the share of them that are.
};

FramePairs frame_pairs(const PhotometryView& view) {
  FramePairs found;
  const auto values = static_cast<double>(view.sums.values);
  const auto every = static_cast<size_t>(std::max(1.0, std::round(values / kMostValues)));
  double frames = 0, rounding = 0;
  const effects::Mixing& mixing = view.data.mixing;
  const double rounding2 = effects::unmixed_variance(mixing) / 12;
  for (const LevelSums& level : view.sums.levels) {
    if (level.frames.size() < 2) continue;
    const double share = 1 - 1 / static_cast<double>(level.frames.size());
    for (size_t f = 0; f < level.frames.size(); f += every) {
      const auto frame = static_cast<size_t>(level.frames[f]);
      std::vector<double> left(view.data.samples());
      for (size_t i = 0; i < left.size(); ++i) left[i] = view.data.value(frame, i) - level.mean[i];
      clip(left);
      centre(view.data, left);
      const double size = robust_sigma(left);
      if (!(size > 0)) continue;
      for (double& value : left) value /= size;
      add_pairs(view.data, left, found.pairs);
      found.variance += size * size / share, found.independent += share, ++frames;
      rounding += std::min(1.0, rounding2 * share / (size * size));
    }
  }
  if (!(frames > 0)) return found;
  found.variance /= frames, found.independent /= frames;
  found.pairs.expected[0] = rounding / frames * effects::unmixed_correlation(mixing.along_rows);
  found.pairs.expected[1] = rounding / frames * effects::unmixed_correlation(mixing.along_columns);
  return found;
}

StructureTest of_frames(const PhotometryData& data, const FramePairs& found) {
  return test_of(data, kPixelNeighbour + std::string("*time"), found.pairs, found.variance,
                 found.independent);
}

}  // namespace

NoiseLikeness noise_likeness(const PhotometryView& view) {
  const FramePairs found = frame_pairs(view);
  const StructureTest test = of_frames(view.data, found);
  if (test.freedom == 0) return {};
  return {.along_rows = correlation_of(view.data, found.pairs, 0),
          .along_columns = correlation_of(view.data, found.pairs, 1),
          .p_value = chi2_tail(test.chi2, test.freedom)};
}

std::vector<StructureTest> neighbour_tests(const PhotometryView& view,
                                           const PhotometryPrediction& prediction) {
  std::vector<StructureTest> tests = of_means(view, prediction);
  tests.push_back(of_frames(view.data, frame_pairs(view)));
  return tests;
}

}  // namespace seam::measurement
