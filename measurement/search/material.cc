#include "measurement/search/material.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/search/decisions.h"

namespace seam::measurement {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// What a gain of likelihood says of a change of each observation.
double movement_of_gain(double gain, int64_t observations, bool spread_only) {
  if (!std::isfinite(gain)) return kInfinity;
  const double each = std::max(0.0, gain) / static_cast<double>(std::max<int64_t>(1, observations));
  return std::sqrt(spread_only ? each : 2 * each);
}

}  // namespace

double movement(const Problem& problem, const Assessment& before, const Assessment& after,
                bool spread_only) {
  const std::vector<Groups>& folds = problem.folds();
  const Groups held = folds.size() == 1 ? folds.front() : problem.all_groups();
  const Evaluation old = problem.evaluate(before.model, held);
  const Evaluation now = problem.evaluate(after.model, held);
  if (old.used.empty() || now.used.empty())
    return movement_of_gain(after.held_ll() - before.held_ll(), after.held.n, spread_only);
  // A model that predicts nothing for some observation differs by anything.
  if (!old.valid || !now.valid) return kInfinity;
  const Facts& facts = problem.facts();
  std::vector<double> mean2(facts.channels.size(), 0), spread2 = mean2, count = mean2;
  for (size_t i = 0; i < facts.scalars(); ++i) {
    if (!old.used[i] || !now.used[i] || !(old.sigma[i] > 0)) continue;
    const double mean = (old.residual[i] - now.residual[i]) / old.sigma[i];
    const double spread = now.sigma[i] / old.sigma[i] - 1;
    const int channel = facts.channel_of[i];
    mean2[channel] += mean * mean, spread2[channel] += spread * spread, ++count[channel];
  }
  double most = 0;
  for (size_t c = 0; c < count.size(); ++c) {
    if (count[c] == 0) continue;
    const double of_mean = spread_only ? 0 : mean2[c];
    most = std::max(most, std::sqrt(std::max(of_mean, spread2[c]) / count[c]));
  }
  return most;
}

double noise_units(const Problem& problem, const Assessment& assessment,
                   const Structure& structure) {
  double noise = noise_of(problem.facts(), structure.residual);
  if (!(noise > 0)) {
    const auto& channels = problem.facts().channels;
    for (size_t c = 0; c < channels.size() && c < assessment.held.native.size(); ++c) {
      if (channels[c].name == structure.residual)
        noise = assessment.held.native[c] / assessment.error;
    }
  }
  return noise > 0 ? structure.strength / noise : kInfinity;
}

SplitStructure significant_structure(const Problem& problem, const Assessment& assessment,
                                     double material) {
  SplitStructure split;
  for (Structure& s : problem.structure(assessment.model, problem.all_groups(),
                                        static_cast<int>(assessment.unknowns.size()))) {
    if (s.p_value >= kStructureAlarm) continue;
    // Written so that a strength that is no number is never hidden.
    const bool trace = noise_units(problem, assessment, s) < material;
    (trace ? split.traces : split.material).push_back(std::move(s));
  }
  return split;
}

bool has_mean_structure(const std::vector<Structure>& structure) {
  return std::any_of(structure.begin(), structure.end(),
                     [](const Structure& s) { return s.moment == "mean"; });
}

}  // namespace seam::measurement
