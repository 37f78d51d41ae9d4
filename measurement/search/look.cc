// One look at all effects that a model lacks. Where rows are many, each is fitted to a few groups
// first: what these show nothing of is not material. Of the others, those are fitted to all rows
// that the search would take (choice.h).
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "measurement/fitting/foretaste.h"
#include "measurement/numerics/parallel_for.h"
#include "measurement/numerics/regression.h"
#include "measurement/search/candidates.h"
#include "sim_core/system/work_tally.h"

namespace seam::measurement {
namespace {

// Marks the prospects worth a fit: those that the score test calls significant or nearly so, and of
// these the best few. What a step of Gauss and Newton cannot judge is always fitted, and so are
// parts of a motor while the model misses: friction that lets a joint stick makes slopes rough.
std::vector<char> worth_fitting(const Problem& problem, const Grown& base,
                                const std::vector<std::optional<Prospect>>& prospects) {
  const double n = static_cast<double>(std::max<size_t>(1, count_used(problem)));
  std::vector<char> worth(prospects.size(), 0);
  std::vector<std::pair<double, size_t>> ranked;
  for (size_t i = 0; i < prospects.size(); ++i) {
    if (!prospects[i]) continue;
    const bool part = prospects[i]->effect->needs_base != effects::Base::none;
    if (!std::isfinite(prospects[i]->expected_ll) || (part && base.assessment.error > kMisfit)) {
      worth[i] = 1;
      continue;
    }
    const double gain = prospects[i]->expected_ll - base.assessment.total_ll;
    const double error = base.assessment.error;
    const double misfit = std::max(1.0, error * error - 2 * gain / n);
    const double freedom = static_cast<double>(std::max<size_t>(1, prospects[i]->free.size()));
    const double tail = chi2_tail(kScoreMargin * 2 * std::max(gain, 0.0) / misfit, freedom);
    const std::optional<Model>& end = prospects[i]->end_of_step;
    if (tail * static_cast<double>(prospects.size()) < kPromising &&
        (!end || problem.is_visible(base.assessment.model, *end)))
      ranked.emplace_back(-prospects[i]->expected_ll, i);
  }
  std::sort(ranked.begin(), ranked.end());
  if (ranked.size() > kMostFitted) ranked.resize(kMostFitted);
  for (const auto& [order, i] : ranked) worth[i] = 1;
  return worth;
}

// Effects of the mean first, then draws that are estimated and move predictions, too, then what
// only widens them; single large errors last.
constexpr int kSorts = 4;

int sort_of(const EffectDefinition& effect) {
  if (!effect.spread_only) return 0;
  return effect.draws_estimated ? 1 : effect.errors == effects::Errors::now_and_then ? 3 : 2;
}

// Those with the most to fit first, so that no processor waits for a last long fit.
std::vector<size_t> dearest_first(const EffectList& effects) {
  std::vector<size_t> order(effects.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return effects[a]->parameters.size() > effects[b]->parameters.size();
  });
  return order;
}

class Look {
 public:
  Look(const Problem& problem, const Grown& base, const EffectList& effects, double material,
       bool promising_only, Asked asked)
      : problem_(problem),
        base_(base),
        effects_(effects),
        order_(dearest_first(effects)),
        material_(material),
        waits_(promising_only || problem.screening_groups()),
        promising_only_(waits_ && problem.is_smooth(base.assessment.model)),
        few_(asked == Asked::few_first ? foretasters(problem, base.assessment.model, material)
                                       : std::nullopt),
        prospects_(effects.size()),
        reasons_(effects.size()),
        found_(effects.size()) {}

  Looks run() {
    see_prospects();
    std::vector<char> worth(effects_.size(), 1);
    if (promising_only_) worth = worth_fitting(problem_, base_, prospects_);
    here_ = problem_.evaluate_held_out(base_.assessment.model, problem_.scored_groups());
    // Where one sort clearly helps, the next wait for another look.
    for (int sort = 0; sort < kSorts; ++sort) {
      // Single large errors are told by no model that explains nothing.
      const bool useless = sort == kSorts - 1 && base_.assessment.error > kUseless;
      if ((waits_ || useless) && any_helps()) break;
      for_all_effects("fitted effects", [&](size_t i) {
        if (prospects_[i] && worth[i] && sort_of(*effects_[i]) == sort) fit(i);
      });
    }
    if (few_) fit_undecided();
    for (size_t i = 0; i < effects_.size(); ++i) {
      looks_.not_testable.insert(looks_.not_testable.end(), reasons_[i].begin(), reasons_[i].end());
      if (found_[i]) looks_.candidates.push_back(std::move(*found_[i]));
    }
    rank_candidates(looks_.candidates);
    return std::move(looks_);
  }

