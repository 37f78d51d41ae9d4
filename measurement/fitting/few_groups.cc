#include "measurement/fitting/few_groups.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "sim_core/base/random.h"

namespace seam::measurement {

namespace {

constexpr double kWorthIt = 2;  // Times as many in all groups.

// Some of these groups, taken as if by lot, until `enough` of each channel (of all together where
// `enough` has one number) are taken. A channel that they have less of is taken whole.
std::optional<Groups> some_of(const Problem& problem, const Groups& groups, bool by_channel,
                              double enough) {
  constexpr size_t kLeastGroups = 6;
  const Facts& facts = problem.facts();
  const size_t channels = by_channel ? facts.channels.size() : 1;
  std::vector<std::vector<double>> count(facts.groups.size(), std::vector<double>(channels, 0));
  std::vector<double> all(channels, 0);
  std::vector<char> shown(facts.groups.size(), 0);
  for (size_t i = 0; i < facts.scalars(); ++i) {
    const auto group = static_cast<size_t>(facts.group_of(i));
    if (!groups[group] || problem.left_out(i)) continue;
    const size_t channel = by_channel ? static_cast<size_t>(facts.channel_of[i]) : 0;
    ++count[group][channel], ++all[channel], shown[group] = 1;
  }
  constexpr RandomStream kLot{.seed = 5000};
  std::vector<std::pair<double, size_t>> order;
  for (size_t g = 0; g < count.size(); ++g) {
    if (shown[g]) order.emplace_back(uniform(kLot, g), g);
  }
  std::sort(order.begin(), order.end());
  Groups few(groups.size(), 0);
  std::vector<double> taken(channels, 0);
  const auto lacks = [&] {
    for (size_t c = 0; c < channels; ++c) {
      if (taken[c] < std::min(enough, all[c])) return true;
    }
    return false;
  };
  size_t used = 0;
  for (const auto& [lot, group] : order) {
    if (used >= kLeastGroups && !lacks()) break;
    few[group] = 1, ++used;
    for (size_t c = 0; c < channels; ++c) taken[c] += count[group][c];
  }
  const double of_few = std::accumulate(taken.begin(), taken.end(), 0.0);
  const double of_all = std::accumulate(all.begin(), all.end(), 0.0);
  if (of_few * kWorthIt > of_all) return std::nullopt;
  return few;
}

}  // namespace

std::optional<Groups> few_of(const Problem& problem, const Model& model, const Groups& groups) {
  constexpr double kFewResiduals = 4000;
  if (static_cast<double>(problem.facts().scalars()) < kWorthIt * kFewResiduals)
    return std::nullopt;
  if (!problem.groups_are_independent(model)) return std::nullopt;
  return some_of(problem, groups, /*by_channel=*/false, kFewResiduals);
}

std::optional<Groups> enough_to_tell(const Problem& problem, const Model& model,
                                     const Groups& groups, double material) {
  constexpr double kPlain = 20;  // Units of likelihood: a chance of 2e-10 for one parameter.
  if (!(material > 0) || problem.facts().channels.empty()) return std::nullopt;
  if (!problem.groups_are_independent(model)) return std::nullopt;
  return some_of(problem, groups, /*by_channel=*/true, 2 * kPlain / (material * material));
}

}  // namespace seam::measurement
