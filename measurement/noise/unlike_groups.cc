#include "measurement/noise/unlike_groups.h"

#include <algorithm>
#include <cmath>

#include "measurement/numerics/regression.h"
#include "measurement/numerics/robust.h"

namespace seam::measurement {
namespace {

// Groups that chance makes as unlike in one of a thousand sets are alike.
constexpr double kByChance = 1e-3;
// Sigmas that differ by less than a tenth are as good as alike.
constexpr double kLeastOfSigma = 0.1;
// A scatter of fewer groups is not known.
constexpr size_t kFewestGroups = 4;
// Nor is a sigma of fewer values.
constexpr double kLeastFreedom = 4;

// Values further out than so many sigmas are far ones. A limit that is nearer makes a sigma of few
// values less certain: 3 by a quarter.
constexpr double kFar = 4, kVarianceWithin = 0.9989294;  // Of a unit normal.
// The variance of the logarithm of a variance of n normal values without far ones is so much over
// n, for n of 20 to 200.
constexpr double kOfNormal = 2.2;
// A mean fourth power beyond this (a normal one is 3): values have spreads of their own, and groups
// differ by how many of them are wide. Five sets of real boards stood at 3.0 to 3.7, and one of
// which a quarter of the corners is found badly at 4.5 to 4.9 (docs/evidence/real-boards.md).
constexpr double kOfMixture = 4;

struct Known {
  size_t group;
  double log_variance, chance;  // What chance makes of it, a variance.
};

// That of the values that are not far, and the mean fourth power of these in units of it.
struct Within {
  double sigma = 0, fourth = 0;
};
Within within(const std::vector<double>& values) {
  constexpr int kRounds = 3;
  Within found{.sigma = robust_sigma(values)};
  for (int round = 0; round < kRounds; ++round) {
    double sum2 = 0, sum4 = 0, count = 0;
    for (const double value : values) {
      if (!(std::abs(value) <= kFar * found.sigma)) continue;
      sum2 += value * value, sum4 += value * value * value * value, ++count;
    }
    if (!(sum2 > 0)) return {};
    found = {std::sqrt(sum2 / (count * kVarianceWithin)), count * sum4 / (sum2 * sum2)};
  }
  return found;
}

// Nothing where values are a mixture within groups, too.
std::vector<Known> known_of(const std::vector<ResidualGroup>& groups) {
  std::vector<Known> known;
  double fourth = 0;
  for (size_t g = 0; g < groups.size(); ++g) {
    const Within of_it = within(groups[g].values);
    const double freedom = groups[g].freedom;
    if (!(of_it.sigma > 0) || !(freedom >= kLeastFreedom)) continue;
    // The mean of the logarithm of chi-square over its freedom is -1 / freedom, nearly.
    known.push_back({g, 2 * std::log(of_it.sigma) + 1 / freedom, 1 / freedom});
    fourth += of_it.fourth;
  }
  // Long tails make variances of single groups scatter more.
  const double mean_fourth = fourth / static_cast<double>(known.size());
  if (!(mean_fourth < kOfMixture)) return {};
  for (Known& k : known) k.chance *= std::max(kOfNormal, mean_fourth - 1);
  return known;
}

// The mean of the logarithms where groups differ by this variance beyond chance.
double typical_of(const std::vector<Known>& known, double beyond) {
  double sum = 0, weights = 0;
  for (const Known& k : known)
    sum += k.log_variance / (k.chance + beyond), weights += 1 / (k.chance + beyond);
  return sum / weights;
}

}  // namespace

std::vector<double> spreads_of_groups(const std::vector<ResidualGroup>& groups) {
  const std::vector<Known> known = known_of(groups);
  if (known.size() < kFewestGroups) return {};
  const double alike = typical_of(known, 0);
  double chi2 = 0, weights = 0, weights2 = 0;
  for (const Known& k : known) {
    chi2 += std::pow(k.log_variance - alike, 2) / k.chance;
    weights += 1 / k.chance, weights2 += 1 / (k.chance * k.chance);
  }
  const double freedom = static_cast<double>(known.size()) - 1;
  if (chi2_tail(chi2, freedom) > kByChance) return {};
  // What is left of their scatter beyond chance (DerSimonian and Laird 1986).
  const double beyond = std::max(0.0, chi2 - freedom) / (weights - weights2 / weights);
  if (0.5 * std::sqrt(beyond) < kLeastOfSigma) return {};
  const double typical = typical_of(known, beyond);
  std::vector<double> spreads(groups.size(), 1);
  for (const Known& k : known)
    spreads[k.group] = std::exp(0.5 * beyond / (beyond + k.chance) * (k.log_variance - typical));
  return spreads;
}

}  // namespace seam::measurement
