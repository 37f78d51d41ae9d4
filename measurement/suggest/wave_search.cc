#include "measurement/suggest/wave_search.h"

#include <algorithm>
#include <cmath>

#include "measurement/judge/decisions.h"
#include "measurement/numerics/parallel_for.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

// Least squares on a sine and a cosine.
struct WaveSums {
  double ss = 0, cc = 0, sc = 0, sr = 0, cr = 0;

  double determinant() const { return ss * cc - sc * sc; }
  double gain() const {
    const double d = determinant();
    return d > 1e-9 * ss * cc ? 0.5 * (cc * sr * sr - 2 * sc * sr * cr + ss * cr * cr) / d : 0;
  }
};

}  // namespace

std::optional<FoundWave> strongest_wave(const std::vector<double>& at,
                                        const std::vector<double>& weight,
                                        const std::vector<double>& rest, const Arrives& arrives) {
  if (at.size() < kLeastForWaves) return std::nullopt;
  const auto [low, high] = std::minmax_element(at.begin(), at.end());
  const double span = *high - *low;
  if (!(span > 0)) return std::nullopt;
  const auto look = [&](double frequency) {
    std::vector<double> sine(at.size()), cosine(at.size());
    for (size_t i = 0; i < at.size(); ++i) {
      sine[i] = weight[i] * std::sin(frequency * at[i]);
      cosine[i] = weight[i] * std::cos(frequency * at[i]);
    }
    if (arrives) arrives(sine), arrives(cosine);
    WaveSums sums;
    for (size_t i = 0; i < at.size(); ++i) {
      const double s = sine[i], c = cosine[i];
      sums.ss += s * s, sums.cc += c * c, sums.sc += s * c, sums.sr += s * rest[i];
      sums.cr += c * rest[i];
    }
    return sums;
  };
  const double step = maths::kPi / span;
  std::vector<double> gains(kMostWaves + 1, 0);
  parallel_for(kMostWaves - 1, [&](size_t k) { gains[k + 2] = look((k + 2.0) * step).gain(); });
  // Rows at even steps show two frequencies alike: of equals the slower one.
  const double most = *std::max_element(gains.begin(), gains.end());
  double frequency = 0, best = 0;
  for (size_t k = 2; k < gains.size(); ++k) {
    const bool peak =
        gains[k] >= gains[k - 1] && (k + 1 == gains.size() || gains[k] > gains[k + 1]);
    if (!peak || gains[k] < kNearlyAsStrong * most) continue;
    double f = static_cast<double>(k) * step;
    for (double width = 0.5 * step; width > 1e-4 * step; width *= 0.6) {
      for (const double other : {f - width, f + width}) {
        if (other > step && look(other).gain() > look(f).gain()) f = other;
      }
    }
    const double here = look(f).gain();
    if (here > kClearlyStronger * best) frequency = f, best = here;
  }
  const WaveSums sums = look(frequency);
  const double gain = sums.gain();
  if (!(gain > 0)) return std::nullopt;
  const double d = sums.determinant();
  const double by_sine = -(sums.cc * sums.sr - sums.sc * sums.cr) / d;
  const double by_cosine = -(sums.ss * sums.cr - sums.sc * sums.sr) / d;
  return FoundWave{frequency, std::atan2(by_cosine, by_sine), std::hypot(by_sine, by_cosine), gain};
}

}  // namespace seam::measurement
