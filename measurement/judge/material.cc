#include "measurement/judge/material.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/judge/decisions.h"
#include "measurement/problem/residual_view.h"

namespace seam::measurement {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// What a gain of likelihood says of a change of each observation.
double movement_of_gain(double gain, int64_t observations, bool spread_only) {
  if (!std::isfinite(gain)) return kInfinity;
  const double each = std::max(0.0, gain) / static_cast<double>(std::max<int64_t>(1, observations));
  return std::sqrt(spread_only ? each : 2 * each);
}

// Root mean square by which the predicted means differ, in noise of a single value; 0 where that is
// not known. What values share (an offset of a row, a lamp's light) makes a change of all of them
// less likely a gain, not smaller.
double movement_of_means(const Problem& problem, const Assessment& before,
                         const Assessment& after) {
  const ResidualView was = problem.residual_view(before.model, problem.scored_groups()),
                     is = problem.residual_view(after.model, problem.scored_groups());
  const auto& channels = problem.facts().channels;
  double moved = 0;
  for (size_t c = 0; c < channels.size() && c < before.held.native.size(); ++c) {
    const ResidualView::Channel *a = was.channel(channels[c].name),
                                *b = is.channel(channels[c].name);
    const double noise = before.held.native[c] / std::max(1.0, before.error);
    if (a == nullptr || b == nullptr || a->residual.size() != b->residual.size() || !(noise > 0))
      continue;
    double sum2 = 0;
    for (size_t i = 0; i < a->residual.size(); ++i) {
      const double change = a->residual[i] - b->residual[i];
      sum2 += change * change;
    }
    const auto n = static_cast<double>(std::max<size_t>(1, a->residual.size()));
    moved = std::max(moved, std::sqrt(sum2 / n) / noise);
  }
  return moved;
}

// Root mean square by which standard deviations of single values change, relative to what they
// were; 0 where that is not known. What values share (a lamp's light in a frame) gains as little
// likelihood as there are frames, however far it moves them.
double change_of_spreads(const Problem& problem, const Assessment& before,
                         const Assessment& after) {
  const ResidualView was = problem.residual_view(before.model, problem.scored_groups()),
                     is = problem.residual_view(after.model, problem.scored_groups());
  double most = 0;
  for (const ResidualView::Channel& a : was.channels) {
    const ResidualView::Channel* b = is.channel(a.name);
    if (b == nullptr || a.value_sigma.empty() || a.value_sigma.size() != b->value_sigma.size())
      continue;
    double sum2 = 0;
    for (size_t i = 0; i < a.value_sigma.size(); ++i) {
      const double change = b->value_sigma[i] / a.value_sigma[i] - 1;
      sum2 += change * change;
    }
    most = std::max(most, std::sqrt(sum2 / static_cast<double>(a.value_sigma.size())));
  }
  return most;
}

}  // namespace

double limit_at_noise(double n) {
  constexpr double kSigmas = 3;
  return std::max(kMisfit, 1 + kSigmas / std::sqrt(2 * n));
}

Change change_by(const Problem& problem, const Evaluation& here, const Assessment& before,
                 const Assessment& after, bool spread_only) {
  const Evaluation there = problem.evaluate_held_out(after.model, problem.scored_groups());
  if (here.used.empty() || there.used.empty()) {
    const double of_gain =
        movement_of_gain(after.held_ll() - before.held_ll(), after.held.n, spread_only);
    const double of_model = spread_only ? change_of_spreads(problem, before, after)
                                        : movement_of_means(problem, before, after);
    return {std::max(of_gain, of_model),
            after.error <= limit_at_noise(static_cast<double>(after.held.n))};
  }
  // A model that predicts nothing for some observation differs by anything.
  if (!here.valid || !there.valid) return {.moved = kInfinity};
  const Facts& facts = problem.facts();
  std::vector<double> mean2(facts.channels.size(), 0), spread2 = mean2, count = mean2, chi2 = mean2,
                                                       expected = mean2;
  for (size_t i = 0; i < facts.scalars(); ++i) {
    if (!here.used[i] || !there.used[i] || !(here.sigma[i] > 0)) continue;
    const double mean = (here.residual[i] - there.residual[i]) / here.sigma[i];
    const double spread = there.sigma[i] / here.sigma[i] - 1;
    const int channel = facts.channel_of[i];
    mean2[channel] += mean * mean, spread2[channel] += spread * spread, ++count[channel];
    chi2[channel] += there.whitened[i] * there.whitened[i];
    expected[channel] += there.mean_square.empty() ? 1 : there.mean_square[i];
  }
  constexpr double kWidens = 0.01;  // Standard deviations that change by less stay as they are.
  Change change;
  for (size_t c = 0; c < count.size(); ++c) {
    if (count[c] == 0) continue;
    const double of_mean = spread_only ? 0 : mean2[c];
    change.moved = std::max(change.moved, std::sqrt(std::max(of_mean, spread2[c]) / count[c]));
    if (spread2[c] > kWidens * kWidens * count[c] &&
        chi2[c] > std::pow(limit_at_noise(count[c]), 2) * expected[c])
      change.at_noise = false;
  }
  // Where a few errors are far larger than the others, standard deviations are theirs: by how much
  // an effect of the mean moves all others the likelihood says.
  if (!spread_only && !here.mean_square.empty()) {
    const double gain = after.held_ll() - before.held_ll();
    change.moved = std::max(change.moved, movement_of_gain(gain, after.held.n, false));
  }
  return change;
}

double native_fall(const Score& before, const Score& after) {
  double logs = 0, count = 0;
  for (size_t c = 0; c < after.native.size() && c < before.native.size(); ++c) {
    const double n = static_cast<double>(after.native_count[c]);
    if (!(before.native[c] > 0) || !(after.native[c] > 0)) continue;
    logs += n * std::log(after.native[c] / before.native[c]), count += n;
  }
  return count > 0 ? 1 - std::exp(logs / count) : 0;
}

bool hides_mean(const Problem& problem, const Assessment& before, const Assessment& with_spread) {
  const bool far = before.error > kUseless;
  const auto left = problem.structure(with_spread.model, problem.all_groups(),
                                      static_cast<int>(with_spread.unknowns.size()));
  return std::any_of(left.begin(), left.end(), [&](const Structure& s) {
    return s.moment == "mean" && s.p_value < kAlarm &&
           s.explained > (far ? kHiddenMeanFar : kHiddenMean);
  });
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
    if (s.p_value >= kAlarm) continue;
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
