#include "measurement/plan/likelihood_look.h"

#include <algorithm>
#include <cmath>

#include "measurement/numerics/linear_algebra.h"
#include "measurement/problem/residual_view.h"

namespace seam::measurement {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Standard deviations of errors that add up.
bool enters_by_square(const Coordinate& c) {
  return c.spread && !c.parameter->fit_reciprocal;
}

// Differences over one standard error: the likelihood changes by a half, far above its rounding.
class Differences {
 public:
  Differences(const Problem& made, const Model& truth, const std::vector<Unknown>& unknowns)
      : made_(made), truth_(truth), space_(truth, unknowns), place_(space_.place(truth)) {
    for (Index k = 0; k < size(); ++k) place_[k] = to_quadratic(of(k), place_[k]);
  }

  Index size() const { return place_.size(); }
  const VectorXd& steps() const { return steps_; }
  Model at(const VectorXd& by) const {
    VectorXd place = place_ + by;
    for (Index k = 0; k < size(); ++k)
      if (enters_by_square(of(k))) place[k] = std::sqrt(std::max(0.0, place[k]));
    return space_.at(truth_, place);
  }

  // Finds the steps, on these groups. A coordinate that cannot be moved, or that the data say
  // nothing of, has none.
  void find_steps(const Groups& groups) {
    constexpr int kTries = 12;
    constexpr double kFirst = 1e-3, kGoodTo = 1.5, kMost = 30;
    steps_ = VectorXd::Zero(size());
    const double here = made_.score(truth_, groups).log_likelihood;
    for (Index k = 0; k < size(); ++k) {
      const Coordinate& c = of(k);
      const double most =
          std::min(place_[k] - to_quadratic(c, c.min), to_quadratic(c, c.max) - place_[k]);
      const double typical = std::max(to_quadratic(c, c.scale), std::abs(place_[k]));
      double step = std::min(kFirst * typical, most);
      for (int i = 0; i < kTries && step > 0; ++i) {
        VectorXd by = VectorXd::Zero(size());
        by[k] = step;
        const double fall = 2 * here - made_.score(at(by), groups).log_likelihood -
                            made_.score(at(-by), groups).log_likelihood;
        // Where there is no value so far away, or no change beyond rounding.
        double factor = std::isfinite(fall) ? kMost : 1 / kMost;
        if (std::isfinite(fall) && fall > 0)
          factor = std::clamp(1 / std::sqrt(fall), 1 / kMost, kMost);
        if (factor > 1 / kGoodTo && factor < kGoodTo) break;
        if (factor > 1 && step == most) break;
        step = std::min(step * factor, most);
      }
      steps_[k] = step;
    }
  }

  // Minus second derivatives of the log-likelihood of these groups, by group and in sum.
  std::vector<MatrixXd> by_group(const Groups& groups) const {
    const size_t count = groups.size();
    std::vector<MatrixXd> out(count, MatrixXd::Zero(size(), size()));
    const auto moved = [&](Index i, double a, Index k, double b) {
      VectorXd by = VectorXd::Zero(size());
      by[i] += a * steps_[i], by[k] += b * steps_[k];
      return made_.score(at(by), groups).by_group;
    };
    const std::vector<double> here = made_.score(truth_, groups).by_group;
    for (Index i = 0; i < size(); ++i) {
      if (steps_[i] == 0) continue;
      const auto up = moved(i, 1, i, 0), down = moved(i, -1, i, 0);
      for (size_t g = 0; g < count; ++g)
        out[g](i, i) = (2 * here[g] - up[g] - down[g]) / (steps_[i] * steps_[i]);
      for (Index k = 0; k < i; ++k) {
        if (steps_[k] == 0) continue;
        const auto pp = moved(i, 1, k, 1), pm = moved(i, 1, k, -1), mp = moved(i, -1, k, 1),
                   mm = moved(i, -1, k, -1);
        for (size_t g = 0; g < count; ++g)
          out[g](i, k) = out[g](k, i) =
              (pm[g] + mp[g] - pp[g] - mm[g]) / (4 * steps_[i] * steps_[k]);
      }
    }
    return out;
  }

 private:
  const Coordinate& of(Index k) const { return space_[static_cast<size_t>(k)]; }

