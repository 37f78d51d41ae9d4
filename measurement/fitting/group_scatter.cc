#include "measurement/fitting/group_scatter.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "measurement/fitting/parameter_space.h"
#include "measurement/numerics/curvature.h"
#include "measurement/numerics/regression.h"

namespace seam::measurement {
namespace {

constexpr size_t kLeastGroups = 4;
constexpr size_t kParts = 8;     // Of fewer groups, all together.
constexpr double kFloor = 1e-9;  // Of the information that a parameter has alone.

Eigen::Index place_of(size_t i) {
  return static_cast<Eigen::Index>(i);
}

// What one group says of the parameters, or one part of it.
struct Word {
  Eigen::MatrixXd information;
  Eigen::VectorXd slope;
};

// Into how many stretches each group is cut: one, but where groups are few.
size_t parts_of_each(const Groups& groups) {
  const auto count = static_cast<size_t>(std::count(groups.begin(), groups.end(), 1));
  return count > 0 && count < kLeastGroups ? kParts / count : 1;
}

// The part of each row, numbered through all groups.
std::vector<size_t> parts_of(const Facts& facts, const Groups& groups) {
  const size_t of_group = parts_of_each(groups);
  std::vector<size_t> rows(groups.size(), 0), part;
  for (const int group : facts.group_of_row) ++rows[static_cast<size_t>(group)];
  std::vector<size_t> before(groups.size(), 0);
  for (const int row_group : facts.group_of_row) {
    const auto group = static_cast<size_t>(row_group);
    part.push_back(group * of_group + before[group]++ * of_group / rows[group]);
  }
  return part;
}

std::vector<Word> words_of(const Problem& problem, const Model& model,
                           const std::vector<Unknown>& unknowns, const Groups& groups) {
  const Evaluation here = problem.evaluate(model, groups);
  // Draws that are estimated count as residuals do, and of no group is known which are its own.
  const bool draws = here.whitened.size() > here.used.size();
  if (!here.valid || here.used.empty() || draws) return {};
  const auto columns = problem.jacobian(model, unknowns, groups, here);
  const Eigen::Index count = place_of(unknowns.size());
  const Word silent{Eigen::MatrixXd::Zero(count, count), Eigen::VectorXd::Zero(count)};
  const std::vector<size_t> part_of_row = parts_of(problem.facts(), groups);
  std::vector<Word> all(groups.size() * parts_of_each(groups), silent);
  Eigen::VectorXd row(count);
  for (size_t i = 0; i < here.whitened.size(); ++i) {
    if (!here.used[i]) continue;
    for (size_t k = 0; k < unknowns.size(); ++k) row[place_of(k)] = columns[k][i];
    Word& word = all[part_of_row[static_cast<size_t>(problem.facts().row_of[i])]];
    word.information.noalias() += row * row.transpose();
    word.slope += here.whitened[i] * row;
  }
  std::erase_if(all, [](const Word& word) { return word.information.isZero(0); });
  return all;
}

// So many times the variance that the noise leaves is the groups' by chance in one of 200 cases.
double largest_by_chance(size_t groups) {
  constexpr double kSigmas = 2.576;
  const auto freedom = static_cast<double>(groups - 1);
  return chi2_at(kSigmas, freedom) / freedom;
}

// Variances of the parameters; empty where groups cannot tell.
std::vector<double> sandwich(const std::vector<Word>& words) {
  if (words.size() < kLeastGroups) return {};  // Too few rows.
  Word whole = words.front();
  for (size_t g = 1; g < words.size(); ++g) {
    whole.information += words[g].information;
    whole.slope += words[g].slope;
  }
  const Eigen::MatrixXd inverse = covariance_of(whole.information, kFloor).matrix;
  const auto count = static_cast<double>(words.size());
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(inverse.rows());
  for (const Word& word : words) {
    // The fit stands where all slopes together vanish, but for what its last step left.
    const Eigen::VectorXd step = inverse * (word.slope - whole.slope / count);
    if (!step.allFinite()) return {};
    variance += count / (count - 1) * step.cwiseAbs2();
  }
  return {variance.begin(), variance.end()};
}

}  // namespace

double widen_by_group_scatter(const Problem& problem, double adequate, Assessment& assessment) {
  Fit& fit = assessment.fit;
  if (!problem.groups_are_independent(assessment.model)) return 1;
  const ParameterSpace space(assessment.model, assessment.unknowns);
  std::vector<Unknown> unknowns;
  std::vector<size_t> places;
  for (size_t i = 0; i < space.size(); ++i) {
    // What stands at a bound, or has no error that could be widened, stays as it is.
    if (space[i].spread || fit.at_bound[i] || !std::isfinite(fit.value[i]) || !(fit.sigma[i] > 0) ||
        !std::isfinite(fit.sigma[i]))
      continue;
    unknowns.push_back(assessment.unknowns[i]);
    places.push_back(i);
  }
  if (unknowns.empty()) return 1;
  // Where one part of the groups is held out once for all, the fit has seen the others alone.
  const Groups seen =
      problem.folds().size() == 1 ? problem.training_groups() : problem.all_groups();
  const bool misses = assessment.error > adequate;
  if (!misses && parts_of_each(seen) > 1) return 1;
  const std::vector<Word> words = words_of(problem, assessment.model, unknowns, seen);
  const std::vector<double> variance = sandwich(words);
  // At the noise residuals of a group may go together all the same, as those of coarse counts do.
  const double least = misses || variance.empty() ? 1 : largest_by_chance(words.size());
  double widest = 1;
  for (size_t k = 0; k < variance.size(); ++k) {
    const double wider = std::sqrt(std::max(0.0, variance[k])) / fit.sigma[places[k]];
    if (!(wider * wider > least)) continue;
    widest = std::max(widest, wider);
    fit.sigma[places[k]] *= wider;
    for (size_t i = 0; i < space.size(); ++i) {
      fit.covariance[places[k] * space.size() + i] *= wider;
      fit.covariance[i * space.size() + places[k]] *= wider;
    }
  }
  return widest;
}

}  // namespace seam::measurement
