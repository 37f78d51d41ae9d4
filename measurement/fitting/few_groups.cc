#include "measurement/fitting/few_groups.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "sim_core/base/random.h"

namespace seam::measurement {

namespace {

constexpr double kWorthIt = 2;  // Times as many in all groups.

double sum(const std::vector<double>& counts) {
  return std::accumulate(counts.begin(), counts.end(), 0.0);
}

// Residuals that take part, of these groups: by channel, or all together.
struct Counts {
  Counts(const Problem& problem, const Groups& groups, bool by_channel) {
    const Facts& facts = problem.facts();
    const size_t channels = by_channel ? facts.channels.size() : 1;
    of_group.assign(facts.groups.size(), std::vector<double>(channels, 0));
    all.assign(channels, 0);
    for (size_t i = 0; i < facts.scalars(); ++i) {
      const auto group = static_cast<size_t>(facts.group_of(i));
      if (!groups[group] || problem.left_out(i)) continue;
      const size_t channel = by_channel ? static_cast<size_t>(facts.channel_of[i]) : 0;
      ++of_group[group][channel], ++all[channel];
    }
  }
  std::vector<std::vector<double>> of_group;
  std::vector<double> all;
};

// Whether so many are `enough` of each channel, or all that there are.
bool suffice(const std::vector<double>& taken, const Counts& counts, double enough) {
  for (size_t c = 0; c < taken.size(); ++c) {
    if (taken[c] < std::min(enough, counts.all[c])) return false;
  }
  return true;
}

std::optional<FewRows> beginnings_of(const Problem& problem, const Groups& groups,
                                     const Counts& counts, bool by_channel, double enough) {
  const std::vector<double> taken = Counts(*problem.beginnings(), groups, by_channel).all;
  if (!suffice(taken, counts, enough) || sum(taken) * kWorthIt > sum(counts.all))
    return std::nullopt;
  return FewRows{problem.beginnings(), groups};
}

// Beginnings of these groups, or else some of them, taken as if by lot, until `enough` of each
// channel (of all together where not `by_channel`) are taken.
std::optional<FewRows> some_of(const Problem& problem, const Groups& groups, bool by_channel,
                               double enough) {
  constexpr size_t kLeastGroups = 6;
  const Counts counts(problem, groups, by_channel);
  if (problem.beginnings()) return beginnings_of(problem, groups, counts, by_channel, enough);
  constexpr RandomStream kLot{.seed = 5000};
  std::vector<std::pair<double, size_t>> order;
  for (size_t g = 0; g < groups.size(); ++g) {
    if (sum(counts.of_group[g]) > 0) order.emplace_back(uniform(kLot, g), g);
  }
  std::sort(order.begin(), order.end());
  Groups few(groups.size(), 0);
  std::vector<double> taken(counts.all.size(), 0);
  size_t used = 0;
  for (const auto& [lot, group] : order) {
    if (used >= kLeastGroups && suffice(taken, counts, enough)) break;
    few[group] = 1, ++used;
    for (size_t c = 0; c < taken.size(); ++c) taken[c] += counts.of_group[group][c];
  }
  if (sum(taken) * kWorthIt > sum(counts.all)) return std::nullopt;
  return FewRows{&problem, few};
}

}  // namespace

double residuals_of(const FewRows& few) {
  return sum(Counts(*few.problem, few.groups, /*by_channel=*/false).all);
}

std::optional<FewRows> few_of(const Problem& problem, const Model& model, const Groups& groups) {
  constexpr double kFewResiduals = 4000;
  if (static_cast<double>(problem.facts().scalars()) < kWorthIt * kFewResiduals)
    return std::nullopt;
  if (!problem.groups_are_independent(model)) return std::nullopt;
  return some_of(problem, groups, /*by_channel=*/false, kFewResiduals);
}

std::optional<FewRows> enough_to_tell(const Problem& problem, const Model& model,
                                      const Groups& groups, double material) {
  constexpr double kPlain = 20;  // Units of likelihood: a chance of 2e-10 for one parameter.
  if (!(material > 0) || problem.facts().channels.empty()) return std::nullopt;
  if (!problem.groups_are_independent(model)) return std::nullopt;
  return some_of(problem, groups, /*by_channel=*/true, 2 * kPlain / (material * material));
}

}  // namespace seam::measurement
