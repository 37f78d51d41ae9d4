#include "measurement/search/without_name.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/judge/doubted.h"
#include "measurement/search/choice.h"
#include "measurement/search/kept.h"
#include "measurement/search/order.h"

namespace seam::measurement {
namespace {

// The model given, and with each further step.
std::vector<Grown> explanations_of(const SearchResult& result) {
  std::vector<Grown> grown = {result.base};
  for (const Step& step : result.steps) {
    grown.push_back({grown.back().added, step.after});
    grown.back().added.push_back(step.effect);
  }
  grown.back() = result.best;
  return grown;
}

// Steps from this one on imitate a cause without a name.
void end_steps_at(size_t count, const Grown& best, SearchResult& result) {
  if (count == result.steps.size()) return;
  const auto first = result.steps.begin() + static_cast<std::ptrdiff_t>(count);
  std::vector<std::string> mimics;
  for (auto step = first; step != result.steps.end(); ++step) mimics.push_back(step->effect);
  result.mimics.insert(result.mimics.begin(), mimics.begin(), mimics.end());
  if (result.mimics.size() == mimics.size()) result.mimics_error = result.best.assessment.error;
  result.steps.erase(first, result.steps.end());
  result.best = best;
  result.kept.clear();
}

// Whether a cause without a name is ahead of the last explanation, all of whose causes have names.
// A mean need only be ahead of a spread, which says nothing of the cause.
bool explains_better(double lead, bool of_mean) {
  return lead > (of_mean ? kUnnamedWidth : 0);
}

// Whether all that the last has beside an earlier one moves predictions.
bool adds_means_alone(const Grown& earlier, const Grown& last) {
  return std::all_of(last.added.begin(), last.added.end(), [&](const std::string& name) {
    const effects::ModelEffect* effect = last.assessment.model.find(name);
    return earlier.assessment.model.has(name) || effect == nullptr ||
           !effect->definition->spread_only;
  });
}

// The steps that are left, each fitted with those before it.
void fit_steps_again(const Problem& problem, SearchResult& result) {
  Grown part = result.best;
  for (size_t left = result.steps.size(); left > 0; --left) {
    Step& step = result.steps[left - 1];
    step.after = part.assessment;
    step.error_after = part.assessment.error;
    step.error_before = result.base.assessment.error;
    if (left < result.steps.size()) result.steps[left].error_before = step.error_after;
    if (left == 1) break;
    part = without(part, step.effect);
    part.assessment = assess(problem, part.assessment.model, part.assessment.unknowns);
  }
}

Grown fitted_without(const Problem& problem, const Grown& best,
                     const std::vector<std::string>& names) {
  Grown less = best;
  for (const std::string& name : names) less = without(less, name);
  less.assessment = assess(problem, less.assessment.model, less.assessment.unknowns);
  return less;
}

void erase_steps(const Problem& problem, const std::vector<std::string>& names, Grown best,
                 SearchResult& result) {
  std::erase_if(result.steps, [&](const Step& step) {
    return std::find(names.begin(), names.end(), step.effect) != names.end();
  });
  result.best = std::move(best);
  result.kept.clear();
  fit_steps_again(problem, result);
}

// Steps of the mean without which the model can be, of those that `asks` for.
std::vector<std::string> steps_in_question(const SearchResult& result, const auto& asks) {
  const Model& model = result.best.assessment.model;
  std::vector<std::string> names;
  for (const Step& step : result.steps) {
    const effects::ModelEffect* effect = model.find(step.effect);
    if (effect != nullptr && !effect->definition->unknown_cause &&
        !effect->definition->spread_only && can_be_missed(model, step.effect) && asks(step))
      names.push_back(step.effect);
  }
  return names;
}

// Steps that smooth functions can take the place of go, where the functions then explain something
// and leave no more than `most_left`. Returns whether they went.
bool leave_out(const Problem& problem, const std::vector<std::string>& names, double most_left,
               const KnownCauses& known, SearchResult& result) {
  Grown less = fitted_without(problem, result.best, names);
  if (!less.assessment.valid) return false;
  auto cause = unnamed_beside(problem, {less}, result.material, known);
  if (!cause || cause->error_after > most_left) return false;
  if (result.mimics.empty()) result.mimics_error = result.best.assessment.error;
  result.mimics.insert(result.mimics.begin(), names.begin(), names.end());
  erase_steps(problem, names, std::move(less), result);
  result.unnamed = std::move(cause);
  result.unnamed->beside = result.steps.size();
  return true;
}

// Beside a cause without a name a step may only stand for what smooth functions miss of it: one
// after another those go of which the least is their own. What moves far more than the cause does
// is no part of it.
void leave_out_mimics(const Problem& problem, const KnownCauses& known, SearchResult& result) {
  const double far = kFarAboveUnnamed * result.unnamed->noise_units;
  std::vector<std::string> names =
      steps_in_question(result, [&](const Step& step) { return !(step.moved >= far); });
  while (!names.empty()) {
    std::vector<std::vector<std::string>> each;
    for (const std::string& name : names) each.push_back({name});
    const std::vector<double> own = own_shares(problem, result.best.assessment, each);
    const auto least = std::min_element(own.begin(), own.end());
    if (!(*least < kOwnBesideUnnamed)) return;
    const auto mimic = names.begin() + (least - own.begin());
    leave_out(problem, {*mimic}, std::numeric_limits<double>::infinity(), known, result);
    names.erase(mimic);
  }
}

// How many of the first steps are none of spread: beside a spread, which takes whatever mean is
// left, a formula has little to take, and is dear to fit.
size_t steps_of_mean(const SearchResult& result) {
  const auto spread = std::find_if(result.steps.begin(), result.steps.end(), [](const Step& step) {
    const effects::ModelEffect* effect = step.after.model.find(step.effect);
    return effect != nullptr && effect->definition->spread_only;
  });
  return static_cast<size_t>(spread - result.steps.begin());
}

// Whether the model has noise that an earlier one lacks. What begins with noise, while a mean is
// missing, has it far too wide, and is no explanation to hold another against.
bool adds_noise(const Grown& earlier, const Grown& last) {
  return std::any_of(last.added.begin(), last.added.end(), [&](const std::string& name) {
    const effects::ModelEffect* effect = last.assessment.model.find(name);
    return !earlier.assessment.model.has(name) && effect != nullptr &&
           only_widens(*effect->definition);
  });
}

// Whether the model has more than an earlier one, and all of that is noise of unknown cause.
bool adds_noise_alone(const Grown& earlier, const Grown& last) {
  return earlier.added.size() < last.added.size() &&
         std::all_of(last.added.begin(), last.added.end(), [&](const std::string& name) {
           const effects::ModelEffect* effect = last.assessment.model.find(name);
           return earlier.assessment.model.has(name) ||
                  (effect != nullptr && effect->definition->unknown_cause);
         });
}

}  // namespace

std::optional<UnnamedCause> unnamed_beside(const Problem& problem, const std::vector<Grown>& grown,
                                           double material, const KnownCauses& known) {
  std::vector<Explanation> explanations;
  for (const Grown& g : grown)
    explanations.push_back({&g.assessment, merit_of(g), adds_noise_alone(g, grown.back())});
  auto cause = unnamed_cause(problem, explanations, material, known);
  if (cause && !explains_better(cause->lead, adds_means_alone(grown[cause->beside], grown.back())))
    cause.reset();
  return cause;
}

bool explained_without_name(const Problem& problem, const std::vector<Grown>& grown,
                            double material, const KnownCauses& known) {
  const auto cause = unnamed_beside(problem, grown, material, known);
  return cause && cause->error_after < kMisfit;
}

bool names_imitate(const Problem& problem, const std::vector<Grown>& way, double material,
                   const KnownCauses& known) {
  constexpr size_t kLeast = 3;  // The first step may stand for several effects.
  if (way.size() < kLeast || adds_noise(way[0], way[1])) return false;
  const auto cause = unnamed_beside(problem, way, material, known);
  return cause && cause->error_after < kMisfit && cause->beside + 1 < way.size();
}

void look_for_unnamed(const Problem& problem, const KnownCauses& known, SearchResult& result) {
  const std::vector<Grown> grown = explanations_of(result);
  result.unnamed = unnamed_beside(problem, grown, result.material, known);
  if (!result.unnamed) return;
  end_steps_at(result.unnamed->beside, grown[result.unnamed->beside], result);
  leave_out_mimics(problem, known, result);
}

bool leave_out_doubted(const Problem& problem, const KnownCauses& known, SearchResult& result) {
  const std::vector<std::string> doubted =
      steps_in_question(result, [](const Step& step) { return !step.doubts.empty(); });
  if (doubted.empty()) return false;
  if (own_shares(problem, result.best.assessment, {doubted})[0] >= kOwnBesideUnnamed ||
      !leave_out(problem, doubted, kMisfit, known, result))
    return false;
  leave_out_mimics(problem, known, result);
  return true;
}

namespace {

// Of what an error leaves beyond the noise: residuals that are means have errors of their own.
double share_taken(double before, double after) {
  const double excess = before * before - 1;
  return excess > 0 ? std::min(1.0, (before * before - after * after) / excess) : 1;
}

}  // namespace

bool look_for_formula(const Problem& problem, const Progress& progress, const KnownCauses& known,
                      SearchResult& result) {
  const std::vector<Grown> grown = explanations_of(result);
  const Grown& last = grown.back();
  const size_t of_mean = steps_of_mean(result);
  // One formula may do what several names do together: not where these leave no more than the
  // noise, nor where smooth functions, which follow any formula, explain nothing.
  const auto competes = [&] {
    return result.steps.size() > 1 && last.assessment.error > 1 &&
           explained_without_name(problem, {result.base}, result.material, known);
  };
  // Nor instead of noise whose cause is known, as that of photons is.
  if (result.verdict != "unexplained_structure" && last.assessment.error < kMisfit &&
      noises_of_unknown_cause(result).empty() && !competes())
    return false;
  progress("building a formula from the residuals");
  result.formula_sought = true;
  size_t beside = 0;
  double most = 0;
  for (const size_t place :
       of_mean > 0 ? std::vector<size_t>{0, of_mean} : std::vector<size_t>{0}) {
    auto found = suggest(problem, grown[place]);
    if (!found) continue;
    // Where something is left that is no noise, evidence is too sure.
    const double misfit = std::max(1.0, found->error * found->error);
    const double named = grown[place].assessment.total_ll - merit_of(grown[place]);
    const double lead = (found->log_evidence - named - merit_of(last)) / misfit;
    if (!explains_better(lead, adds_means_alone(grown[place], last))) continue;
    if (result.unnamed && place == result.unnamed->beside &&
        share_taken(found->error_before, found->error) <
            kOwnBesideUnnamed *
                share_taken(result.unnamed->error_before, result.unnamed->error_after))
      continue;
    if (result.suggestion && lead < most) continue;
    result.suggestion = std::move(found), beside = place, most = lead;
  }
  if (!result.suggestion || beside == result.steps.size()) return false;
  end_steps_at(beside, grown[beside], result);
  // What smooth functions explain beside a step that is none says nothing of the cause.
  if (result.unnamed)
    result.unnamed = unnamed_beside(problem, {result.best}, result.material, known);
  return true;
}

}  // namespace seam::measurement
