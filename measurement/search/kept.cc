#include "measurement/search/kept.h"

#include <algorithm>
#include <cmath>

#include "measurement/fitting/group_scatter.h"
#include "measurement/judge/decisions.h"
#include "measurement/numerics/parallel_for.h"
#include "sim_core/system/work_tally.h"

namespace seam::measurement {
namespace {

// With the errors that are told in the end.
Assessment stated(const Problem& problem, const Grown& grown) {
  Assessment stated = grown.assessment;
  widen_by_group_scatter(problem, kMisfit, stated);
  return stated;
}

// Whether the candidate was fitted beside this very set of effects.
bool is_beside(const Candidate& candidate, const Grown& grown) {
  Model less = candidate.grown.assessment.model;
  less.remove(candidate.effect->name);
  const auto& effects = grown.assessment.model.effects();
  return less.effects().size() == effects.size() &&
         std::all_of(effects.begin(), effects.end(), [&](const effects::ModelEffect& effect) {
           return less.has(effect.definition->name);
         });
}

struct Misleading {
  Candidate trace;
  Moved moved;
};

bool is_less_likely(const Candidate& a, const Candidate& b) {
  return a.grown.assessment.total_ll < b.grown.assessment.total_ll;
}

// The traces beside the model, less those that are none there.
std::vector<Candidate> all_beside(const Problem& problem, const Grown& grown,
                                  const std::vector<Candidate>& traces, double looks,
                                  double material) {
  std::vector<std::optional<Candidate>> fitted(traces.size());
  const Work work("traces fitted", traces.size());
  parallel_for(traces.size(), [&](size_t i) {
    const bool is_known = is_beside(traces[i], grown) && !traces[i].of_few;
    fitted[i] = is_known ? traces[i] : fitted_beside(problem, grown, traces[i], looks, material);
    work.done();
  });
  std::vector<Candidate> beside;
  for (auto& candidate : fitted) {
    if (candidate && candidate->grown.assessment.total_ll > grown.assessment.total_ll)
      beside.push_back(*std::move(candidate));
  }
  return beside;
}

// Those of the traces that tell a value of the model wrong where they are left out. Two may stand
// for one cause: then the likelier says which, and what only the other shows is not wrong.
std::vector<Misleading> that_mislead(const Problem& problem, const Grown& grown,
                                     const std::vector<Candidate>& traces, double looks,
                                     double material) {
  const std::vector<Candidate> beside = all_beside(problem, grown, traces, looks, material);
  const auto likeliest = std::max_element(beside.begin(), beside.end(), is_less_likely);
  std::vector<Misleading> misleading;
  std::optional<Assessment> without, with_likeliest;  // Dear: where some trace may mislead.
  for (auto trace = beside.begin(); trace != beside.end(); ++trace) {
    const Assessment& there = trace->grown.assessment;
    if (most_moved(grown.assessment, there).errors <= kToldWrong) continue;
    if (!without) without = stated(problem, grown);
    const Moved moved = most_moved(*without, there);
    if (moved.errors <= kToldWrong) continue;
    if (trace != likeliest) {
      const auto both = fitted_beside(problem, likeliest->grown, *trace, looks, material);
      if (!both) continue;
      if (!with_likeliest) with_likeliest = stated(problem, likeliest->grown);
      if (most_moved(*with_likeliest, both->grown.assessment).errors <= kToldWrong) continue;
    }
    misleading.push_back({*trace, moved});
  }
  return misleading;
}

}  // namespace

std::optional<Candidate> fitted_beside(const Problem& problem, const Grown& grown,
                                       const Candidate& trace, double looks, double material) {
  std::vector<NotTestable> reasons;
  auto candidate = try_effect(problem, grown, trace.effect, reasons);
  if (!candidate) return std::nullopt;
  const Evaluation here =
      problem.evaluate_held_out(grown.assessment.model, problem.scored_groups());
  judge(problem, grown, here, looks, material, *candidate);
  if (!candidate->trace && !candidate->significant) return std::nullopt;
  return candidate;
}

Moved most_moved(const Assessment& without, const Assessment& with) {
  Moved most;
  for (size_t k = 0; k < without.unknowns.size(); ++k) {
    const auto there = index_of(with.unknowns, without.unknowns[k]);
    const double error = without.fit.sigma[k];
    if (!there || !(error > 0) || !std::isfinite(error)) continue;
    const double errors = std::abs(with.fit.value[*there] - without.fit.value[k]) / error;
    if (errors > most.errors) most = {without.unknowns[k], errors};
  }
  return most;
}

void keep_traces(const Problem& problem, double looks, SearchResult& result) {
  std::vector<Candidate> traces = result.last_traces;
  while (result.kept.size() < kMostKept) {
    Grown& best = result.best;
    const auto misleading = that_mislead(problem, best, traces, looks, result.material);
    if (misleading.empty()) return;
    const auto worst = std::max_element(
        misleading.begin(), misleading.end(),
        [](const auto& a, const auto& b) { return a.moved.errors < b.moved.errors; });
    const Assessment& after = worst->trace.grown.assessment;
    result.kept.push_back({worst->trace.effect->name, worst->moved.value, worst->moved.errors,
                           best.assessment.error, after.error});
    best.assessment = after;
    traces.clear();
    for (const Misleading& other : misleading) {
      if (&other != &*worst) traces.push_back(other.trace);
    }
  }
}

std::string moved_value(const SearchResult& result, const KeptTrace& kept) {
  const auto& [effect, parameter] = kept.value;
  const Model& model = result.best.assessment.model;
  return effect + "." + model.find(effect)->definition->parameters[parameter].name;
}

}  // namespace seam::measurement
