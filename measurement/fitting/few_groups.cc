#include "measurement/fitting/few_groups.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "sim_core/base/random.h"

namespace seam::measurement {

std::optional<Groups> few_of(const Problem& problem, const Model& model, const Groups& groups) {
  constexpr size_t kFewResiduals = 4000;
  constexpr size_t kLeastGroups = 6;
  constexpr size_t kWorthIt = 2;  // Times as many in all groups.
  const Facts& facts = problem.facts();
  if (facts.scalars() < kWorthIt * kFewResiduals) return std::nullopt;
  if (!problem.groups_are_independent(model)) return std::nullopt;
  std::vector<size_t> count(facts.groups.size(), 0);
  size_t all = 0;
  for (size_t i = 0; i < facts.scalars(); ++i) {
    const auto group = static_cast<size_t>(facts.group_of(i));
    if (!groups[group] || problem.left_out(i)) continue;
    ++count[group], ++all;
  }
  constexpr RandomStream kLot{.seed = 5000};
  std::vector<std::pair<double, size_t>> order;
  for (size_t g = 0; g < count.size(); ++g) {
    if (count[g] > 0) order.emplace_back(uniform(kLot, g), g);
  }
  std::sort(order.begin(), order.end());
  Groups few(groups.size(), 0);
  size_t taken = 0, residuals = 0;
  for (const auto& [lot, group] : order) {
    if (residuals >= kFewResiduals && taken >= kLeastGroups) break;
    few[group] = 1;
    ++taken, residuals += count[group];
  }
  if (residuals * kWorthIt > all) return std::nullopt;
  return few;
}

}  // namespace seam::measurement
