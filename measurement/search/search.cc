#include "measurement/search/search.h"

#include <algorithm>
#include <cmath>

#include "effects/questions.h"
#include "effects/registry.h"
#include "measurement/fitting/foretaste.h"
#include "measurement/fitting/group_scatter.h"
#include "measurement/numerics/parallel_for.h"
#include "measurement/search/choice.h"
#include "measurement/search/empirical_lens.h"
#include "measurement/search/kept.h"
#include "measurement/search/order.h"
#include "measurement/search/told_apart.h"
#include "measurement/search/without_name.h"

namespace seam::measurement {
namespace {

class Searcher {
 public:
  Searcher(Problem& problem, const Model& model, const EffectList& own, const Progress& progress,
           double material)
      : problem_(problem),
        model_(model),
        own_(own),
        progress_(progress),
        material_(material),
        exchanges_(problem) {}

  SearchResult run();

 private:
  static constexpr size_t kKeptCauses = 32;
  Grown base() const {
    const Assessment given = assess(problem_, model_, refitted_unknowns(model_));
    return {.assessment = given};
  }
  Grown grow(Grown grown, Looks* first_looks, std::vector<Candidate>& traces);
  Looks look(const Grown& grown, bool promising_only);
  EffectList absent(const Model& model, bool moves) const;
  void forward(SearchResult& result, std::optional<Grown> found);
  bool mark_by(const Grown& best, SearchResult& result);
  std::optional<Grown> again(Grown grown, SearchResult& result);
  void begin_with(const Candidate& beginning, SearchResult& result);
  bool misses(const Assessment& assessment) const;
  Looks look_at_moves() const;
  void begin_with_moves(const Looks& moves, SearchResult& result);
  void begin_with_refused(SearchResult& result);
  bool prune(Grown& grown) {
    return measurement::prune(
        problem_, [this](const std::string& name) { return definition(name); }, looks_, material_,
        grown);
  }
  std::shared_ptr<const EffectDefinition> definition(const std::string& name) const;

