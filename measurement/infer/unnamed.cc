#include "measurement/infer/unnamed.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "measurement/infer/random_effect.h"
#include "measurement/infer/smooth_field.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/parallel_for.h"

namespace seam::measurement {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Groups, or where they are few their blocks, in so many parts: each is predicted from the others.
constexpr int kParts = 4;

// One explanation's residuals, without what its own parameters can still take of them.
class Residuals {
 public:
  Residuals(const Problem& problem, const Model& model, const std::vector<Unknown>& unknowns);

  bool valid() const { return !scalars_.empty(); }
  std::vector<FieldPlace> places() const;
  double chi2() const { return rest_.squaredNorm(); }
  double count() const { return static_cast<double>(scalars_.size()); }
  // What a field gains here; nothing where it changes nothing.
  std::optional<UnnamedCause> with(const SmoothField& field, RandomEffect& effect) const;

 private:
  VectorXd own_of(const std::vector<double>& column) const;
  double held_out_gain(const MatrixXd& columns, double size) const;

  const Problem& problem_;
  const Model& model_;
  Evaluation here_;
  std::vector<size_t> scalars_;  // Those that take part.
  std::vector<int> part_;        // Of each of them.
  MatrixXd span_;                // Orthonormal: of the fitted parameters.
  VectorXd rest_;
};

Residuals::Residuals(const Problem& problem, const Model& model,
                     const std::vector<Unknown>& unknowns)
    : problem_(problem), model_(model) {
  const Groups all = problem.all_groups();
  here_ = problem.evaluate(model, all);
  if (!here_.valid || here_.whitened.size() < problem.facts().scalars()) return;
  const std::vector<int>& blocks = problem.blocks();
  for (size_t i = 0; i < problem.facts().scalars(); ++i) {
    if (!here_.used[i]) continue;
    scalars_.push_back(i);
    part_.push_back((blocks.empty() ? problem.facts().group_of(i) : blocks[i]) % kParts);
  }
  std::vector<Unknown> mean;
  std::copy_if(unknowns.begin(), unknowns.end(), std::back_inserter(mean), [&](const Unknown& u) {
    return !model.find(u.effect)->definition->spread_only;
  });
  const auto columns =
      mean.empty() ? std::vector<std::vector<double>>() : problem.jacobian(model, mean, all, here_);
  MatrixXd slopes(static_cast<Index>(scalars_.size()), static_cast<Index>(columns.size()));
  for (size_t k = 0; k < columns.size(); ++k) {
    for (size_t i = 0; i < scalars_.size(); ++i)
      slopes(static_cast<Index>(i), static_cast<Index>(k)) = columns[k][scalars_[i]];
    const double length = slopes.col(static_cast<Index>(k)).norm();
    if (length > 0) slopes.col(static_cast<Index>(k)) /= length;
  }
  span_ = columns.empty() ? slopes : column_basis(slopes, 1e-6);
  rest_ = own_of(here_.whitened);
}

std::vector<FieldPlace> Residuals::places() const {
  std::vector<FieldPlace> places = places_in_channels(problem_, here_);
  for (FieldPlace& place : problem_.field_places(model_, here_)) places.push_back(std::move(place));
  return places;
}

VectorXd Residuals::own_of(const std::vector<double>& column) const {
  VectorXd own(static_cast<Index>(scalars_.size()));
  for (size_t i = 0; i < scalars_.size(); ++i) own[static_cast<Index>(i)] = column[scalars_[i]];
  if (span_.cols() > 0) own -= span_ * (span_.transpose() * own);
  return own;
}

std::optional<UnnamedCause> Residuals::with(const SmoothField& field, RandomEffect& effect) const {
  auto columns = columns_of(problem_.facts(), field);
  if (columns.empty()) return std::nullopt;
  columns = problem_.following(model_, problem_.all_groups(), here_, std::move(columns));
  if (columns.empty()) return std::nullopt;
  MatrixXd all(rest_.size(), static_cast<Index>(columns.size()));
  for (size_t k = 0; k < columns.size(); ++k) all.col(static_cast<Index>(k)) = own_of(columns[k]);
  const VectorXd right = all.transpose() * rest_;
  effect = random_effect(all.transpose() * all, right);
  if (!(effect.log_evidence > 0)) return std::nullopt;
  const VectorXd change = all * effect.coefficients;
  const double left = (rest_ - change).squaredNorm();
  const double excess = std::max(chi2() - count(), 1.0);
  if (held_out_gain(all, effect.size) <= 0) return std::nullopt;
  return UnnamedCause{.depends_on = names_of(field),
                      .noise_units = std::sqrt(change.squaredNorm() / count()),
                      .takes = std::min(1.0, (chi2() - left) / excess),
                      .error_before = std::sqrt(chi2() / count()),
                      .error_after = std::sqrt(left / count())};
}

// Of log-likelihood, each part predicted from all others.
double Residuals::held_out_gain(const MatrixXd& columns, double size) const {
  std::vector<MatrixXd> gram(kParts, MatrixXd::Zero(columns.cols(), columns.cols()));
  std::vector<VectorXd> right(kParts, VectorXd::Zero(columns.cols()));
  for (int part = 0; part < kParts; ++part) {
    std::vector<Index> rows;
    for (size_t i = 0; i < part_.size(); ++i) {
      if (part_[i] == part) rows.push_back(static_cast<Index>(i));
    }
    MatrixXd own(static_cast<Index>(rows.size()), columns.cols());
    VectorXd rest(own.rows());
    for (Index i = 0; i < own.rows(); ++i)
      own.row(i) = columns.row(rows[i]), rest[i] = rest_[rows[i]];
    gram[part] = own.transpose() * own, right[part] = own.transpose() * rest;
  }
  MatrixXd all = MatrixXd::Zero(columns.cols(), columns.cols());
  VectorXd all_right = VectorXd::Zero(columns.cols());
  for (int part = 0; part < kParts; ++part) all += gram[part], all_right += right[part];
  double gain = 0;
  for (int part = 0; part < kParts; ++part) {
    const VectorXd b = coefficients_of(all - gram[part], all_right - right[part], size);
    gain += right[part].dot(b) - 0.5 * b.dot(gram[part] * b);
  }
  return gain;
}

}  // namespace

