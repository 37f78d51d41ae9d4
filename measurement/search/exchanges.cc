#include "measurement/search/exchanges.h"

#include <cmath>
#include <vector>

#include "measurement/search/decisions.h"

namespace seam::measurement {

namespace {

std::optional<Grown> exchanged(const Problem& problem, const Grown& grown, const std::string& out,
                               const std::shared_ptr<const EffectDefinition>& in) {
  // What takes the place of another base is exchanged for its like alone: without it the model is
  // none from which a step could tell anything.
  const EffectDefinition& leaving = *grown.assessment.model.find(out)->definition;
  if (leaving.replaces_base != effects::Base::none && in->replaces_base != leaving.replaces_base &&
      (in->term == effects::Term::none || in->term != leaving.replaces_term))
    return std::nullopt;
  Grown smaller = without(grown, out);
  const Score score = problem.score(smaller.assessment.model, problem.all_groups());
  if (score.valid) smaller.assessment.total_ll = score.log_likelihood;
  std::vector<NotTestable> reasons;
  const auto prospect = prospect_of(problem, smaller, in, reasons);
  if (!prospect) return std::nullopt;
  if (std::isfinite(prospect->expected_ll)) {
    const double lost = grown.assessment.total_ll - score.log_likelihood;
    if (score.valid && prospect->expected_ll < grown.assessment.total_ll -
                                                   kReplacementShortfall * lost - kReplacementSlack)
      return std::nullopt;
  }
  auto candidate = fit_prospect(problem, smaller, *prospect, reasons);
  if (!candidate) return std::nullopt;
  return std::move(candidate->grown);
}

// All that an exchange depends on.
std::vector<double> key_of(const Problem& problem, const Grown& grown, const std::string& out,
                           const EffectDefinition& in) {
  std::vector<double> key = {static_cast<double>(problem.times_marked()),
                             grown.assessment.total_ll};
  const auto add = [&](const std::string& text) {
    key.push_back(static_cast<double>(std::hash<std::string>{}(text) >> 12));
  };
  add(out), add(in.name + "\n" + in.source);
  for (const std::string& name : grown.added) add(name);
  for (const Unknown& unknown : grown.assessment.unknowns)
    add(unknown.effect + "." + std::to_string(unknown.parameter));
  for (const effects::ModelEffect& effect : grown.assessment.model.effects()) {
    add(effect.definition->name + "\n" + effect.definition->source);
    for (const double value : effect.values()) key.push_back(value);
  }
  return key;
}

}  // namespace

std::optional<Grown> Exchanges::with_other(
    const Grown& grown, const std::string& out,
    const std::shared_ptr<const EffectDefinition>& in) const {
  return *tried_.of(0, key_of(problem_, grown, out, *in),
                    [&] { return exchanged(problem_, grown, out, in); });
}

}  // namespace seam::measurement