 private:
  void for_all_effects(const char* part, const std::function<void(size_t)>& job) const {
    const Work work(part, order_.size());
    parallel_for(order_.size(), [&](size_t k) {
      job(order_[k]);
      work.done();
    });
  }

  std::optional<Evaluation> near_on(const std::optional<FewRows>& few) const {
    if (!few) return start_of_prospects(problem_, base_.assessment.model);
    if (!problem_.is_smooth(base_.assessment.model)) return std::nullopt;
    Evaluation near = few->problem->evaluate(base_.assessment.model, few->groups);
    if (!near.valid) return std::nullopt;
    near.reusable.reset();
    return near;
  }

  void see_prospects() {
    const std::optional<Evaluation> near = near_on(few_);
    const auto see = [&](size_t i, const Evaluation* from, const FewRows* few) {
      prospects_[i] =
          prospect_of(problem_, base_, effects_[i], reasons_[i], /*alone=*/false, from, few);
    };
    constexpr const char* kPart = "effects looked at";
    for_all_effects(kPart,
                    [&](size_t i) { see(i, near ? &*near : nullptr, few_ ? &*few_ : nullptr); });
    // What few groups cannot see, all may.
    if (few_) {
      for_all_effects(kPart, [&](size_t i) {
        const bool shares = prospects_[i] && !prospects_[i]->few;
        if (reasons_[i].empty() && !shares) return;
        reasons_[i].clear();
        see(i, nullptr, nullptr);
      });
    }
    for (const auto& prospect : prospects_) looks_.tried += prospect.has_value();
  }

  void fit(size_t i) {
    found_[i] = fit_prospect(problem_, base_, *prospects_[i], reasons_[i]);
    if (found_[i]) judge(problem_, base_, here_, looks_.tried, material_, *found_[i]);
  }

  bool any_helps() const {
    return std::any_of(found_.begin(), found_.end(), [&](const auto& c) {
      return c && c->significant && c->held_z > kClearGain && !only_widens(*c->effect);
    });
  }

  // What gains on all rows where few groups put it, and not yet enough, may gain more there.
  void fit_undecided() {
    for_all_effects("effects fitted to all rows", [&](size_t i) {
      const bool undecided =
          found_[i] && found_[i]->of_few && !found_[i]->significant && found_[i]->total_gain_ll > 0;
      if (undecided) ask_all_rows(problem_, base_, here_, looks_.tried, material_, *found_[i]);
    });
  }

  const Problem& problem_;
  const Grown& base_;
  const EffectList& effects_;
  const std::vector<size_t> order_;
  const double material_;
  const bool waits_;           // Another look will come.
  const bool promising_only_;  // A score test can tell what is worth a fit.
  const std::optional<FewRows> few_;
  std::vector<std::optional<Prospect>> prospects_;
  std::vector<std::vector<NotTestable>> reasons_;
  std::vector<std::optional<Candidate>> found_;
  Evaluation here_;
  Looks looks_;
};

}  // namespace

void ask_all_rows(const Problem& problem, const Grown& base, const Evaluation& here, double tried,
                  double material, Candidate& candidate) {
  std::vector<NotTestable> reasons;
  const auto near = start_of_prospects(problem, base.assessment.model);
  const auto prospect =
      prospect_of(problem, base, candidate.effect, reasons,
                  /*alone=*/candidate.companions.empty(), near ? &*near : nullptr);
  auto whole = prospect ? fit_prospect(problem, base, *prospect, reasons) : std::nullopt;
  candidate.of_few = false;
  if (!whole) {
    candidate.significant = candidate.trace = false;
    return;
  }
  candidate = std::move(*whole);
  judge(problem, base, here, tried, material, candidate);
}

void join(Looks other, Looks& looks) {
  if (other.candidates.empty() && other.not_testable.empty()) return;
  std::move(other.candidates.begin(), other.candidates.end(), std::back_inserter(looks.candidates));
  std::move(other.not_testable.begin(), other.not_testable.end(),
            std::back_inserter(looks.not_testable));
  looks.tried += other.tried;
  for (Candidate& candidate : looks.candidates) candidate.indistinguishable_from.clear();
  rank_candidates(looks.candidates);
}

Looks look_at(const Problem& problem, const Grown& base, const EffectList& effects, double material,
              bool promising_only, Asked asked) {
  return Look(problem, base, effects, material, promising_only, asked).run();
}

}  // namespace seam::measurement
