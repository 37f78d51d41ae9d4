#include "measurement/judge/doubted.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "effects/questions.h"
#include "measurement/judge/decisions.h"
#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {
namespace {

using Doubts = std::vector<std::vector<std::string>>;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const effects::Parameter& parameter_of(const Assessment& assessment, const Unknown& unknown) {
  return assessment.model.find(unknown.effect)->definition->parameters[unknown.parameter];
}

size_t place_of(const std::vector<std::string>& named, const std::string& effect) {
  return static_cast<size_t>(std::find(named.begin(), named.end(), effect) - named.begin());
}

// Values where their range ends, or beyond what people have by more than their error.
void doubt_values(const Assessment& best, const std::vector<std::string>& named, Doubts& doubts) {
  for (size_t k = 0; k < best.unknowns.size(); ++k) {
    const size_t place = place_of(named, best.unknowns[k].effect);
    if (place == named.size()) continue;
    const effects::Parameter& parameter = parameter_of(best, best.unknowns[k]);
    const double value =
        best.model.find(named[place])->parameters[best.unknowns[k].parameter].value;
    const effects::Plausible& plausible = parameter.plausible;
    const double sigma = k < best.fit.sigma.size() ? best.fit.sigma[k] : 0;
    const double beyond = std::max(plausible.min - value, value - plausible.max);
    if (is_at_bound(parameter, value)) {
      doubts[place].push_back(
          fmt::format("{} = {:.6g} is at the end of its range", parameter.name, value));
    } else if (!plausible.source.empty() && std::isfinite(value) && beyond > kWithinError * sigma) {
      doubts[place].push_back(fmt::format("{} = {:.3g} is beyond the plausible {:g} to {:g}",
                                          parameter.name, value, plausible.min, plausible.max));
    }
  }
}

// Effects each of which moves predictions far, and all of them together hardly.
void doubt_cancelling(const Problem& problem, const Assessment& best, const Evaluation& here,
                      const std::vector<std::string>& named, Doubts& doubts) {
  std::vector<size_t> movers;
  Model bare = best.model;
  for (size_t k = 0; k < named.size(); ++k) {
    if (!can_be_missed(best.model, named[k]) || best.model.find(named[k])->definition->spread_only)
      continue;
    movers.push_back(k);
    bare.remove(named[k]);
  }
  if (movers.size() < 2) return;
  const auto moves = [&](const Model& model) {
    const Evaluation there = problem.evaluate(model, problem.all_groups(), &here);
    double sum2 = 0, count = 0;
    for (size_t i = 0; there.valid && i < here.used.size(); ++i) {
      if (!here.used[i] || !there.used[i]) continue;
      sum2 += std::pow((there.residual[i] - here.residual[i]) / here.sigma[i], 2), ++count;
    }
    return count > 0 ? std::sqrt(sum2 / count) : NAN;
  };
  const double together = moves(bare);
  for (const size_t k : movers) {
    Model less = best.model;
    less.remove(named[k]);
    const double alone = moves(less);
    if (alone > kMaterial && together < kCancelled * alone)
      doubts[k].push_back(
          fmt::format("others cancel it: it moves predictions by {:.2g} x noise, all effects found "
                      "together by {:.2g}",
                      alone, together));
  }
}

// The information that each group has of the parameters of the mean, scaled so that all together
// have a unit diagonal, and how it pulls them.
struct Pulls {
  std::vector<size_t> unknowns;  // Of the assessment.
  VectorXd scale;
  std::vector<MatrixXd> information;  // By group.
  std::vector<VectorXd> slope;
  double misfit = 1;
};

Pulls pulls_of(const Problem& problem, const Assessment& best, const Evaluation& here) {
  Pulls pulls;
  std::vector<Unknown> unknowns;
  for (size_t k = 0; k < best.unknowns.size() && k < best.fit.sigma.size(); ++k) {
    const bool spread = best.model.find(best.unknowns[k].effect)->definition->spread_only;
    if (spread || best.fit.at_bound[k] || !std::isfinite(best.fit.sigma[k]) ||
        !(best.fit.sigma[k] > 0))
      continue;
    pulls.unknowns.push_back(k);
    unknowns.push_back(best.unknowns[k]);
  }
  if (unknowns.empty()) return pulls;
  const auto columns = problem.jacobian(best.model, unknowns, problem.all_groups(), here);
  const auto count = static_cast<Index>(unknowns.size());
  const size_t groups = problem.facts().groups.size();
  pulls.scale = VectorXd::Zero(count);
  for (Index k = 0; k < count; ++k) {
    const auto& column = columns[static_cast<size_t>(k)];
    pulls.scale[k] =
        1 /
        std::max(
            1e-300,
            Eigen::Map<const VectorXd>(column.data(), static_cast<Index>(column.size())).norm());
  }
  pulls.information.assign(groups, MatrixXd::Zero(count, count));
  pulls.slope.assign(groups, VectorXd::Zero(count));
  VectorXd row(count);
  double sum2 = 0, used = 0;
  for (size_t i = 0; i < problem.facts().scalars(); ++i) {
    if (!here.used[i]) continue;
    for (Index k = 0; k < count; ++k) row[k] = pulls.scale[k] * columns[static_cast<size_t>(k)][i];
    const auto group = static_cast<size_t>(problem.facts().group_of(i));
    pulls.information[group].noalias() += row * row.transpose();
    pulls.slope[group] += here.whitened[i] * row;
    sum2 += here.whitened[i] * here.whitened[i], ++used;
  }
  pulls.misfit = std::max(1.0, std::sqrt(sum2 / std::max(used, 1.0)));
  return pulls;
}

// How far a value is from where it does nothing.
double size_of(const Assessment& best, size_t unknown) {
  const double neutral = parameter_of(best, best.unknowns[unknown]).neutral;
  return std::abs(best.fit.value[unknown] - (std::isfinite(neutral) ? neutral : 0));
}

// Values that one group alone makes: without it one step of Gauss and Newton leads many of their
// errors away, and farther than chance lets so much information lead.
void doubt_single_groups(const Problem& problem, const Assessment& best, const Evaluation& here,
                         const std::vector<std::string>& named, Doubts& doubts) {
  // Of two groups none is the odd one.
  if (problem.facts().groups.size() < 3 || !problem.groups_are_independent(best.model)) return;
  const Pulls pulls = pulls_of(problem, best, here);
  if (pulls.unknowns.empty()) return;
  MatrixXd all = MatrixXd::Zero(pulls.scale.size(), pulls.scale.size());
  for (const MatrixXd& information : pulls.information) all += information;
  constexpr double kFloor = 1e-9;  // Of the information that a parameter has alone.
  const VectorXd variance = floored_inverse(all, kFloor).diagonal();
  std::vector<double> most(named.size(), kManyErrors);
  std::vector<std::string> text(named.size());
  for (size_t group = 0; group < pulls.slope.size(); ++group) {
    const MatrixXd without = floored_inverse(all - pulls.information[group], kFloor);
    const VectorXd step = without * pulls.slope[group];
    for (size_t k = 0; k < pulls.unknowns.size(); ++k) {
      const size_t unknown = pulls.unknowns[k];
      const size_t place = place_of(named, best.unknowns[unknown].effect);
      const auto at = static_cast<Index>(k);
      const double chance =
          pulls.misfit * std::sqrt(std::max(without(at, at) - variance[at], 1e-12));
      const double moved = std::abs(step[at]) * pulls.scale[at];
      const double errors = moved / best.fit.sigma[unknown];
      if (place == named.size() || std::abs(step[at]) < kManyScatters * chance ||
          moved < kMadeShare * size_of(best, unknown) || !(errors > most[place]))
        continue;
      most[place] = errors;
      text[place] = fmt::format("{} moves by {:.2g} of its errors without {}",
                                parameter_of(best, best.unknowns[unknown]).name, errors,
                                problem.facts().groups[group]);
    }
  }
  for (size_t k = 0; k < named.size(); ++k) {
    if (!text[k].empty()) doubts[k].push_back(text[k]);
  }
}

}  // namespace

bool can_be_missed(const Model& model, const std::string& effect) {
  const EffectDefinition& record = *model.find(effect)->definition;
  return record.has_neutral && record.companions.empty() && record.base == effects::Base::none &&
         record.replaces_base == effects::Base::none && record.replaces_terms.empty() &&
         !effects::has_dependents(model, effect);
}

bool is_at_bound(const effects::Parameter& parameter, double value) {
  // An infinite limit is no end of a range: the effect is absent there.
  const bool at_end = value <= parameter.min || value >= parameter.max;
  return at_end && std::isfinite(value) && value != parameter.neutral;
}

std::vector<std::vector<std::string>> doubts_of(const Problem& problem, const Assessment& best,
                                                const std::vector<std::string>& named) {
  Doubts doubts(named.size());
  if (named.empty()) return doubts;
  doubt_values(best, named, doubts);
  const Evaluation here = problem.evaluate(best.model, problem.all_groups());
  if (!here.valid || here.used.empty()) return doubts;
  doubt_cancelling(problem, best, here, named, doubts);
  doubt_single_groups(problem, best, here, named, doubts);
  return doubts;
}

}  // namespace seam::measurement
