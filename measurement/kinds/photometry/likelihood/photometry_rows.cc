#include "measurement/kinds/photometry/likelihood/photometry_rows.h"

#include <Eigen/Dense>
#include <algorithm>

#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Independent effects of these variances, of which data say `score` with `precision`.
void add_effects(const VectorXd& variance, const VectorXd& score, const MatrixXd& precision,
                 Quadratic& total) {
  const Index n = variance.size();
  const MatrixXd system = MatrixXd::Identity(n, n) + precision * variance.asDiagonal();
  double log_det = 0;
  total.chi2 -= score.dot(variance.asDiagonal() * VectorXd(solve_square(system, score, &log_det)));
  total.log_det += log_det;
}

}  // namespace

PatternInverse pattern_inverse(const PatternLoads* loads, const double* inverse, size_t levels) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();
  for (size_t k = 0; k < levels; ++k) information += inverse[k] * loads[k] * loads[k].transpose();
  return {.core = information.inverse(), .log_det = std::log(information.determinant())};
}

RowOffsets::RowOffsets(const PhotometryData& data, const PhotometrySums& sums, bool share,
                       bool many)
    : width_(data.width_px),
      height_(data.height_px),
      channels_(data.channels),
      share_(share),
      many_(many) {
  for (const LevelSums& level : sums.levels) {
    if (!level.frames.empty()) frames_.push_back(static_cast<double>(level.frames.size()));
  }
  levels_ = frames_.size();
  const size_t units = static_cast<size_t>(height_) * (share ? 1 : channels_);
  for (auto* v : {&score_, &by_light_, &by_offset_}) v->assign(units * levels_, 0);
  if (!many) {
    precision_.assign(units * levels_ * levels_, 0);
    return;
  }
  diagonal_.assign(units * levels_, 0);
  loads_.assign(units * levels_, PatternLoads::Zero());
  samples_.assign(units, 0);
}

void RowOffsets::add_precision(size_t unit, double n, const double* diagonal,
                               const PatternLoads* loads) {
  const size_t at = unit * levels_;
  for (size_t k = 0; k < levels_; ++k) {
    diagonal_[at + k] += n * diagonal[k];
    loads_[at + k] += n * loads[k];
  }
  samples_[unit] += n;
}

VectorXd RowOffsets::Information::times(const VectorXd& x) const {
  if (few.size() > 0) return few * x;
  return diagonal.cwiseProduct(x) - columns * (core * (columns.transpose() * x));
}

MatrixXd RowOffsets::Information::whole() const {
  if (few.size() > 0) return few;
  MatrixXd all = -columns * core * columns.transpose();
  all.diagonal() += diagonal;
  return all;
}

RowOffsets::Information RowOffsets::information(size_t unit) const {
  const auto n = static_cast<Index>(levels_);
  if (!many_) {
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    return {.few = Eigen::Map<const Rows>(&precision_[unit * levels_ * levels_], n, n)};
  }
  // Columns are loads times D, the core that of the average sample.
  const double samples = std::max(samples_[unit], 1.0);
  Information P{.diagonal = Eigen::Map<const VectorXd>(&diagonal_[unit * levels_], n),
                .columns = Eigen::MatrixX3d(n, 3)};
  const VectorXd weight = P.diagonal / samples;
  std::vector<PatternLoads> loads(levels_, PatternLoads::Zero());
  for (size_t l = 0; l < levels_; ++l) {
    const auto row = static_cast<Index>(l);
    P.columns.row(row) = loads_[unit * levels_ + l];
    if (P.diagonal[row] > 0) loads[l] = loads_[unit * levels_ + l] / P.diagonal[row];
  }
  P.core = pattern_inverse(loads.data(), weight.data(), levels_).core / samples;
  return P;
}

RowOffsets::Information RowOffsets::beside(size_t unit, const VectorXd& k, double& log_det) const {
  Information P = information(unit);
  if (k.isZero(0)) return P;
  if (!many_) {
    const auto n = static_cast<Index>(levels_);
    double own = 0;
    const MatrixXd system = MatrixXd::Identity(n, n) + P.few * k.asDiagonal();
    const MatrixXd few = solve_square(system, P.few, &own);
    log_det += own;
    return {.few = few};
  }
  // It keeps its form: D / (1 + D k), U / (1 + D k), (Q^-1 - U' k / (1 + D k) U)^-1.
  const VectorXd less = (1 + P.diagonal.array() * k.array()).inverse();
  const Eigen::Matrix3d G =
      P.columns.transpose() * (k.array() * less.array()).matrix().asDiagonal() * P.columns;
  const Eigen::Matrix3d inner = Eigen::Matrix3d::Identity() - G * P.core;
  log_det += std::log(inner.determinant()) - less.array().log().sum();
  P.core = (P.core * inner.inverse()).eval();
  P.columns = (less.asDiagonal() * P.columns).eval();
  P.diagonal = P.diagonal.cwiseProduct(less).eval();
  return P;
}

