#include "measurement/search/search.h"

#include <algorithm>
#include <cmath>

#include "effects/questions.h"
#include "effects/registry.h"
#include "measurement/search/stand_ins.h"

namespace seam::measurement {
namespace {

bool is_spread(const std::shared_ptr<const EffectDefinition>& effect) {
  return effect->spread_only;
}

// The best candidate, unless it is one of spread while one of the mean clearly helps or lowers the
// residuals themselves: a spread wide enough hides any structure of the mean. One that only does
// that is no candidate.
Candidate* choose(const Problem& problem, bool misses, std::vector<Candidate>& candidates) {
  while (!candidates.empty() && candidates.front().significant) {
    Candidate& best = candidates.front();
    if (!is_spread(best.effect)) return &best;
    const auto better = std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& c) {
      return (problem.is_smooth() && clearly_helps(c)) || (misses && goes_before_spreads(c));
    });
    if (better != candidates.end()) return &*better;
    if (!misses || !hides_mean(problem, best.grown.assessment)) return &best;
    best.significant = false;
    const auto end = std::find_if(candidates.begin() + 1, candidates.end(),
                                  [](const Candidate& c) { return !c.significant; });
    std::rotate(candidates.begin(), candidates.begin() + 1, end);
  }
  return nullptr;
}

Weight weight_of(const Grown& grown) {
  return {grown.assessment.total_ll, fitted_parameters(grown)};
}

// A model less one of its added effects, not fitted again.
Grown without(const Grown& grown, const std::string& out) {
  Grown smaller{.added = grown.added};
  std::erase(smaller.added, out);
  Model model = grown.assessment.model;
  model.remove(out);
  std::vector<Unknown> unknowns = grown.assessment.unknowns;
  std::erase_if(unknowns, [&](const Unknown& u) { return u.effect == out; });
  smaller.assessment = {.model = model, .unknowns = unknowns};
  smaller.assessment.total_ll = -1e300;
  return smaller;
}

class Searcher {
 public:
  Searcher(Problem& problem, const Model& model, const EffectList& own, const Progress& progress,
           double material)
      : problem_(problem), model_(model), own_(own), progress_(progress), material_(material) {}

  SearchResult run();

 private:
  Grown base() const { return {.assessment = assess(problem_, model_, refitted_unknowns(model_))}; }
  Grown grow(Grown grown, Looks* first_looks, std::vector<Candidate>& traces);
  Looks look(const Grown& grown, bool promising_only);
  void forward(SearchResult& result);
  std::optional<Grown> replace(const Grown& grown, const std::string& out,
                               const std::string& in) const;
  bool prune(Grown& grown);
  bool exchange(Grown& grown);
  std::shared_ptr<const EffectDefinition> definition(const std::string& name) const;
  Grown part_of(const Grown& whole, const std::vector<std::string>& left, size_t kept) const;
  double moved(const Assessment& before, const Assessment& after, const std::string& by) const;
  void order_steps(SearchResult& result);

  Problem& problem_;
  const Model& model_;
  const EffectList& own_;
  const Progress& progress_;
  const double material_;
  Grown base_;
  double looks_ = 1;
  std::vector<std::string> promising_;  // Significant in some look, best first.
};

std::shared_ptr<const EffectDefinition> Searcher::definition(const std::string& name) const {
  if (auto found = effects::find_effect(name)) return found;
  for (const auto& effect : own_) {
    if (effect->name == name) return effect;
  }
  return nullptr;
}

// Whether some parameter of an added effect is so far from neutral that the effect cannot go.
bool clearly_needed(const Grown& grown, const std::string& name) {
  const Assessment& here = grown.assessment;
  const effects::ModelEffect* effect = here.model.find(name);
  for (size_t k = 0; k < here.unknowns.size() && k < here.fit.sigma.size(); ++k) {
    if (here.unknowns[k].effect != name) continue;
    const double neutral = effect->definition->parameters[here.unknowns[k].parameter].neutral;
    // Every value is infinitely far from a limit's neutral one: that says nothing.
    if (std::isfinite(neutral) &&
        std::abs(here.fit.value[k] - neutral) > kCannotGo * here.fit.sigma[k])
      return true;
  }
  return false;
}

