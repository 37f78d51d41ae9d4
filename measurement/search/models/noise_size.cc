// Whether noises are more than another size of the noise that was estimated.
#include <algorithm>
#include <cmath>

#include "measurement/judge/decisions.h"
#include "measurement/search/choice.h"
#include "measurement/search/search.h"

namespace seam::measurement {
namespace {

// Of each channel, by how much its noise is larger than estimated.
struct Sizes {
  std::vector<double> factor;
  double price = 0;  // Of the factors that are worth it.
};

Sizes sizes_of(const Problem& problem, const Evaluation& here) {
  const double price = kPriceOfNumber * std::log(static_cast<double>(count_used(problem)));
  Sizes sizes;
  for (size_t c = 0; c < problem.facts().channels.size(); ++c) {
    sizes.factor.push_back(1);
    if (!problem.facts().channels[c].correctable) continue;
    double chi2 = 0, count = 0;
    for (size_t i = 0; i < problem.facts().scalars(); ++i) {
      if (!here.used[i] || problem.facts().channel_of[i] != static_cast<int>(c)) continue;
      chi2 += here.whitened[i] * here.whitened[i], ++count;
    }
    if (!(chi2 > 0)) continue;
    // The likelihood of normal errors is highest where their mean square is that of the noise.
    const double square = chi2 / count;
    const double gain_ll = 0.5 * count * (square - 1 - std::log(square));
    if (!(gain_ll > price)) continue;
    sizes.factor.back() = std::sqrt(square);
    sizes.price += price;
  }
  return sizes;
}

}  // namespace

bool correct_noise(Problem& problem, const Grown& best) {
  const std::vector<Channel>& channels = problem.facts().channels;
  if (std::ranges::none_of(channels, &Channel::correctable)) return false;
  Grown less = best;
  for (const std::string& name : best.added) {
    if (only_widens(*best.assessment.model.find(name)->definition)) less = without(less, name);
  }
  if (less.added == best.added) return false;
  const auto assess_again = [&] {
    const Model model = less.assessment.model;
    less.assessment = assess(problem, model, less.assessment.unknowns);
    return less.assessment.valid;
  };
  if (!assess_again()) return false;
  Sizes sizes = sizes_of(problem, problem.evaluate(less.assessment.model, problem.all_groups()));
  if (!(sizes.price > 0)) return false;
  const double enough = merit_of(best) - kTieWidth;
  problem.resize_noise(sizes.factor);
  if (assess_again() && merit_of(less) - sizes.price >= enough) return true;
  for (double& factor : sizes.factor) factor = 1 / factor;
  problem.resize_noise(sizes.factor);
  return false;
}

}  // namespace seam::measurement
