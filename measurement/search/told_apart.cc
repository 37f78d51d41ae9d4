#include "measurement/search/told_apart.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "effects/questions.h"
#include "measurement/fitting/parameter_space.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/span.h"

namespace seam::measurement {
namespace {

std::string name_of(const Model& model, const Unknown& unknown) {
  return unknown.effect + "." +
         model.find(unknown.effect)->definition->parameters[unknown.parameter].name;
}

// The parameters whose columns together make up this one: those that take part in the sum with a
// tenth of its length or more.
std::vector<std::string> makers_of(const std::vector<double>& column,
                                   const std::vector<std::vector<double>>& columns,
                                   const std::vector<std::string>& names) {
  constexpr double kTakesPart = 0.1;
  const auto n = static_cast<Eigen::Index>(columns.size());
  Eigen::MatrixXd gram(n, n);
  Eigen::VectorXd right(n);
  for (Eigen::Index a = 0; a < n; ++a) {
    const double size = length(columns[a]);
    right[a] = dot(columns[a], column) / size;
    for (Eigen::Index b = 0; b < n; ++b)
      gram(a, b) = dot(columns[a], columns[b]) / (size * length(columns[b]));
  }
  const Eigen::VectorXd share = solve_any_rank(gram, right);
  std::vector<std::string> makers;
  for (Eigen::Index a = 0; a < n; ++a) {
    if (std::abs(share[a]) > kTakesPart * length(column)) makers.push_back(names[a]);
  }
  return makers;
}

// Where a step of Gauss and Newton against these changes of the unknowns' values ends.
Model moved_by(const Model& model, const std::vector<Unknown>& unknowns,
               const std::vector<double>& against) {
  const ParameterSpace space(model, unknowns);
  const Eigen::VectorXd place = space.place(model);
  Eigen::VectorXd by(place.size());
  for (Eigen::Index i = 0; i < by.size(); ++i) {
    const auto k = static_cast<size_t>(i);
    by[i] = -against[k] / space[k].slope(place[i]);  // Limits are fitted by their reciprocals.
  }
  return space.moved(model, by);
}

}  // namespace

std::vector<Unknown> told_apart(const Problem& problem, const Model& model,
                                const std::vector<Unknown>& unknowns,
                                std::vector<NotTestable>& untold) {
  std::vector<Unknown> told, mean;
  for (const Unknown& unknown : unknowns) {
    const bool spread = model.find(unknown.effect)->definition->spread_only;
    (spread ? told : mean).push_back(unknown);
  }
  std::stable_partition(mean.begin(), mean.end(), [&](const Unknown& unknown) {
    return model.find(unknown.effect)->parameters[unknown.parameter].refitted();
  });
  const Evaluation here = problem.evaluate(model, problem.all_groups());
  if (!here.valid || here.whitened.empty()) return unknowns;
  const auto columns = problem.jacobian(model, mean, problem.all_groups(), here);
  Span span;
  std::vector<std::vector<double>> kept;
  std::vector<std::string> names;
  for (size_t k = 0; k < mean.size(); ++k) {
    std::vector<double> left = columns[k];
    const double before = span.take_out_of(left);
    if (before > 0 && length(left) > kUntold * before) {
      span.add(left);
      kept.push_back(columns[k]), names.push_back(name_of(model, mean[k]));
      told.push_back(mean[k]);
      continue;
    }
    const effects::Parameter& parameter =
        model.find(mean[k].effect)->definition->parameters[mean[k].parameter];
    const std::string why = before > 0
                                ? fmt::format("these data do not tell it from {}",
                                              fmt::join(makers_of(columns[k], kept, names), ", "))
                                : "it does not change the prediction of these data";
    untold.push_back({mean[k].effect, parameter.name, why});
  }
  return told;
}

namespace {

// Control points of a lens at which hardly any point lies would wander far: they count as not seen.
void blank_hardly_seen(size_t first, std::vector<std::vector<double>>& columns) {
  // Of the one that moves residuals most. Of six shares from a thirtieth to a fifth, and none, over
  // made lenses the one with the smallest errors in views left out.
  constexpr double kLeast = 0.03;
  double most = 0;
  for (size_t k = first; k < columns.size(); ++k) most = std::max(most, length(columns[k]));
  for (size_t k = first; k < columns.size(); ++k) {
    if (length(columns[k]) < kLeast * most) std::fill(columns[k].begin(), columns[k].end(), 0);
  }
}

}  // namespace

std::vector<size_t> testable_parameters(const Problem& problem, const Model& model,
                                        const std::vector<Unknown>& others,
                                        const EffectDefinition& effect, const Groups& groups,
                                        const Evaluation* near, std::vector<NotTestable>& reasons,
                                        LinearStep& step) {
  std::vector<size_t> open;
  for (size_t i = 0; i < effect.parameters.size(); ++i) {
    if (effect.parameters[i].integer || effect.parameters[i].stated) continue;
    const std::string why = problem.not_testable(model, effect, i);
    if (why.empty()) {
      open.push_back(i);
    } else {
      reasons.push_back({effect.name, effect.parameters[i].name, why});
    }
  }
  // What takes the place of another begins far from it, unless predictions are so dear that a start
  // like the other was sought.
  const bool dear = problem.screening_groups().has_value();
  const bool like = dear || effects::is_any_lens(effect);
  if (effect.spread_only || open.empty() || !(effect.has_neutral || like)) return open;
  std::vector<Unknown> unknowns = others;
  for (const size_t i : open) unknowns.push_back({effect.name, i});
  const Evaluation here = problem.evaluate(model, groups, near);
  if (!here.valid) return open;
  auto columns = problem.jacobian(model, unknowns, groups, here);
  if (effects::is_any_lens(effect)) blank_hardly_seen(others.size(), columns);
  // What is left of each column is its leverage.
  std::vector<size_t> testable;
  Span span;
  double gain = 0;
  std::vector<Unknown> kept;
  std::vector<double> parts;
  for (size_t k = 0; k < unknowns.size(); ++k) {
    std::vector<double>& column = columns[k];
    const double before = span.take_out_of(column, &parts);
    const double after = length(column);
    const bool candidate = k >= others.size();
    const size_t parameter = unknowns[k].parameter;
    const double width =
        candidate ? effect.parameters[parameter].max - effect.parameters[parameter].min : 0;
    if (before <= 0 || after < kAbsorbed * before) {
      if (candidate) {
        reasons.push_back({effect.name, effect.parameters[parameter].name,
                           before <= 0 ? "it does not change the prediction of these data"
                                       : "other free parameters absorb it"});
      }
      continue;
    }
    if (candidate && after * width < kLeastReach) {
      reasons.push_back({effect.name, effect.parameters[parameter].name,
                         "these data could not see it at any size in its bounds"});
      continue;
    }
    const double along = dot(column, here.whitened) / after;
    gain += 0.5 * along * along;
    span.add(column, parts);
    kept.push_back(unknowns[k]);
    if (candidate) testable.push_back(parameter);
  }
  if (testable.empty()) return testable;
  step.to = moved_by(model, kept, span.steps_to(here.whitened));
  if (!problem.is_smooth(model)) return testable;
  step.expected_ll = log_likelihood_of(problem, here) + gain;
  return testable;
}

namespace {

// By unknown: how many times worse it is known beside the others than alone.
std::vector<double> worse_beside_others(const Fit& fit) {
  const auto n = static_cast<Eigen::Index>(fit.sigma.size());
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(n, n);
  const Eigen::Map<const Eigen::MatrixXd> covariance(fit.covariance.data(), n, n);
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = 0; b < n; ++b) {
      const double size = std::sqrt(covariance(a, a) * covariance(b, b));
      if (a != b && size > 0) correlation(a, b) = covariance(a, b) / size;
    }
  }
  constexpr double kFloor = 1e-14;
  const Eigen::MatrixXd information = floored_inverse(correlation, kFloor);
  std::vector<double> worse;
  for (Eigen::Index a = 0; a < n; ++a) worse.push_back(std::sqrt(information(a, a)));
  return worse;
}