// Drops effects that the others have made unnecessary.
bool Searcher::prune(Grown& grown) {
  bool changed = false;
  for (bool again = true; again && grown.added.size() > 1;) {
    again = false;
    std::vector<std::optional<Grown>> smaller(grown.added.size());
    parallel_for(grown.added.size(), [&](size_t i) {
      if (problem_.is_smooth() && clearly_needed(grown, grown.added[i])) return;
      if (effects::has_dependents(grown.assessment.model, grown.added[i])) return;
      Grown less = without(grown, grown.added[i]);
      less.assessment = assess(problem_, less.assessment.model, less.assessment.unknowns);
      if (less.assessment.valid) smaller[i] = std::move(less);
    });
    size_t best = grown.added.size();
    for (size_t i = 0; i < smaller.size(); ++i) {
      if (!smaller[i]) continue;
      Candidate back{.effect = definition(grown.added[i]), .grown = grown};
      for (const Unknown& unknown : grown.assessment.unknowns) {
        if (unknown.effect == grown.added[i]) back.free.push_back(unknown.parameter);
      }
      const Evaluation here =
          problem_.evaluate(smaller[i]->assessment.model, problem_.scored_groups());
      judge(problem_, *smaller[i], here, looks_, material_, back);
      if (back.significant) continue;
      if (best == smaller.size() ||
          merit_of(problem_, *smaller[i]) > merit_of(problem_, *smaller[best]))
        best = i;
    }
    if (best < smaller.size()) {
      grown = std::move(*smaller[best]);
      changed = again = true;
    }
  }
  return changed;
}

// The model with one added effect in the place of another. Nothing where a step of Gauss and Newton
// shows that it cannot make up for most of what is lost.
std::optional<Grown> Searcher::replace(const Grown& grown, const std::string& out,
                                       const std::string& in) const {
  Grown smaller = without(grown, out);
  const Score score = problem_.score(smaller.assessment.model, problem_.all_groups());
  if (score.valid) smaller.assessment.total_ll = score.log_likelihood;
  std::vector<NotTestable> reasons;
  const auto prospect = prospect_of(problem_, smaller, definition(in), reasons);
  if (!prospect) return std::nullopt;
  if (std::isfinite(prospect->expected_ll)) {
    const double lost = grown.assessment.total_ll - score.log_likelihood;
    if (score.valid && prospect->expected_ll < grown.assessment.total_ll -
                                                   kReplacementShortfall * lost - kReplacementSlack)
      return std::nullopt;
  }
  auto candidate = fit_prospect(problem_, smaller, *prospect, reasons);
  if (!candidate) return std::nullopt;
  return std::move(candidate->grown);
}

// Exchanges one added effect for another of its sort where the whole becomes clearly better.
bool Searcher::exchange(Grown& grown) {
  if (grown.added.size() < 2) return false;
  std::vector<std::pair<size_t, std::string>> moves;
  for (size_t i = 0; i < grown.added.size(); ++i) {
    if (effects::has_dependents(grown.assessment.model, grown.added[i])) continue;
    for (const std::string& name : promising_) {
      const bool present =
          std::find(grown.added.begin(), grown.added.end(), name) != grown.added.end();
      // A spread in the place of an effect of the mean would hide it; the other way round, the
      // effect of the mean is added first and then the spread is dropped.
      if (!present && is_spread(definition(name)) == is_spread(definition(grown.added[i])))
        moves.emplace_back(i, name);
    }
  }
  std::vector<std::optional<Grown>> tried(moves.size());
  parallel_for(moves.size(), [&](size_t m) {
    tried[m] = replace(grown, grown.added[moves[m].first], moves[m].second);
  });
  double best_merit = merit_of(problem_, grown) + kExchangeGain * tie_width(grown.assessment.error);
  size_t best = moves.size();
  for (size_t m = 0; m < moves.size(); ++m) {
    if (!tried[m] || tried[m]->assessment.held_ll() < grown.assessment.held_ll()) continue;
    // Of two that the data cannot tell apart the simpler stays.
    if (fitted_parameters(*tried[m]) > fitted_parameters(grown) &&
        cannot_tell(weight_of(*tried[m]), weight_of(grown), grown.assessment.error))
      continue;
    const double merit = merit_of(problem_, *tried[m]);
    if (merit > best_merit) best_merit = merit, best = m;
  }
  if (best == moves.size()) return false;
  grown = std::move(*tried[best]);
  return true;
}