std::vector<double> RowOffsets::estimate(size_t unit) const {
  const Eigen::Map<const VectorXd> b(&score_[unit * levels_], static_cast<Index>(levels_));
  Information P = information(unit);
  // A level that is clipped whole says nothing.
  const auto ridge = [](const auto& own) { return (1e-9 * own.array() + 1e-12).matrix(); };
  VectorXd x;
  if (many_) {
    const VectorXd A = P.diagonal + ridge(P.diagonal);
    const Eigen::MatrixX3d part = A.cwiseInverse().asDiagonal() * P.columns;
    const Eigen::Matrix3d inner =
        Eigen::Matrix3d::Identity() - P.columns.transpose() * part * P.core;
    x = b.cwiseQuotient(A) + part * (P.core * inner.inverse() * (part.transpose() * b));
  } else {
    P.few.diagonal() += ridge(VectorXd(P.few.diagonal()));
    x = solve_square(P.few, b);
  }
  return {x.begin(), x.end()};
}

double RowOffsets::share_of_light(size_t unit, size_t level) const {
  const size_t at = unit * levels_ + level;
  return by_offset_[at] > 0 ? by_light_[at] / by_offset_[at] : 0;
}

void RowOffsets::add(const effects::SensorChain& chain, Quadratic& total) const {
  const auto n = static_cast<Index>(levels_);
  const bool lamps = chain.lamp_sigma > 0;
  const auto groups = static_cast<Index>(share_ ? 1 : channels_);
  // What units have in common: the mean of each group's columns, the light of each level.
  const Index common = groups + (lamps ? n : 0);
  VectorXd variance(common), score = VectorXd::Zero(common);
  variance.head(groups).setConstant(chain.column_sigma_dn * chain.column_sigma_dn / width_);
  MatrixXd precision = MatrixXd::Zero(common, common);
  VectorXd k(n);
  for (Index l = 0; l < n; ++l) {
    const double frames = frames_[static_cast<size_t>(l)];
    k[l] = chain.row_sigma_dn * chain.row_sigma_dn / frames;
    if (lamps) variance[groups + l] = chain.lamp_sigma * chain.lamp_sigma / frames;
  }
  for (size_t unit = 0; unit < score_.size() / levels_; ++unit) {
    const Eigen::Map<const VectorXd> b(&score_[unit * levels_], n);
    const Information S = beside(unit, k, total.log_det);
    // (1 + P k)^-1 b = b - S k b.
    const VectorXd x = b - S.times(k.cwiseProduct(b));
    total.chi2 -= b.dot(k.asDiagonal() * x);
    const Index group = static_cast<Index>(unit) % groups;
    score[group] += x.sum();
    precision(group, group) += S.times(VectorXd::Ones(n)).sum();
    if (!lamps) continue;
    VectorXd light(n);
    for (Index l = 0; l < n; ++l) light[l] = share_of_light(unit, static_cast<size_t>(l));
    const MatrixXd by_light = S.whole() * light.asDiagonal();
    score.tail(n) += light.asDiagonal() * x;
    precision.bottomRightCorner(n, n) += light.asDiagonal() * by_light;
    const VectorXd both = by_light.colwise().sum();
    precision.row(group).tail(n) += both.transpose();
    precision.col(group).tail(n) += both;
  }
  add_effects(variance, score, precision, total);
}

void add_lamps_to_means(const PhotometrySums& sums, double lamp_sigma,
                        const std::vector<double>& score, const std::vector<double>& precision,
                        Quadratic& total) {
  const auto n = static_cast<Index>(score.size());
  VectorXd variance(n);
  Index l = 0;
  for (const LevelSums& level : sums.levels) {
    if (level.frames.empty()) continue;
    variance[l++] = lamp_sigma * lamp_sigma / static_cast<double>(level.frames.size());
  }
  // Symmetric but for rounding, so that its order does not matter.
  add_effects(variance, Eigen::Map<const VectorXd>(score.data(), n),
              Eigen::Map<const MatrixXd>(precision.data(), n, n), total);
}

}  // namespace seam::measurement