  const Problem& made_;
  const Model& truth_;
  ParameterSpace space_;
  VectorXd place_, steps_;
};

// What is less than nothing of it the scatter of the made set did.
MatrixXd no_negative(const MatrixXd& m) {
  const VectorXd scale =
      m.diagonal().unaryExpr([](double own) { return own > 0 ? std::sqrt(own) : 0.0; });
  const VectorXd inverse = scale.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
  const SymmetricEigen eigen = symmetric_eigen(inverse.asDiagonal() * m * inverse.asDiagonal());
  const MatrixXd unit =
      eigen.vectors * eigen.values.cwiseMax(0).asDiagonal() * eigen.vectors.transpose();
  return scale.asDiagonal() * unit * scale.asDiagonal();
}

PartInformation part_of(const MatrixXd& curvature, const VectorXd& way) {
  const MatrixXd information = no_negative(curvature);
  return {information, information * way};
}

MatrixXd sum_of(const std::vector<MatrixXd>& by_group) {
  MatrixXd sum = by_group.front();
  for (size_t g = 1; g < by_group.size(); ++g) sum += by_group[g];
  return sum;
}

// Groups of one regime say the same but for the scatter of this set: each has their mean.
std::vector<PartInformation> parts_of(const Problem& made, const std::vector<MatrixXd>& by_group,
                                      const Groups& groups, const VectorXd& way) {
  std::vector<PartInformation> parts;
  std::vector<char> done(groups.size(), 0);
  std::vector<Groups> regimes = made.regimes();
  regimes.push_back(made.all_groups());  // Of those in none.
  for (const Groups& regime : regimes) {
    MatrixXd sum = MatrixXd::Zero(way.size(), way.size());
    double count = 0;
    for (size_t g = 0; g < groups.size(); ++g) {
      if (!groups[g] || !regime[g] || done[g]) continue;
      sum += by_group[g], ++count, done[g] = 1;
    }
    if (count > 0) parts.insert(parts.end(), static_cast<size_t>(count), part_of(sum / count, way));
  }
  return parts;
}

// How far each unknown moves predictions, in noise of single values: as in judge/material.cc.
MatrixXd movement_of_view(const Problem& made, const Differences& differences, const Score& held,
                          const Groups& groups, const VectorXd& way) {
  const std::string& channel = made.facts().channels.front().name;
  const double noise = held.native.front() / std::max(1.0, held.error());
  std::vector<VectorXd> columns;
  for (Index k = 0; k < differences.size(); ++k) {
    // From neutral where the effect is on its way from there.
    VectorXd up_by = VectorXd::Zero(differences.size()), down_by = up_by;
    up_by[k] = way[k] != 0 ? 0 : differences.steps()[k];
    down_by[k] = way[k] != 0 ? -way[k] : -differences.steps()[k];
    const double step = up_by[k] - down_by[k];
    const ResidualView up = made.residual_view(differences.at(up_by), groups),
                       down = made.residual_view(differences.at(down_by), groups);
    const auto& above = *up.channel(channel);
    const auto& below = *down.channel(channel);
    VectorXd column = VectorXd::Zero(static_cast<Index>(above.residual.size()));
    for (Index i = 0; i < column.size() && step != 0; ++i) {
      const auto at = static_cast<size_t>(i);
      column[i] = (below.residual[at] - above.residual[at]) / noise / step;
    }
    columns.push_back(std::move(column));
  }
  MatrixXd movement(differences.size(), differences.size());
  for (Index i = 0; i < movement.rows(); ++i) {
    for (Index k = 0; k < movement.cols(); ++k) {
      const auto& a = columns[static_cast<size_t>(i)];
      movement(i, k) = a.dot(columns[static_cast<size_t>(k)]) / static_cast<double>(a.size());
    }
  }
  return movement;
}

}  // namespace

double to_quadratic(const Coordinate& c, double z) {
  return enters_by_square(c) ? z * z : z;
}

double quadratic_slope(const Coordinate& c, double z) {
  return enters_by_square(c) ? 1 / (2 * z) : 1;
}

EffectLook look_by_likelihood(const Problem& made, const Model& truth,
                              const std::vector<Unknown>& unknowns, const VectorXd& way,
                              size_t base) {
  Differences differences(made, truth, unknowns);
  const Groups scored = made.scored_groups(), all = made.all_groups();
  differences.find_steps(all);
  EffectLook look{.base = base};
  look.held = parts_of(made, differences.by_group(scored), scored, way);
  const Score held = made.score(truth, scored);
  look.residuals = static_cast<double>(held.n);
  if (made.folds().size() == 1 && scored != all) {
    const MatrixXd trained = sum_of(differences.by_group(made.training_groups()));
    look.trained = part_of(trained, way);
    const PartInformation together = part_of(sum_of(differences.by_group(all)), way);
    const double apart = gain_of(look.whole(), base);
    if (apart > 0) look.together = std::min(1.0, gain_of(together, base) / apart);
  }
  MatrixXd of_gain = MatrixXd::Zero(way.size(), way.size());
  for (const PartInformation& part : look.held) of_gain += part.information;
  look.movement = {of_gain / look.residuals,
                   movement_of_view(made, differences, held, scored, way)};
  return look;
}

}  // namespace seam::measurement