Looks Searcher::look(const Grown& grown, bool promising_only) {
  Looks looks = look_at(problem_, grown, absent_effects(problem_, grown.assessment.model, own_),
                        material_, promising_only);
  looks_ = std::max(looks_, looks.tried);
  return looks;
}

// Adds to a model what helps most, again and again; `traces` are those of the last look.
Grown Searcher::grow(Grown grown, Looks* first_looks, std::vector<Candidate>& traces) {
  for (size_t step = 0; step < kMostSteps; ++step) {
    progress_("step " + std::to_string(step + 1) + ": trying effects");
    // The first look is what the user sees: every effect is fitted in it. So is it where the search
    // would end with a misfit: a step from small starts may have promised too little.
    const bool first = step == 0 && first_looks != nullptr;
    const bool misses = grown.assessment.error > kMisfit;
    Looks looks = look(grown, /*promising_only=*/!first);
    Candidate* next = choose(problem_, misses, looks.candidates);
    if (!next && !first && misses && problem_.is_smooth()) {
      looks = look(grown, /*promising_only=*/false);
      next = choose(problem_, misses, looks.candidates);
    }
    if (first) *first_looks = looks;
    traces = traces_of(looks.candidates);
    for (const Candidate& candidate : looks.candidates) {
      const bool known = std::find(promising_.begin(), promising_.end(), candidate.effect->name) !=
                         promising_.end();
      if (candidate.significant && !known && promising_.size() < kMostPromising)
        promising_.push_back(candidate.effect->name);
    }
    const double before = merit_of(problem_, grown);
    if (next) {
      grown = std::move(next->grown);
      prune(grown);
    } else {
      // Nothing more to add: exchanges are tried where the search would end, since each costs as
      // much as a look at the catalogue.
      if (!exchange(grown)) break;
      prune(grown);
    }
    if (!(merit_of(problem_, grown) > before)) break;
  }
  return grown;
}

void Searcher::forward(SearchResult& result) {
  result.best = grow(base_, &result.first, result.last_traces);
  if (!problem_.effects_imitate()) return;
  // The best first step may stand for several effects at once, from where none of them helps alone:
  // others begin too, the simplest first.
  std::vector<const Candidate*> beginnings;
  for (const Candidate& candidate : result.first.candidates) {
    const auto& added = result.best.added;
    const bool taken = std::find(added.begin(), added.end(), candidate.effect->name) != added.end();
    const bool helps = candidate.p_value < kCandidateAlarm && candidate.gain_ll > 0;
    if (helps && !candidate.trace && !is_spread(candidate.effect) && !taken)
      beginnings.push_back(&candidate);
  }
  std::stable_sort(
      beginnings.begin(), beginnings.end(),
      [](const Candidate* a, const Candidate* b) { return a->free.size() < b->free.size(); });
  for (size_t i = 0;
       i < std::min(kBeginnings, beginnings.size()) && result.best.assessment.error > kMisfit;
       ++i) {
    progress_("trying again from " + beginnings[i]->effect->name);
    std::vector<Candidate> traces;
    Grown other = grow(beginnings[i]->grown, nullptr, traces);
    if (merit_of(problem_, other) <= merit_of(problem_, result.best)) continue;
    result.best = std::move(other);
    result.last_traces = std::move(traces);
  }
}

// A model less those of its effects that are left, but for one, fitted again from its own values.
Grown Searcher::part_of(const Grown& whole, const std::vector<std::string>& left,
                        size_t kept) const {
  Grown part = whole;
  for (const std::string& name : left) {
    if (name != left[kept]) part = without(part, name);
  }
  part.assessment = assess(problem_, part.assessment.model, part.assessment.unknowns);
  return part;
}

double Searcher::moved(const Assessment& before, const Assessment& after,
                       const std::string& by) const {
  const Evaluation here = problem_.evaluate_held_out(before.model, problem_.scored_groups());
  return change_by(problem_, here, before, after, only_widens(*definition(by))).moved;
}

