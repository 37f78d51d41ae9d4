#include "measurement/kinds/odometry/tick_errors.h"

#include <algorithm>
#include <cmath>

namespace seam::measurement {
namespace {

// Of an error that is anywhere within half a tick.
constexpr double kRounding2 = 1.0 / 12;
// Rows before and after that tell how fast a wheel turns.
constexpr size_t kReach = 5;
// A part of the noise that is material (docs/definitions.md).
constexpr double kMaterial = 0.1;

// A wheel that turns by this share of a tick has a rounding error that goes with the one before, as
// a saw-tooth goes with itself; what turns further has another, which nothing foretells.
double saw_tooth_correlation(double ticks) {
  constexpr double kZero = 0.2113;  // Of 1 - 6 x (1 - x).
  return ticks < kZero ? 1 - 6 * ticks * (1 - ticks) : 0;
}

// A pose's time, by the row before it and the share of the way to the next.
struct BetweenRows {
  size_t row = 0;
  double share = 0;
};

BetweenRows place_in(const WalkRun& run, double t_s) {
  const auto after = std::upper_bound(run.time_s.begin(), run.time_s.end(), t_s);
  if (after == run.time_s.begin()) return {};
  const auto row = static_cast<size_t>(after - run.time_s.begin()) - 1;
  if (after == run.time_s.end()) return {row, 0};
  return {row, (t_s - run.time_s[row]) / (run.time_s[row + 1] - run.time_s[row])};
}

// Covariance of the errors at two places, each a mean of the two rows about it.
double covariance(const std::vector<std::array<double, 2>>& correlation, size_t wheel,
                  const BetweenRows& a, const BetweenRows& b) {
  double sum = 0;
  for (size_t i = 0; i < 2; ++i) {
    for (size_t k = 0; k < 2; ++k) {
      const double weight = (i ? a.share : 1 - a.share) * (k ? b.share : 1 - b.share);
      if (weight == 0) continue;
      double together = kRounding2;
      const size_t first = std::min(a.row + i, b.row + k), last = std::max(a.row + i, b.row + k);
      for (size_t row = first + 1; row <= last && together != 0; ++row)
        together *= correlation[row][wheel];
      sum += weight * together;
    }
  }
  return sum;
}

// The shortest string through a tube of one up and down about `middle`, whose ends are fixed: by
// straight pieces from each point at which it touches.
std::vector<double> taut_string(const std::vector<double>& x, const std::vector<double>& middle) {
  constexpr size_t kLongest = 400;  // Rows of a piece: what is looked through again is bounded.
  std::vector<double> string = middle;
  for (size_t from = 0; from + 1 < x.size();) {
    double least = -HUGE_VAL, most = HUGE_VAL;  // Slopes that stay in the tube.
    size_t low = from, high = from;             // Where they touch it.
    size_t to = from;
    double end = 0;
    const size_t last = std::min(x.size() - 1, from + kLongest);
    for (size_t k = from + 1; to == from; ++k) {
      const double width = k == last ? 0 : 1, run = x[k] - x[from];
      const double below = (middle[k] - width - string[from]) / run,
                   above = (middle[k] + width - string[from]) / run;
      if (below > most) {
        to = high, end = middle[high] + 1;
      } else if (above < least) {
        to = low, end = middle[low] - 1;
      } else if (k == last) {
        to = last, end = middle[last];
      }
      if (below > least) least = below, low = k;
      if (above < most) most = above, high = k;
    }
    const double slope = (end - string[from]) / (x[to] - x[from]);
    for (size_t k = from + 1; k <= to; ++k) string[k] = string[from] + slope * (x[k] - x[from]);
    from = to;
  }
  return string;
}

// A string is as short as it can be, and so turns less than what it follows wherever that bends:
// the mean of what is left about each row is put back.
std::vector<double> steadied(const std::vector<double>& x, const std::vector<double>& middle) {
  constexpr size_t kAbout = 10;  // Rows on either side.
  const std::vector<double> string = taut_string(x, middle);
  std::vector<double> sum(x.size() + 1, 0), out = string;
  for (size_t k = 0; k < x.size(); ++k) sum[k + 1] = sum[k] + middle[k] - string[k];
  for (size_t k = 0; k < x.size(); ++k) {
    const size_t about = std::min({kAbout, k, x.size() - 1 - k});
    out[k] += (sum[k + about + 1] - sum[k - about]) / static_cast<double>(2 * about + 1);
  }
  return out;
}

}  // namespace

bool counts(const WalkRun& run) {
  return !run.ticks.empty() &&
         std::all_of(run.ticks.begin(), run.ticks.end(), [](const auto& ticks) {
           return ticks[0] == std::round(ticks[0]) && ticks[1] == std::round(ticks[1]);
         });
}

std::vector<std::array<double, 2>> steady_ticks(const WalkRun& run) {
  if (!counts(run)) return {};
  std::array<std::vector<double>, 2> gathered;  // Sum and difference.
  std::array<double, 2> so_far{};
  for (const auto& [left, right] : run.ticks) {
    gathered[0].push_back(so_far[0] += left + right);
    gathered[1].push_back(so_far[1] += right - left);
  }
  const std::vector<double> sum = steadied(run.time_s, gathered[0]),
                            difference = steadied(run.time_s, gathered[1]);
  std::vector<std::array<double, 2>> steady(run.ticks.size(), {0, 0});
  for (size_t k = 1; k < steady.size(); ++k) {
    const double both = sum[k] - sum[k - 1], turn = difference[k] - difference[k - 1];
    steady[k] = {0.5 * (both - turn), 0.5 * (both + turn)};
  }
  return steady;
}

std::vector<std::array<double, 2>> count_correlations(const WalkRun& run) {
  const size_t rows = run.ticks.size();
  std::vector<std::array<double, 2>> all(rows, {0, 0});
  for (size_t wheel = 0; wheel < 2; ++wheel) {
    for (size_t k = 1; k < rows; ++k) {
      const size_t from = k > kReach ? k - kReach : 1, to = std::min(k + kReach, rows - 1);
      double turned = 0;
      for (size_t i = from; i <= to; ++i) turned += std::abs(run.ticks[i][wheel]);
      all[k][wheel] = saw_tooth_correlation(turned / static_cast<double>(to - from + 1));
    }
  }
  return all;
}

CountErrors count_errors(const WalkRun& run, const effects::Timing& timing) {
  if (!counts(run)) return {};
  const auto correlation = count_correlations(run);
  CountErrors all(run.rows.size());
  BetweenRows before;
  for (size_t k = 0; k < run.rows.size(); ++k) {
    const double t_s = run.time_s[k] + timing.row_middle_after_stamp_s(0, run.time_s[k]);
    const BetweenRows here = place_in(run, t_s);
    for (size_t wheel = 0; wheel < 2; ++wheel) {
      CountError& error = all[k][wheel];
      error.variance = covariance(correlation, wheel, here, here);
      error.fresh = error.variance;
      if (k > 0) {
        const double last = all[k - 1][wheel].variance;
        error.kept = covariance(correlation, wheel, before, here) / last;
        error.fresh = std::max(0.0, error.variance - error.kept * error.kept * last);
      }
    }
    before = here;
  }
  return all;
}

bool counting_matters(const effects::Wheels& wheels, const std::array<double, 3>& noise) {
  // Along the body by half of each wheel's error, and of that in x or y a part that turns with it.
  const double tick_m = wheels.metres_per_tick * std::sqrt(kRounding2);
  const double xy_m = 0.5 * tick_m, turn_rad = tick_m * std::sqrt(2.0) / wheels.base_m;
  const auto is_material = [](double error, double sigma) {
    return sigma > 0 && error > kMaterial * sigma;
  };
  return wheels.driven && (is_material(xy_m, noise[0]) || is_material(xy_m, noise[1]) ||
                           is_material(turn_rad, noise[2]));
}

}  // namespace seam::measurement
