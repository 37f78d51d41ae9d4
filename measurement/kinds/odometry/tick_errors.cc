#include "measurement/kinds/odometry/tick_errors.h"

#include <algorithm>
#include <cmath>

namespace seam::measurement {
namespace {

// Of an error that is anywhere within half a tick.
constexpr double kRounding2 = 1.0 / 12;
// A part of the noise that is material (docs/reference/definitions.md).
constexpr double kMaterial = 0.1;

CountedWay counted_way(const WalkRun& run, size_t wheel) {
  CountedWay way{.time_s = run.time_s, .ticks = {0}};
  for (size_t k = 1; k < run.ticks.size(); ++k)
    way.ticks.push_back(way.ticks.back() + run.ticks[k][wheel]);
  return way;
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

// One sigma of what the ways of both wheels are off together by in each row more than before.
std::vector<double> turn_errors(const WalkRun& run) {
  std::vector<double> variance(run.time_s.size(), 0);
  for (const RolledWay& way : run.ways) {
    Eigen::Matrix2d P = way.at_start();
    for (size_t k = 1; k < variance.size(); ++k) {
      const RolledWay::Step step = way.step(run.time_s[k - 1], run.time_s[k]);
      const double before = P(0, 0), shared = (step.kept * P)(0, 0);
      P = step.kept * P * step.kept.transpose() + step.fresh;
      variance[k] += P(0, 0) + before - 2 * shared;
    }
  }
  for (double& of_row : variance) of_row = std::sqrt(std::max(0.0, of_row));
  return variance;
}

// Whatever a body that goes straight on is thought to turn, it would slip by. So where no turning
// is seen, it turns as little as counts allow on its way between the rows that do.
std::vector<std::array<double, 2>> slip_ticks(const WalkRun& run) {
  constexpr double kSeen = 2;  // Sigmas.
  const std::vector<double>&left = run.ways[0].mean(), &right = run.ways[1].mean();
  std::vector<double> apart = {0}, sigma = turn_errors(run);
  for (size_t k = 1; k < run.ticks.size(); ++k)
    apart.push_back(apart.back() + run.ticks[k][1] - run.ticks[k][0]);
  const std::vector<double> string = taut_string(run.time_s, apart);
  const auto turns = [&](size_t k) {
    return std::abs(string[k] - string[k - 1]) >= kSeen * sigma[k];
  };
  std::vector<std::array<double, 2>> ticks = run.rolled_ticks;
  for (size_t from = 1, to = 1; from < ticks.size(); from = to) {
    to = from + 1;
    if (turns(from)) continue;
    while (to < ticks.size() && !turns(to)) ++to;
    const auto part = [&](const std::vector<double>& all) {
      return std::vector<double>(all.begin() + static_cast<std::ptrdiff_t>(from - 1),
                                 all.begin() + static_cast<std::ptrdiff_t>(to));
    };
    std::vector<double> tube = part(apart);
    tube.front() = right[from - 1] - left[from - 1], tube.back() = right[to - 1] - left[to - 1];
    const std::vector<double> way = taut_string(part(run.time_s), tube);
    for (size_t k = from; k < to; ++k) {
      const double turn = way[k - from + 1] - way[k - from], both = ticks[k][0] + ticks[k][1];
      ticks[k] = {0.5 * (both - turn), 0.5 * (both + turn)};
    }
  }
  return ticks;
}

}  // namespace

bool counts(const WalkRun& run) {
  return !run.ticks.empty() &&
         std::all_of(run.ticks.begin(), run.ticks.end(), [](const auto& ticks) {
           return ticks[0] == std::round(ticks[0]) && ticks[1] == std::round(ticks[1]);
         });
}

void find_ways(std::vector<WalkRun>& runs) {
  std::vector<CountedWay> counted;
  for (const WalkRun& run : runs) {
    if (!counts(run)) continue;
    for (size_t wheel = 0; wheel < 2; ++wheel) counted.push_back(counted_way(run, wheel));
  }
  const double jolt = jolt_of(counted);
  for (WalkRun& run : runs) {
    if (!counts(run)) continue;
    run.rolled_ticks.assign(run.ticks.size(), {0, 0});
    for (size_t wheel = 0; wheel < 2; ++wheel) {
      run.ways.emplace_back(counted_way(run, wheel), jolt);
      const std::vector<double>& mean = run.ways.back().mean();
      for (size_t k = 1; k < mean.size(); ++k) run.rolled_ticks[k][wheel] = mean[k] - mean[k - 1];
    }
    run.slip_ticks = slip_ticks(run);
  }
}

CountErrors count_errors(const WalkRun& run, const effects::Timing& timing) {
  CountErrors errors;
  if (run.ways.empty()) return errors;
  errors.step.resize(run.rows.size());
  double last_s = 0;
  for (size_t k = 0; k < run.rows.size(); ++k) {
    const double here_s =
        std::max(last_s, run.time_s[k] + timing.row_middle_after_stamp_s(0, run.time_s[k]));
    for (size_t wheel = 0; wheel < 2; ++wheel)
      errors.step[k][wheel] = run.ways[wheel].step(last_s, here_s);
    last_s = here_s;
  }
  for (size_t wheel = 0; wheel < 2; ++wheel) {
    const RolledWay::Step& to_first = errors.step[0][wheel];
    errors.first[wheel] =
        to_first.kept * run.ways[wheel].at_start() * to_first.kept.transpose() + to_first.fresh;
  }
  return errors;
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
