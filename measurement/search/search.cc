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
  Looks look(const Grown& grown, bool promising_only, Asked asked);
  EffectList absent(const Model& model, bool moves) const;
  void forward(SearchResult& result, const Grown* earlier);
  std::optional<Grown> again(const Grown& earlier);
  void begin_with(const Candidate& beginning, SearchResult& result);
  bool misses(const Assessment& assessment) const;
  Looks look_at_moves() const;
  void begin_with_moves(const Looks& moves, SearchResult& result);
  void begin_with_dependents(const Grown& base, SearchResult& result);
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

Looks Searcher::look(const Grown& grown, bool promising_only, Asked asked) {
  Looks looks = look_at(problem_, grown, absent(grown.assessment.model, /*moves=*/false), material_,
                        promising_only, asked);
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
    // Every effect is fitted where the search would end with a misfit: a step from small starts may
    // have promised too little.
    const bool first = step == 0 && first_looks != nullptr;
    const bool misses = grown.assessment.error > kMisfit;
    Looks looks = first ? *first_looks : look(grown, /*promising_only=*/true, Asked::few_first);
    Candidate* next = choose_by_all_rows(problem_, grown, material_, looks);
    const bool shortened = (!first && looks.shortened) ||
                           std::any_of(looks.candidates.begin(), looks.candidates.end(),
                                       [](const Candidate& candidate) { return candidate.of_few; });
    if (!next && misses && shortened && !imitate) {
      looks = look(grown, /*promising_only=*/false, Asked::all_rows);
      next = choose(problem_, grown, looks.candidates);
    }
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

// What explains the set is fitted again with other outliers marked, and the search goes on from it
// where it still does.
std::optional<Grown> Searcher::again(const Grown& earlier) {
  if (earlier.added.empty() || earlier.assessment.error > kMisfit) return std::nullopt;
  Grown grown = earlier;
  grown.assessment = assess(problem_, earlier.assessment.model, earlier.assessment.unknowns);
  if (!grown.assessment.valid || grown.assessment.error > kMisfit) return std::nullopt;
  prune(grown);
  return grown;
}

// Effects that come together are dear to fit and can imitate many, so they are tried where all else
// leaves a misfit; but first where no single effect explains anything, since a long search among
// these is dearer still.
void Searcher::forward(SearchResult& result, const Grown* earlier) {
  std::optional<Grown> found;
  if (earlier != nullptr) found = again(*earlier);
  if (!found) {
    // The first look is what the user sees: every effect is fitted in it.
    progress_("step 1: trying effects");
    first_ = look(base_, /*promising_only=*/false, Asked::few_first);
    if (mark_gross_errors(problem_, base_, first_.candidates, result)) {
      base_ = base();
      first_ = look(base_, /*promising_only=*/false, Asked::few_first);
    }
    promising_.clear(), moves_ = {};
  }
  result.first_is_of_base = !found;
  no_name_explains_ = false;
  result.best = base_;
  const bool moves_first = !found && all_useless(base_, first_) &&
                           !explained_without_name(problem_, {base_}, material_, causes_);
  if (moves_first) begin_with_moves(moves_ = look_at_moves(), result);
  std::vector<Candidate> traces;
  Grown alone = found ? grow(*std::move(found), nullptr, traces) : grow(base_, &first_, traces);
  if (!(merit_of(alone) < merit_of(result.best))) {
    result.best = std::move(alone);
    result.last_traces = std::move(traces);
  }
  if (!moves_first && misses(result.best.assessment) &&
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
    if (!candidate.significant && !fits) continue;
    begin_with_dependents(candidate.grown, result);
    if (misses(result.best.assessment)) begin_with(candidate, result);
  }
}

// What stays of all at once is what the rest cannot stand in for.
void Searcher::begin_with_dependents(const Grown& base, SearchResult& result) {
  if (!misses(base.assessment)) return;
  const auto all = with_all_of_servo(problem_, base, own_);
  // Where all of them leave far more than the noise, something else is missing.
  if (!all || all->grown.assessment.error > kUseless) return;
  // Those that go again may be as good as one that stays.
  for (const std::string& name : all->grown.added) {
    if (!base.assessment.model.has(name)) add_once(promising_, name);
  }
  begin_with(*all, result);
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
  // Large errors that were given back to an effect of their own count as outliers for good where
  // the search then ends without one.
  bool changed = true;  // Marks, or the size of a noise.
  LargeErrors large_errors = LargeErrors::open;
  for (int round = 0; round < kOutlierRounds && changed; ++round) {
    base_ = base();
    if (round == 0 && base_.assessment.held.valid) check_enough(problem_, base_.assessment);
    const std::optional<Grown> earlier =
        round > 0 ? std::optional(std::move(result.best)) : std::nullopt;
    const bool given_back = round > 0 && problem_.left_out().empty();
    forward(result, earlier ? &*earlier : nullptr);
    // Outliers are those of the best model; with others the search is run again.
    const Assessment& best = result.best.assessment;
    const bool estimates = estimates_large_errors(model_, best.model);
    if (given_back && !estimates) large_errors = LargeErrors::in_vain;
    if (large_errors == LargeErrors::open && estimates && !problem_.left_out().empty())
      large_errors = LargeErrors::proven;
    const bool marked =
        (large_errors == LargeErrors::in_vain || best.error <= kUseless ||
         error_beside_outliers(problem_, best.model) <= kUseless) &&
        mark_outliers(problem_, judge_of_outliers(problem_, model_, result.best, large_errors),
                      result);
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
