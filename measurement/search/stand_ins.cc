#include "measurement/search/stand_ins.h"

#include <algorithm>
#include <cmath>

namespace seam::measurement {
namespace {

// By scalar: the change of the prediction in units of the noise, then that of the standard
// deviation. Empty where a kind has no residual vectors.
std::vector<double> change_of(const Problem& problem, const Evaluation& here,
                              const Candidate& candidate) {
  const Evaluation there =
      problem.evaluate(candidate.grown.assessment.model, problem.scored_groups());
  if (here.used.empty() || there.used.empty() || !here.valid || !there.valid) return {};
  const size_t n = here.used.size();
  std::vector<double> change(2 * n, 0);
  for (size_t i = 0; i < n; ++i) {
    if (!here.used[i] || !there.used[i] || !(here.sigma[i] > 0)) continue;
    change[i] = (here.residual[i] - there.residual[i]) / here.sigma[i];
    change[n + i] = there.sigma[i] / here.sigma[i] - 1;
  }
  return change;
}

double likeness(const std::vector<double>& a, const std::vector<double>& b) {
  double aa = 0, bb = 0, ab = 0;
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    aa += a[i] * a[i], bb += b[i] * b[i], ab += a[i] * b[i];
  return aa > 0 && bb > 0 ? std::abs(ab) / std::sqrt(aa * bb) : 0;
}

// Moves the effects found to the front, in the order of the steps; returns how many there are.
size_t found_first(SearchResult& result) {
  auto& candidates = result.first.candidates;
  size_t count = 0;
  for (const Step& step : result.steps) {
    const auto place = candidates.begin() + static_cast<std::ptrdiff_t>(count);
    const auto it = std::find_if(place, candidates.end(),
                                 [&](const Candidate& c) { return c.effect->name == step.effect; });
    if (it == candidates.end()) continue;
    it->found = it->significant = true, it->trace = false;
    // What one of several looks like alone is no tie of the whole.
    if (result.steps.size() > 1) it->indistinguishable_from = step.indistinguishable_from;
    std::rotate(place, it, it + 1);
    ++count;
  }
  return count;
}

}  // namespace

void rank_by_search(const Problem& problem, SearchResult& result) {
  const size_t found = found_first(result);
  if (found == 0) return;
  constexpr double kAlike = 0.5;  // The cosine of 60 degrees.
  auto& candidates = result.first.candidates;
  const Evaluation here = problem.evaluate(result.base.assessment.model, problem.scored_groups());
  std::vector<std::vector<double>> changes;
  for (size_t k = 0; k < found; ++k) changes.push_back(change_of(problem, here, candidates[k]));
  for (size_t i = found; i < candidates.size(); ++i) {
    Candidate& candidate = candidates[i];
    if (!candidate.significant) continue;
    const std::vector<double> change = change_of(problem, here, candidate);
    for (size_t k = 0; k < found; ++k) {
      if (likeness(change, changes[k]) > kAlike)
        candidate.stands_in_for.push_back(candidates[k].effect->name);
    }
    // Like none of them alone: for all of them together.
    if (!candidate.stands_in_for.empty()) continue;
    for (size_t k = 0; k < found; ++k)
      candidate.stands_in_for.push_back(candidates[k].effect->name);
  }
}

}  // namespace seam::measurement