std::optional<UnnamedCause> unnamed_cause(const Problem& problem,
                                          const std::vector<Explanation>& explanations,
                                          double width, double material) {
  std::optional<UnnamedCause> best;
  double most = 0;
  const double named = explanations.back().log_evidence;
  for (size_t e = 0; e < explanations.size(); ++e) {
    const Assessment& assessment = *explanations[e].assessment;
    const Residuals residuals(problem, assessment.model, assessment.unknowns);
    if (!residuals.valid()) continue;
    const std::vector<FieldPlace> places = residuals.places();
    const std::vector<SmoothField> fields = smooth_fields(places);
    std::vector<std::optional<UnnamedCause>> found(fields.size());
    std::vector<double> evidence(fields.size(), 0);
    parallel_for(fields.size(), [&](size_t f) {
      RandomEffect effect;
      found[f] = residuals.with(fields[f], effect);
      evidence[f] = effect.log_evidence;
    });
    for (size_t f = 0; f < fields.size(); ++f) {
      if (!found[f] || found[f]->noise_units < material) continue;
      // Each field is one look; where something is left that is no noise, evidence is too sure.
      const double misfit = std::max(1.0, found[f]->error_after * found[f]->error_after);
      const double lead = (explanations[e].log_evidence + evidence[f] - named) / misfit -
                          std::log(static_cast<double>(fields.size()));
      if (lead <= width || lead <= most) continue;
      most = lead;
      best = found[f];
      best->beside = e, best->lead = lead;
    }
  }
  return best;
}

}  // namespace seam::measurement