  Problem& problem_;
  const Model& model_;
  const EffectList& own_;
  const Progress& progress_;
  const double material_;
  const Exchanges exchanges_;
  const KnownCauses causes_{1, kKeptCauses};
  Grown base_;
  // Large errors that were given back to an effect of their own count as outliers for good where
  // the search then ends without one.
  LargeErrors large_errors_ = LargeErrors::open;
  std::optional<std::vector<std::string>> marked_by_;  // The effects of the model that judged last.
  double looks_ = 1;
  Looks first_;                         // On the base, had in the last round that looked at it.
  Looks moves_;                         // Had in the last round that looked at any.
  bool no_name_explains_ = false;       // Nor does any other, then, in this round.
  std::vector<std::string> promising_;  // Significant in some look, best first.
};

std::shared_ptr<const EffectDefinition> Searcher::definition(const std::string& name) const {
  if (auto found = effects::find_effect(name)) return as_tried(problem_, found);
  for (const auto& effect : own_) {
    if (effect->name == name) return effect;
  }
  return nullptr;
}

// The effects that the model lacks: those that come alone, or those that come with others.
EffectList Searcher::absent(const Model& model, bool moves) const {
  EffectList effects = absent_effects(problem_, model, own_);
  std::erase_if(effects, [&](const auto& effect) { return effect->companions.empty() == moves; });
  return effects;
}

Looks Searcher::look(const Grown& grown, bool promising_only) {
  Looks looks = look_at(problem_, grown, absent(grown.assessment.model, /*moves=*/false), material_,
                        promising_only, Asked::few_first);
  looks_ = std::max(looks_, looks.tried);
  return looks;
}

// Adds to a model what helps most, again and again; `traces` are those of the last look. The first
// may have been had before.
Grown Searcher::grow(Grown grown, Looks* first_looks, std::vector<Candidate>& traces) {
  std::vector<Grown> way = {base_};
  for (size_t step = 0; step < kMostSteps; ++step) {
    if (!grown.added.empty()) way.push_back(grown);
    const bool imitate = names_imitate(problem_, way, material_, causes_);
    progress_("step " + std::to_string(step + 1) + ": trying effects");
    const bool first = step == 0 && first_looks != nullptr;
    Looks looks = first ? *first_looks : look(grown, /*promising_only=*/true);
    Candidate* next = choose_by_all_rows(problem_, grown, material_, looks);
    if (first) *first_looks = looks;
    traces = traces_of(looks.candidates);
    remember_significant(looks.candidates, promising_);
    if (imitate) {  // Unless the next one explains the set after all.
      std::vector<Grown> farther = way;
      if (next) farther.push_back(next->grown);
      if ((no_name_explains_ = names_imitate(problem_, farther, material_, causes_))) break;
    }
    const double before = merit_of(grown);
    const std::vector<std::string> added_before = grown.added;
    if (next) {
      grown = std::move(next->grown);
      prune(grown);
    }
    // All exchanges, each as dear as a look, are tried where the search would end: also where what
    // was added went again.
    if (grown.added == added_before) {
      auto better = exchanges_.better(grown, promising_,
                                      [&](const std::string& name) { return definition(name); });
      if (!better) break;
      grown = *std::move(better);
      prune(grown);
    }
    grown = named_by_camera(problem_, std::move(grown));
    if (!(merit_of(grown) > before)) break;
  }
  return grown;
}

// Grows from a beginning, and keeps what comes of it where it is better than what was found.
void Searcher::begin_with(const Candidate& beginning, SearchResult& result) {
  if (no_name_explains_) return;
  progress_("trying again from " + beginning.effect->name);
  std::vector<Candidate> traces;
  Grown other = beginning.grown;
  if (beginning.of_few)
    other.assessment = assess(problem_, other.assessment.model, other.assessment.unknowns);
  prune(other);
  other = grow(std::move(other), nullptr, traces);
  no_name_explains_ = false;  // Another beginning may still.
  if (merit_of(other) <= merit_of(result.best)) return;
  // One that helped no held-out group by itself must do so with what came to it.
  if (!beginning.significant && other.assessment.held_ll() <= result.best.assessment.held_ll())
    return;
  if (beginning.hides_mean && misses(other.assessment)) return;
  result.best = std::move(other);
  result.last_traces = std::move(traces);
}

// Outliers are those of the best model; whether there are others than before. Of fits of one model
// after the first, those of each count: rows near the limit would come and go without an end.
bool Searcher::mark_by(const Grown& best, SearchResult& result) {
  const Model& model = best.assessment.model;
  if (large_errors_ != LargeErrors::in_vain && best.assessment.error > kUseless &&
      error_beside_outliers(problem_, model) > kUseless)
    return false;
  const Model judge = judge_of_outliers(problem_, model_, best, large_errors_);
  const bool keep = marked_by_ == best.added && judge.effects().size() == model.effects().size();
  marked_by_ = best.added;
  return mark_outliers(problem_, judge, result, keep);
}

// What explains the set is fitted again with other outliers marked, in turn until these stay, and
// the search goes on from it where it still does.
std::optional<Grown> Searcher::again(Grown grown, SearchResult& result) {
  if (grown.added.empty() || grown.assessment.error > kMisfit) return std::nullopt;
  for (int round = 0; round < kOutlierRounds; ++round) {
    grown.assessment = assess(problem_, grown.assessment.model, grown.assessment.unknowns);
    if (!grown.assessment.valid || grown.assessment.error > kMisfit) return std::nullopt;
    if (problem_.left_out().empty() || !mark_by(grown, result)) break;
  }
  prune(grown);
  return grown;
}

// Effects that come together are dear to fit and can imitate many, so they are tried where all else
// leaves a misfit.
void Searcher::forward(SearchResult& result, std::optional<Grown> found) {
  if (!found) {
    // The first look is what the user sees: every effect is fitted in it.
    progress_("step 1: trying effects");
    first_ = look(base_, /*promising_only=*/false);
    promising_.clear(), moves_ = {};
  }
  result.first_is_of_base = !found;
  no_name_explains_ = false;
  std::vector<Candidate> traces;
  result.best = base_;
  Grown alone = found ? grow(*std::move(found), nullptr, traces) : grow(base_, &first_, traces);
  if (!(merit_of(alone) < merit_of(base_))) {  // Else the noise that has its size explains it.
    result.best = std::move(alone);
    result.last_traces = std::move(traces);
  }
  if (misses(result.best.assessment) &&
      !explained_without_name(problem_, {base_, result.best}, material_, causes_))
    begin_with_moves(moves_ = look_at_moves(), result);
  begin_with_refused(result);
  result.first = first_;
  join(moves_, result.first);
}

bool Searcher::misses(const Assessment& assessment) const {
  return assessment.error > kMisfit ||
         has_mean_structure(significant_structure(problem_, assessment, material_).material);
}

// Several effects that come together put other rules in the place of those that the model has.
Looks Searcher::look_at_moves() const {
  const EffectList moves = absent(base_.assessment.model, /*moves=*/true);
  if (moves.empty()) return {};
  progress_("trying effects that come together");
  return look_at(problem_, base_, moves, material_);
}

// Rules that others need beside them (a motor without friction keeps swinging) may help where they
// were fitted and not yet where they were not: what grows from them decides.
void Searcher::begin_with_moves(const Looks& moves, SearchResult& result) {
  for (const Candidate& candidate : moves.candidates) {
    const bool fits = candidate.merit > merit_of(base_) + kOdds;
    if ((candidate.significant || fits) && misses(result.best.assessment))
      begin_with(candidate, result);
  }
}

// A spread may hide a mean whose own effect helps only beside it: a lag under a way that wanders.
void Searcher::begin_with_refused(SearchResult& result) {
  const auto& first = first_.candidates;
  const auto refused =
      std::find_if(first.begin(), first.end(), [](const Candidate& c) { return c.hides_mean; });
  if (refused != first.end() && misses(result.best.assessment)) begin_with(*refused, result);
}

SearchResult Searcher::run() {
  SearchResult result{.material = material_};
  progress_("fitting the model given");
  problem_.leave_out({});
  mark_outliers(problem_, model_, result);
  result.outliers_of_given = result.outliers.size();
  bool changed = true;  // Marks, or the size of a noise.
  for (int round = 0; round < kOutlierRounds && changed; ++round) {
    std::optional<Grown> found;
    if (round > 0) found = again(std::move(result.best), result);
    const bool given_back = round > 0 && problem_.left_out().empty();
    base_ = base();
    if (round == 0 && base_.assessment.held.valid) check_enough(problem_, base_.assessment);
    forward(result, std::move(found));
    const bool estimates = estimates_large_errors(model_, result.best.assessment.model);
    if (given_back && !estimates) large_errors_ = LargeErrors::in_vain;
    if (large_errors_ == LargeErrors::open && estimates && !problem_.left_out().empty())
      large_errors_ = LargeErrors::proven;
    const bool marked = mark_by(result.best, result);
    changed = correct_noise(problem_, result.best) || marked;
  }
  if (changed) {
    base_ = base();
    Assessment& best = result.best.assessment;
    best = assess(problem_, best.model, best.unknowns);
  }
  result.base = base_;
  const auto by_name = [&](const std::string& name) { return definition(name); };
  result.best = less_tangled(problem_, std::move(result.best));
  result.first_is_of_base = result.first_is_of_base && !changed;
  progress_("putting the steps in order");
  Grown searched;
  do {
    remove_neutral(problem_, result.best);
    searched = result.best;
    order_steps(problem_, by_name, result);
  } while (remove_neutral(problem_, result.best));
  progress_("looking for a cause without a name");
  look_for_unnamed(problem_, causes_, result);
  if (!result.unnamed) keep_traces(problem_, looks_, result);  // Else they are not to be trusted.
  progress_("testing what structure remains");
  const SplitStructure of_base = significant_structure(problem_, base_.assessment, material_);
  give_verdict(problem_, of_base, result);
  while (leave_out_doubted(problem_, causes_, result)) give_verdict(problem_, of_base, result);
  if (look_for_formula(problem_, progress_, causes_, result))
    give_verdict(problem_, of_base, result);
  result.functions = tried_beside(problem_, result.best.assessment, causes_);
  hold_against_splines(problem_, progress_, searched, result);
  tell_ties(problem_, by_name, exchanges_, searched, promising_, result);
  rank_by_search(problem_, result);
  widen_by_group_scatter(problem_, kMisfit, result.base.assessment);
  result.errors_widened = widen_by_group_scatter(problem_, kMisfit, result.best.assessment);
  return result;
}

}  // namespace

SearchResult search(Problem& problem, const Model& model, const EffectList& own,
                    const Progress& progress, double material) {
  problem.check_model(model);
  problem.prepare(model);
  return Searcher(problem, model, own, progress, material).run();
}

}  // namespace seam::measurement
