#include "measurement/search/search.h"

#include <algorithm>
#include <cmath>

#include "effects/registry.h"

namespace seam::measurement {
namespace {

bool is_spread(const std::shared_ptr<const EffectDefinition>& effect) {
  return effect->spread_only;
}

// The best candidate, unless it is one of spread while one of the mean clearly helps, or helps at
// all and the spread leaves a misfit: a spread wide enough hides any structure of the mean, but
// only a true one leaves the noise.
Candidate* choose(const Problem& problem, std::vector<Candidate>& candidates) {
  if (candidates.empty() || !candidates.front().significant) return nullptr;
  if (problem.is_smooth() && is_spread(candidates.front().effect)) {
    const bool misfit = candidates.front().grown.assessment.error > kMisfit;
    const auto better = std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& c) {
      return misfit ? c.significant && !is_spread(c.effect) : clearly_helps(c);
    });
    if (better != candidates.end()) return &*better;
  }
  return &candidates.front();
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
  void forward(SearchResult& result);
  std::optional<Grown> replace(const Grown& grown, const std::string& out,
                               const std::string& in) const;
  bool prune(Grown& grown);
  bool exchange(Grown& grown);
  std::shared_ptr<const EffectDefinition> definition(const std::string& name) const;
  Grown part_of(const Grown& whole, const std::vector<std::string>& left, size_t kept) const;
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
    std::vector<std::optional<Grown>> without(grown.added.size());
    parallel_for(grown.added.size(), [&](size_t i) {
      if (problem_.is_smooth() && clearly_needed(grown, grown.added[i])) return;
      Model model = grown.assessment.model;
      model.remove(grown.added[i]);
      Grown smaller{.added = grown.added};
      smaller.added.erase(smaller.added.begin() + static_cast<long>(i));
      std::vector<Unknown> unknowns = grown.assessment.unknowns;
      std::erase_if(unknowns, [&](const Unknown& u) { return u.effect == grown.added[i]; });
      smaller.assessment = assess(problem_, model, unknowns);
      if (smaller.assessment.valid) without[i] = std::move(smaller);
    });
    size_t best = grown.added.size();
    for (size_t i = 0; i < without.size(); ++i) {
      if (!without[i]) continue;
      Candidate back{.effect = definition(grown.added[i]), .grown = grown};
      for (const Unknown& unknown : grown.assessment.unknowns) {
        if (unknown.effect == grown.added[i]) back.free.push_back(unknown.parameter);
      }
      judge(problem_, *without[i], looks_, material_, back);
      if (back.significant) continue;
      if (best == without.size() ||
          merit_of(problem_, *without[i]) > merit_of(problem_, *without[best]))
        best = i;
    }
    if (best < without.size()) {
      grown = std::move(*without[best]);
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

// Adds to a model what helps most, again and again; `traces` are those of the last look.
Grown Searcher::grow(Grown grown, Looks* first_looks, std::vector<Candidate>& traces) {
  for (size_t step = 0; step < kMostSteps; ++step) {
    progress_("step " + std::to_string(step + 1) + ": trying effects");
    // The first look is what the user sees: every effect is fitted in it.
    const bool first = step == 0 && first_looks != nullptr;
    Looks looks = look_at(problem_, grown, absent_effects(problem_, grown.assessment.model, own_),
                          material_, /*promising_only=*/!first);
    looks_ = std::max(looks_, looks.tried);
    if (first) *first_looks = looks;
    traces = traces_of(looks.candidates);
    for (const Candidate& candidate : looks.candidates) {
      const bool known = std::find(promising_.begin(), promising_.end(), candidate.effect->name) !=
                         promising_.end();
      if (candidate.significant && !known && promising_.size() < kMostPromising)
        promising_.push_back(candidate.effect->name);
    }
    const double before = merit_of(problem_, grown);
    if (Candidate* next = choose(problem_, looks.candidates)) {
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
      tried[i] = try_effect(problem_, grown, definition(left[i]), reasons);
      // Found after another that it replaced: what was fitted last is the place to start from.
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
    step.moved = movement(problem_, grown.assessment, tried[best]->grown.assessment,
                          is_spread(definition(left[best])));
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
    if (round == 0) check_enough(problem_, base_.assessment);
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
  // The first step is one of the effects that the whole explanation needs: others only stood in
  // for several of them at once.
  auto& candidates = result.first.candidates;
  const auto needed = [&](const Candidate& c) {
    return std::any_of(result.steps.begin(), result.steps.end(),
                       [&](const Step& s) { return s.effect == c.effect->name; });
  };
  if (!result.steps.empty()) {
    const auto found = std::find_if(candidates.begin(), candidates.end(), needed);
    if (found != candidates.end()) std::rotate(candidates.begin(), found, found + 1);
  }
  return result;
}

}  // namespace

bool mark_outliers(Problem& problem, const Model& model, SearchResult& result) {
  std::vector<char> outliers = problem.find_outliers(model);
  const size_t count = static_cast<size_t>(std::count(outliers.begin(), outliers.end(), 1));
  result.outlier_share =
      static_cast<double>(count) / static_cast<double>(std::max<size_t>(1, outliers.size()));
  result.outliers.clear();
  if (result.outlier_share > kMostOutliers || count == 0) outliers.clear();
  const bool changed = outliers != problem.left_out();
  problem.leave_out(std::move(outliers));
  if (count == 0 || result.outlier_share > kMostOutliers) return changed;
  const Evaluation evaluation = problem.evaluate(model, problem.all_groups());
  for (size_t i = 0; i < problem.left_out().size(); ++i) {
    if (!problem.left_out()[i]) continue;
    const int row = problem.facts().row_of[i];
    result.outliers.push_back({.line = problem.facts().line_of_row[row],
                               .scalar = i,
                               .residual = evaluation.residual[i]});
  }
  return changed;
}

SearchResult search(Problem& problem, const Model& model, const EffectList& own,
                    const Progress& progress, double material) {
  problem.check_model(model);
  problem.prepare(model);
  return Searcher(problem, model, own, progress, material).run();
}

}  // namespace seam::measurement
