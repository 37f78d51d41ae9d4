#include "measurement/suggest/bump_search.h"

#include <algorithm>
#include <cmath>

#include "measurement/judge/decisions.h"
#include "measurement/numerics/parallel_for.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

// Places half a width apart, and widths each half the one before: a bump between two of them has
// nine tenths of its gain.
constexpr int kWidths = 5;

}  // namespace

std::optional<FoundBump> strongest_bump(const std::vector<double>& at,
                                        const std::vector<double>& weight,
                                        const std::vector<double>& rest, const Arrives& arrives) {
  if (at.size() < kLeastForWaves) return std::nullopt;
  const auto [low, high] = std::minmax_element(at.begin(), at.end());
  const double from = *low, span = *high - *low;
  if (!(span > 0)) return std::nullopt;
  std::vector<FoundBump> bumps;
  double width = 0.5 * span;
  for (int k = 0; k < kWidths; ++k, width *= 0.5) {
    for (double place = from; place <= from + span; place += 0.5 * width)
      bumps.push_back({place, width});
  }
  std::vector<double> gains(bumps.size());
  parallel_for(bumps.size(), [&](size_t b) {
    std::vector<double> there(at.size(), 0);
    for (size_t i = 0; i < at.size(); ++i) {
      const double off = (at[i] - bumps[b].place) / bumps[b].width;
      if (std::abs(off) < 4) there[i] = weight[i] * maths::exp(-off * off);
    }
    if (arrives) arrives(there);
    double square = 0, along = 0;
    for (size_t i = 0; i < at.size(); ++i)
      square += there[i] * there[i], along += there[i] * rest[i];
    gains[b] = square > 0 ? along * along / square : 0;
  });
  return bumps[static_cast<size_t>(std::max_element(gains.begin(), gains.end()) - gains.begin())];
}

}  // namespace seam::measurement
