#include "measurement/kinds/photometry/means/mean_errors.h"

#include <cmath>

#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// What is known beforehand of light that is fitted, as a share of it: nothing.
constexpr double kUnknownLight = 1;

}  // namespace

RootInverse::RootInverse(const MatrixXd& loads)
    : RootInverse(std::vector<MatrixXd>{loads}, {1.0}) {}

// With loads' loads = E diag(l) E' the root is 1 - loads E diag((1 - (1 + l)^-1/2) / l) E' loads'.
RootInverse::RootInverse(std::vector<MatrixXd> loads, const std::vector<double>& times)
    : along_(std::move(loads)) {
  const Index count = along_.empty() ? 0 : along_.front().cols();
  if (count == 0) return;
  MatrixXd gram = MatrixXd::Zero(count, count);
  for (size_t block = 0; block < along_.size(); ++block)
    gram += times[block] * (along_[block].transpose() * along_[block]);
  const SymmetricEigen eigen = symmetric_eigen(gram);
  less_.resize(count);
  for (Index i = 0; i < count; ++i) {
    const double l = std::max(eigen.values[i], 0.0), root = std::sqrt(1 + l);
    less_[i] = 1 / (root * (1 + root));
  }
  for (MatrixXd& block : along_) block = block * eigen.vectors;
}

MeanErrors::MeanErrors(const ImageCells& cells, const effects::SensorChain& chain,
                       std::vector<LevelMeans> levels, const std::vector<int>& level_of_frame,
                       bool share, const std::vector<char>& blank)
    : chain_(chain), share_(share), levels_(std::move(levels)), level_of_frame_(level_of_frame) {
  std::vector<MatrixXd> patterns;
  std::vector<double> frames(levels_.size(), 0);
  for (const int level : level_of_frame_) ++frames[static_cast<size_t>(level)];
  for (size_t l = 0; l < levels_.size(); ++l) {
    inverse_sigma_.emplace_back(VectorXd::Zero(cells.count()));
    for (Index k = 0; k < cells.count(); ++k) {
      if (levels_[l].sigma[k] > 0) inverse_sigma_[l][k] = 1 / levels_[l].sigma[k];
    }
    frame_.emplace_back(inverse_sigma_[l].asDiagonal() * loads_of_frame(cells, levels_[l]));
    MatrixXd loads = inverse_sigma_[l].asDiagonal() * loads_of_patterns(cells, l, blank);
    if (!frame_[l].is_identity()) loads -= frame_[l].taken(0, frame_[l].along(0, loads));
    patterns.push_back(std::move(loads));
  }
  patterns_ = RootInverse(std::move(patterns), frames);
}

// A row's noise is the same in all cells beside each other, the lamp's in the whole frame.
MatrixXd MeanErrors::loads_of_frame(const ImageCells& cells, const LevelMeans& level) const {
  const int units = share_ ? 1 : cells.channels();
  const Index rows = chain_.row_sigma_dn > 0 ? cells.grid().rows * units : 0;
  const Index lamps = chain_.lamp_sigma > 0 ? 1 : 0;
  MatrixXd loads = MatrixXd::Zero(cells.count(), rows + lamps);
  for (Index k = 0; k < cells.count(); ++k) {
    if (rows > 0)
      loads(k, cells.row_of(k) * units + cells.channel_of(k) % units) =
          chain_.row_sigma_dn / std::sqrt(cells.height_of(k)) * level.offset_slope[k];
    if (lamps > 0) loads(k, rows) = chain_.lamp_sigma * level.gain_slope[k];
  }
  return loads;
}

// Offsets, gains and dark currents of pixels, offsets of columns, and light that is fitted.
MatrixXd MeanErrors::loads_of_patterns(const ImageCells& cells, size_t l,
                                       const std::vector<char>& blank) const {
  const LevelMeans& level = levels_[l];
  const int units = share_ ? 1 : cells.channels();
  const Index offsets = chain_.pixel_offset_sigma_dn > 0 ? cells.count() : 0,
              gains = chain_.pixel_gain_sigma > 0 ? cells.count() : 0,
              darks = chain_.dark_sigma_dn_per_s > 0 ? cells.count() : 0,
              columns = chain_.column_sigma_dn > 0 ? cells.grid().columns * units : 0;
  Index lights = 0, own = -1;
  for (size_t other = 0; other < blank.size(); ++other) {
    if (other == l && blank[other]) own = lights;
    lights += blank[other] != 0;
  }
  MatrixXd loads = MatrixXd::Zero(cells.count(), offsets + gains + darks + columns + lights);
  for (Index k = 0; k < cells.count(); ++k) {
    const double mean = 1 / std::sqrt(std::max(1.0, level.values[k]));
    if (offsets > 0) loads(k, k) = chain_.pixel_offset_sigma_dn * mean * level.offset_slope[k];
    if (gains > 0) loads(k, offsets + k) = chain_.pixel_gain_sigma * mean * level.gain_slope[k];
    if (darks > 0)
      loads(k, offsets + gains + k) =
          chain_.dark_sigma_dn_per_s * level.dark_s * mean * level.offset_slope[k];
    const Index shared = offsets + gains + darks;
    if (columns > 0)
      loads(k, shared + cells.column_of(k) * units + cells.channel_of(k) % units) =
          chain_.column_sigma_dn / std::sqrt(cells.width_of(k)) * level.offset_slope[k];
    if (own >= 0) loads(k, shared + columns + own) = kUnknownLight * level.gain_slope[k];
  }
  return loads;
}

MatrixXd MeanErrors::whitened(const MatrixXd& columns) const {
  const auto frames = static_cast<Index>(level_of_frame_.size());
  const Index means = frames > 0 ? columns.rows() / frames : 0;
  MatrixXd out(columns.rows(), columns.cols());
  std::vector<MatrixXd> sum(levels_.size(), MatrixXd::Zero(means, columns.cols()));
  for (Index f = 0; f < frames; ++f) {
    const auto l = static_cast<size_t>(level_of_frame_[static_cast<size_t>(f)]);
    MatrixXd own = inverse_sigma_[l].asDiagonal() * columns.middleRows(f * means, means);
    if (!frame_[l].is_identity()) own -= frame_[l].taken(0, frame_[l].along(0, own));
    sum[l] += own;
    out.middleRows(f * means, means) = own;
  }
  if (patterns_.is_identity()) return out;
  MatrixXd along = MatrixXd::Zero(patterns_.size(), columns.cols());
  for (size_t l = 0; l < levels_.size(); ++l) along += patterns_.along(l, sum[l]);
  for (size_t l = 0; l < levels_.size(); ++l) sum[l] = patterns_.taken(l, along);
  for (Index f = 0; f < frames; ++f)
    out.middleRows(f * means, means) -=
        sum[static_cast<size_t>(level_of_frame_[static_cast<size_t>(f)])];
  return out;
}

}  // namespace seam::measurement