// The same model with one value of an effect at neutral and others of it free, fitted again.
// Nothing where that costs likelihood, or where those are not told either.
std::optional<Assessment> as_good_without(const Problem& problem, const Assessment& here,
                                          const Unknown& out, const std::vector<Unknown>& in) {
  constexpr double kNothing = 2;  // In units of the misfit: what one needless number gains.
  const EffectDefinition& effect = *here.model.find(out.effect)->definition;
  Model model = here.model;
  model.set_value(out.effect, out.parameter, effect.parameters[out.parameter].neutral);
  std::vector<Unknown> rest = here.unknowns;
  std::erase(rest, out);
  rest.insert(rest.end(), in.begin(), in.end());
  Assessment less = assess(problem, model, rest);
  const double unit = std::max(1.0, here.error * here.error);
  if (!less.valid || !(less.total_ll > here.total_ll - kNothing * unit)) return std::nullopt;
  for (const Unknown& unknown : in) {
    const size_t k = *index_of(less.unknowns, unknown);
    const double neutral = effect.parameters[unknown.parameter].neutral;
    if (!(less.fit.sigma[k] < std::abs(less.fit.value[k] - neutral))) return std::nullopt;
  }
  return less;
}

// The effect's values, those that go first where several do the same at the front: those with the
// widest bounds, which are coefficients of the highest powers, and of these the last.
std::vector<size_t> first_to_go(const EffectDefinition& effect) {
  std::vector<size_t> order(effect.parameters.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = order.size() - 1 - i;
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return effect.parameters[a].max > effect.parameters[b].max;
  });
  return order;
}

