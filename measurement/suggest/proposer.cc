#include "measurement/suggest/proposer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "measurement/judge/judge.h"
#include "measurement/numerics/regression.h"
#include "measurement/suggest/term_library.h"
#include "sim_core/system/work_tally.h"

namespace seam::measurement {
namespace {

class Proposer {
 public:
  // `independent`: groups share no draws.
  Proposer(const Problem& problem, const Assessment& base, const Vocabulary& vocabulary,
           bool independent)
      : problem_(problem),
        base_(base),
        vocabulary_(vocabulary),
        independent_(independent),
        library_(problem, base.model, vocabulary) {}

  std::optional<Formula> run();
  // The model of a problem with these terms, every coefficient fitted.
  Formula fitted_to(const Problem& problem, const Assessment& base, std::vector<Term> terms) const;

 private:
  std::string name() const;
  Formula fitted(std::vector<Term> terms) const {
    return fitted_to(problem_, base_, std::move(terms));
  }
  bool groups_agree(const Assessment& before, const Assessment& after) const;
  bool supported(const Formula& before, const Formula& after) const;
  bool grows(Formula& found);
  Formula without_needless(Formula found) const;

  const Problem& problem_;
  const Assessment& base_;
  const Vocabulary& vocabulary_;
  const bool independent_;
  TermLibrary library_;
};

std::string Proposer::name() const {
  std::string name = "suggested";
  for (int i = 2; base_.model.has(name); ++i) name = "suggested_" + std::to_string(i);
  return name;
}

// Whether a formula explains nothing, and its last two terms changed little about it: so few terms
// come to no end. By its errors after each term.
bool leads_nowhere(const std::vector<double>& errors) {
  return errors.size() > 2 && errors.back() > kUseless &&
         errors.back() > kPlainlyLess * errors[errors.size() - 3];
}

Formula Proposer::fitted_to(const Problem& problem, const Assessment& base,
                            std::vector<Term> terms) const {
  Formula found{.vocabulary = &vocabulary_, .terms = std::move(terms)};
  if (found.terms.empty()) {
    found.assessment = base;
    return found;
  }
  const std::string effect_name = name();
  const std::string yaml = formula_yaml(effect_name, vocabulary_.stage, "A trial.", found.terms);
  const auto effect = formula_effect(yaml, effect_name);
  const Model model = with_formula(base.model, effect, found.terms);
  std::vector<Unknown> unknowns = base.unknowns;
  for (size_t i = 0; i < effect->parameters.size(); ++i) unknowns.push_back({effect_name, i});
  found.assessment = assess(problem, model, unknowns);
  const auto fit = found.assessment.model.find(effect_name)->values();
  size_t at = 0;
  for (Term& term : found.terms) {
    term.coefficient = std::copysign(1.0, term.coefficient) * fit[at++];
    if (!is_fitted(term.curve)) continue;
    for (double& number : term.numbers) number = fit[at++];
  }
  const double misfit = std::max(1.0, found.assessment.error * found.assessment.error);
  found.merit = found.log_evidence = found.assessment.total_ll;
  for (const Term& term : found.terms) {
    const double price = kPriceOfNumber * std::log(library_.count()) * term.parameters();
    found.merit -= price * misfit;
    found.log_evidence -= price + std::log(library_.looks());
  }
  return found;
}

// Held-out groups, or their blocks, or where these are few all groups: a term that some of them
// alone ask for is no cause of all. Groups that share draws, as a sensor's pattern, agree on these.
bool Proposer::groups_agree(const Assessment& before, const Assessment& after) const {
  const Groups scored = problem_.scored_groups();
  const auto count = static_cast<size_t>(std::count(scored.begin(), scored.end(), 1));
  if (count >= kGroupsForAgreement || !problem_.blocks().empty() || !independent_)
    return root_gain_over_scatter(before.held, after.held, kGroupsForAgreement) > kAgreedFormula;
  const Groups all = problem_.all_groups();
  return root_gain_over_scatter(problem_.score(before.model, all), problem_.score(after.model, all),
                                kGroupsForAgreement) > kAgreedFormula;
}

bool Proposer::supported(const Formula& before, const Formula& after) const {
  if (!after.assessment.valid) return false;
  const Term& last = after.terms.back();
  const double misfit = std::max(1.0, after.assessment.error * after.assessment.error);
  const double ratio = 2 * (after.assessment.total_ll - before.assessment.total_ll) / misfit;
  if (!(chi2_tail(ratio, last.parameters()) * library_.looks() < kAlarm)) return false;
  const double excess = std::pow(before.assessment.error, 2) - 1;
  const double left = std::pow(after.assessment.error, 2) - 1;
  if (before.assessment.error > kMisfit && left > (1 - kLeastOfExcess) * excess) return false;
  // Most groups must gain, and residuals fall in their own units by what is worth reading about: an
  // error in units of a noise that is fitted beside the formula says nothing.
  const bool halves = after.assessment.error < kPlainlyLess * before.assessment.error;
  if (after.assessment.held_ll() <= before.assessment.held_ll() ||
      !(halves || groups_agree(before.assessment, after.assessment)))
    return false;
  const Score& held = after.assessment.held;
  double most = 0;
  for (size_t c = 0; c < held.native.size(); ++c) {
    if (held.native[c] > 0)
      most = std::max(most, 1 - std::pow(held.native[c] / before.assessment.held.native[c], 2));
  }
  return most > kLeastWorthReading;
}

// Terms that later ones have made unnecessary go.
Formula Proposer::without_needless(Formula found) const {
  for (size_t i = 0; i < found.terms.size() && found.terms.size() > 1;) {
    std::vector<Term> fewer = found.terms;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
    Formula smaller = fitted(std::move(fewer));
    if (smaller.assessment.valid && smaller.merit >= found.merit) {
      found = std::move(smaller), i = 0;
    } else {
      ++i;
    }
  }
  return found;
}

// Whether a term is supported beside those found, which it then joins: the first that is, or one
// with fewer numbers that does as well.
bool Proposer::grows(Formula& found) {
  std::optional<Formula> best;
  for (const Term& term : library_.best_terms(found.assessment)) {
    if (best && term.parameters() >= best->terms.back().parameters()) continue;
    std::vector<Term> more = found.terms;
    more.push_back(term);
    Formula next = fitted(std::move(more));
    if (supported(found, next) && (!best || next.merit > best->merit)) best = std::move(next);
  }
  if (best) found = *std::move(best);
  return best.has_value();
}

std::optional<Formula> Proposer::run() {
  if (!library_.valid()) return std::nullopt;
  const Work work("parts of the formula", kMostTerms + 1, Work::Of::at_most);
  Formula found = fitted({});
  std::vector<double> errors = {found.assessment.error};
  while (found.terms.size() < kMostTerms && !leads_nowhere(errors)) {
    work.done();
    if (!grows(found) || found.assessment.error < 1) break;  // Then no more than noise is left.
    errors.push_back(found.assessment.error);
  }
  return found.terms.empty() ? std::nullopt : std::optional(without_needless(std::move(found)));
}

}  // namespace

std::optional<Formula> formula_of(const Problem& problem, const Assessment& base,
                                  const Vocabulary& vocabulary) {
  const Problem& seen = problem.with_residuals();
  const bool independent = problem.groups_are_independent(base.model);
  if (&seen == &problem) return Proposer(problem, base, vocabulary, independent).run();
  // Built from residuals that are means, and then fitted to what they are means of.
  std::vector<Unknown> of_mean;
  for (const Unknown& unknown : base.unknowns) {
    if (!base.model.find(unknown.effect)->definition->spread_only) of_mean.push_back(unknown);
  }
  const Assessment shown = assess(seen, base.model, of_mean);
  Proposer proposer(seen, shown, vocabulary, independent);
  auto found = proposer.run();
  if (!found) return std::nullopt;
  Formula told = proposer.fitted_to(problem, base, std::move(found->terms));
  return told.assessment.valid ? std::optional(std::move(told)) : std::nullopt;
}

}  // namespace seam::measurement
