#include "measurement/infer/function_beside.h"

#include <algorithm>
#include <cmath>

namespace seam::measurement {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Columns times columns, of those alone that are anything in these rows.
void add_gram(const auto& rows, MatrixXd& gram) {
  std::vector<Index> active;
  for (Index k = 0; k < rows.cols(); ++k) {
    if ((rows.col(k).array() != 0).any()) active.push_back(k);
  }
  const auto count = static_cast<Index>(active.size());
  const MatrixXd own = rows(Eigen::all, active);
  MatrixXd lower = MatrixXd::Zero(count, count);
  lower.selfadjointView<Eigen::Lower>().rankUpdate(own.transpose());
  gram(active, active) += MatrixXd(lower.selfadjointView<Eigen::Lower>());
}

}  // namespace

FunctionBeside::FunctionBeside(const PartsOfScalars& parts, std::shared_ptr<const MatrixXd> span,
                               Index named, const MatrixXd& columns, const VectorXd& smoother)
    : parts_(&parts), span_(std::move(span)), named_(named) {
  const Index count = columns.cols();
  std::array<MatrixXd, kParts> along;
  followed_ = MatrixXd::Zero(span_->cols(), count);
  for (int part = 0; part < kParts; ++part) {
    along[part] = parts.rows(*span_, part).transpose() * parts.rows(columns, part);
    followed_ += along[part];
  }
  gram_ = MatrixXd::Zero(count, count);
  size_t segment = 0;
  for (int part = 0; part < kParts; ++part) {
    MatrixXd& gram = gram_of_part_[part] = MatrixXd::Zero(count, count);
    for (; parts.begin_of_segment[segment] < parts.begin_of_part[part + 1]; ++segment) {
      const Index begin = parts.begin_of_segment[segment];
      add_gram(columns.middleRows(begin, parts.begin_of_segment[segment + 1] - begin), gram);
    }
    const auto basis = parts.rows(*span_, part);
    const MatrixXd half = along[part] - 0.5 * (basis.transpose() * basis).eval() * followed_;
    const MatrixXd less = half.transpose() * followed_;
    gram -= less + less.transpose();
    gram_ += gram;
  }
  priors_.emplace_back(gram_, VectorXd::Ones(count));
  priors_.emplace_back(gram_, smoother);
}

VectorXd FunctionBeside::beside_named(const VectorXd& rest) const {
  const auto named = span_->rightCols(named_);
  return rest - named * (named.transpose() * rest);
}

// Of log-likelihood, each part predicted from all others.
double FunctionBeside::held_out_gain(const std::array<VectorXd, kParts>& right_of_part) const {
  VectorXd all = right_of_part[0];
  for (int part = 1; part < kParts; ++part) all += right_of_part[part];
  double gain = 0;
  for (int part = 0; part < kParts; ++part) {
    const MatrixXd& gram = gram_of_part_[part];
    const VectorXd& right = right_of_part[part];
    const VectorXd b = coefficients_of(gram_ - gram, all - right, effect_.spread);
    gain += right.dot(b) - 0.5 * b.dot(gram * b);
  }
  return gain;
}

double FunctionBeside::look(const MatrixXd& columns, const VectorXd& rest, double least) {
  const VectorXd own = beside_named(rest);
  std::array<VectorXd, kParts> right_of_part;
  VectorXd right = VectorXd::Zero(columns.cols());
  for (int part = 0; part < kParts; ++part) {
    const auto here = parts_->rows(own, part);
    right_of_part[part] = parts_->rows(columns, part).transpose() * here;
    right_of_part[part] -= followed_.transpose() * (parts_->rows(*span_, part).transpose() * here);
    right += right_of_part[part];
  }
  effect_ = {};
  for (const RandomCoefficients& prior : priors_) {
    RandomEffect effect = prior.effect(right);
    if (effect.log_evidence > effect_.log_evidence) effect_ = std::move(effect);
  }
  log_evidence_ = effect_.log_evidence;
  if (log_evidence_ > least) {
    if (held_out_gain(right_of_part) <= 0) return log_evidence_ = 0;
    const double price = 0.5 * std::log(static_cast<double>(rest.size()));
    const double taken = 0.5 * (rest.squaredNorm() - own.squaredNorm());
    log_evidence_ += std::max(0.0, taken - price * static_cast<double>(named_));
  }
  return log_evidence_;
}

VectorXd FunctionBeside::left_of(const MatrixXd& columns, const VectorXd& rest) const {
  return beside_named(rest) - columns * effect_.coefficients +
         *span_ * (followed_ * effect_.coefficients);
}

}  // namespace seam::measurement