// The effects found, in the order in which each helps most.
void Searcher::order_steps(SearchResult& result) {
  result.steps.clear();
  const bool explained = result.best.assessment.error < kMisfit;
  Grown grown = base_;
  std::vector<std::string> left = result.best.added;
  while (!left.empty()) {
    std::vector<std::optional<Candidate>> tried(left.size());
    // Where they do not explain the set, the order in which the search took them is good enough.
    parallel_for(explained ? left.size() : 1, [&](size_t i) {
      std::vector<NotTestable> reasons;
      const auto effect = definition(left[i]);
      if (effects::is_excluded(*effect, grown.assessment.model)) return;
      if (effect->companions.empty()) tried[i] = try_effect(problem_, grown, effect, reasons);
      // Found after another that it replaced, or with others: what was fitted last is the place to
      // start from.
      if (tried[i]) return;
      Grown part = part_of(result.best, left, i);
      if (part.assessment.valid) tried[i] = Candidate{.grown = std::move(part)};
    });
    size_t best = left.size();
    for (size_t i = 0; i < left.size(); ++i) {
      if (tried[i] && (best == left.size() || tried[i]->grown.assessment.total_ll >
                                                  tried[best]->grown.assessment.total_ll))
        best = i;
    }
    if (best == left.size()) break;
    Step step{.effect = left[best], .error_before = grown.assessment.error};
    step.moved = moved(grown.assessment, tried[best]->grown.assessment, left[best]);
    grown = std::move(tried[best]->grown);
    step.after = grown.assessment;
    step.error_after = grown.assessment.error;
    result.steps.push_back(std::move(step));
    left.erase(left.begin() + static_cast<long>(best));
  }
  if (grown.assessment.valid && !result.steps.empty() &&
      grown.assessment.total_ll >= result.best.assessment.total_ll - kSameFit) {
    result.best = grown;
  }
  if (!explained) return;
  // Which others could stand in the place of each step.
  std::vector<std::vector<std::string>> ties(result.steps.size());
  std::vector<std::pair<size_t, std::string>> moves;
  for (size_t s = 0; s < result.steps.size(); ++s) {
    if (effects::has_dependents(result.best.assessment.model, result.steps[s].effect)) continue;
    for (const std::string& name : promising_) {
      if (!result.best.assessment.model.has(name)) moves.emplace_back(s, name);
    }
  }
  std::vector<char> tied(moves.size(), 0);
  parallel_for(moves.size(), [&](size_t m) {
    const auto other = replace(result.best, result.steps[moves[m].first].effect, moves[m].second);
    if (!other) return;
    tied[m] = cannot_tell(weight_of(result.best), weight_of(*other), result.best.assessment.error);
  });
  for (size_t m = 0; m < moves.size(); ++m) {
    auto& names = result.steps[moves[m].first].indistinguishable_from;
    if (tied[m] && names.size() < kMostTiesNamed) names.push_back(moves[m].second);
  }
}

SearchResult Searcher::run() {
  SearchResult result{.material = material_};
  problem_.leave_out({});
  mark_outliers(problem_, model_, result);
  result.outliers_of_given = result.outliers.size();
  bool marks_changed = true;
  for (int round = 0; round < kOutlierRounds && marks_changed; ++round) {
    promising_.clear();
    base_ = base();
    if (round == 0 && base_.assessment.held.valid) check_enough(problem_, base_.assessment);
    forward(result);
    // Outliers are those of the best model; with others the search is run again. A model that
    // explains nothing has none to tell.
    marks_changed = result.best.assessment.error <= kUseless &&
                    mark_outliers(problem_, result.best.assessment.model, result);
  }
  if (marks_changed) base_ = base();
  result.base = base_;
  order_steps(result);
  progress_("testing what structure remains");
  const auto structure_of = [&](const Grown& grown) {
    return significant_structure(problem_, grown.assessment, material_);
  };
  const SplitStructure of_base = structure_of(base_);
  const SplitStructure of_best = result.steps.empty() ? of_base : structure_of(result.best);
  result.base_structure = of_base.material, result.base_traces = of_base.traces;
  result.remaining = of_best.material, result.remaining_traces = of_best.traces;
  const bool first_found =
      !result.first.candidates.empty() && result.first.candidates.front().significant;
  if (!result.remaining.empty() && (has_mean_structure(result.remaining) || !first_found)) {
    result.verdict = "unexplained_structure";
  } else {
    result.verdict = result.steps.empty() ? "adequate" : "missing_effect";
  }
  rank_by_search(problem_, result);
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