// Values of the effect that would go after this one and are at neutral though the data might tell
// them.
std::vector<Unknown> left_out_before(const Problem& problem, const Assessment& here,
                                     const Unknown& unknown) {
  const EffectDefinition& effect = *here.model.find(unknown.effect)->definition;
  const std::vector<size_t> order = first_to_go(effect);
  std::vector<Unknown> left_out;
  for (auto at = std::find(order.begin(), order.end(), unknown.parameter); at != order.end();
       ++at) {
    const effects::Parameter& parameter = effect.parameters[*at];
    if (parameter.integer || parameter.stated || parameter.on_demand ||
        index_of(here.unknowns, {unknown.effect, *at}) ||
        !problem.not_testable(here.model, effect, *at).empty())
      continue;
    left_out.push_back({unknown.effect, *at});
  }
  return left_out;
}

// The first value of the effect that hangs on others, and without which nothing is lost, gone.
std::optional<Assessment> one_less(const Problem& problem, const Assessment& here,
                                   const std::string& name) {
  const auto of_it = [&](const Unknown& unknown) { return unknown.effect == name; };
  if (std::count_if(here.unknowns.begin(), here.unknowns.end(), of_it) < 2) return std::nullopt;
  const std::vector<double> worse = worse_beside_others(here.fit);
  double most = 0;  // Of the effect's values: where one hangs on the others, these hang on it.
  for (size_t k = 0; k < worse.size(); ++k) {
    if (of_it(here.unknowns[k])) most = std::max(most, worse[k]);
  }
  for (const size_t i : first_to_go(*here.model.find(name)->definition)) {
    const Unknown unknown{name, i};
    const auto at = index_of(here.unknowns, unknown);
    if (!at) continue;
    const std::vector<Unknown> in = left_out_before(problem, here, unknown);
    std::optional<Assessment> less;
    if (!in.empty()) less = as_good_without(problem, here, unknown, in);
    if (!less && worse[*at] > kMayHangOnOthers && (most > kHangsOnOthers || !in.empty()))
      less = as_good_without(problem, here, unknown, {});
    if (less) return less;
  }
  return std::nullopt;
}

}  // namespace

Grown less_tangled(const Problem& problem, Grown grown) {
  if (!problem.is_smooth(grown.assessment.model) || problem.screening_groups()) return grown;
  for (const std::string& name : grown.added) {
    Assessment& here = grown.assessment;
    if (!here.model.find(name)->definition->has_neutral) continue;
    while (auto less = one_less(problem, here, name)) here = *std::move(less);
  }
  return grown;
}

}  // namespace seam::measurement
