#include "measurement/noise/value_steps.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

using Values = std::vector<double>;

// Mean resultant length of the phases: a last digit of half the step leaves 0.64.
constexpr double kAgreed = 0.62;
// Rayleigh's statistic (count times the square of the length) that is no chance over all
// frequencies that are tried. Of fewer values the phases must agree better, and each must stand in
// several rows, which no noise repeats.
constexpr double kNoChance = 30, kAgreedOfFew = 0.8, kRowsOfValue = 5;
// Of differences: 1 where all agree, 0 for random ones.
constexpr double kAgreedDifferences = 0.4;
// Differences up to so many gaps are looked at first, then up to kWiden times as much.
constexpr double kReach = 12, kWiden = 4;
// Steps from this many gaps down to a fraction of one: neighbours may all be some steps apart.
constexpr double kLargest = 2.5, kSmallest = 1 / 4.5;
constexpr size_t kMostFrom = 400, kEach = 4;

Values distinct(Values values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

// Of values within a series, more than `least` and no more than `most` apart: some of each of many,
// evenly chosen.
Values differences(const std::vector<Values>& series, double least, double most) {
  Values all;
  for (const Values& sorted : series) {
    const size_t from = std::min(kMostFrom / series.size() + 1, sorted.size());
    for (size_t k = 0; k < from; ++k) {
      const double x = sorted[k * sorted.size() / from];
      const auto low = std::upper_bound(sorted.begin(), sorted.end(), x + least),
                 high = std::upper_bound(low, sorted.end(), x + most);
      const std::ptrdiff_t count = high - low, taken = std::min<std::ptrdiff_t>(count, kEach);
      for (std::ptrdiff_t i = 0; i < taken; ++i) all.push_back(low[i * count / taken] - x);
    }
  }
  return all;
}

// A parabola in place of the periodogram's cosine: its mean over a turn is 0, too.
double agreement(const Values& apart, double frequency) {
  double sum = 0;
  for (const double d : apart) {
    const double turns = d * frequency, off = turns - std::floor(turns + 0.5);
    sum += 1 - 12 * off * off;
  }
  return apart.empty() ? 0 : sum / static_cast<double>(apart.size());
}

// The best of a grid around a frequency.
double nearer(const Values& apart, double frequency, double to_either_side, int looks) {
  double best = agreement(apart, frequency), at = frequency;
  for (int k = -looks; k <= looks; ++k) {
    const double there = frequency + to_either_side * k / looks, value = agreement(apart, there);
    if (value > best) best = value, at = there;
  }
  return at;
}

// Counts of steps by least squares; nothing where the phases disagree.
std::optional<double> step_at(const std::vector<Values>& series, size_t rows, double frequency) {
  double agreed = 0, count = 0, kk = 0, kx = 0;
  for (const Values& values : series) {
    double c = 0, s = 0;
    for (const double x : values) {
      const double turn = 2 * std::numbers::pi * std::fmod(x * frequency, 1.0);
      c += maths::cos(turn), s += maths::sin(turn);
    }
    agreed += std::hypot(c, s), count += static_cast<double>(values.size());
    const double offset = maths::atan2(s, c) / (2 * std::numbers::pi);
    double mean_k = 0, mean_x = 0;
    const auto steps = [&](double x) { return std::round(x * frequency - offset); };
    for (const double x : values)
      mean_k += steps(x) / static_cast<double>(values.size()),
          mean_x += x / static_cast<double>(values.size());
    for (const double x : values) {
      kk += (steps(x) - mean_k) * (steps(x) - mean_k);
      kx += (steps(x) - mean_k) * (x - mean_x);
    }
  }
  // Each series has a phase that was fitted to it.
  const double length =
      (agreed - static_cast<double>(series.size())) / (count - static_cast<double>(series.size()));
  const bool many = length > kAgreed && count * length * length > kNoChance;
  const bool few = length > kAgreedOfFew && static_cast<double>(rows) > kRowsOfValue * count;
  if (!(many || few) || !(kk > 0)) return std::nullopt;
  return kx / kk;
}

// The largest step near a typical gap between values; 0: none.
double step_by_gap(const std::vector<Values>& series, size_t rows, double gap) {
  const Values apart = differences(series, 0, kReach * gap);
  double widest = 0;
  for (const Values& values : series) widest = std::max(widest, values.back() - values.front());
  const double grain = 1 / (8 * kReach * gap);
  double before = 0, here = agreement(apart, 1 / (kLargest * gap));
  for (double f = 1 / (kLargest * gap); f < 1 / (kSmallest * gap); f += grain) {
    const double next = agreement(apart, f + grain);
    const bool peak = here > kAgreedDifferences && here >= before && here >= next;
    before = std::exchange(here, next);
    if (!peak) continue;
    double at = nearer(apart, f, grain, 8);
    for (double reach = kReach * gap; reach < widest; reach *= kWiden) {
      const Values wide = differences(series, reach / kWiden, kWiden * reach);
      if (!wide.empty()) at = nearer(wide, at, 0.25 / reach, 20);
    }
    if (const auto step = step_at(series, rows, at)) return *step;
  }
  return 0;
}

}  // namespace

double step_of_values(const std::vector<std::vector<double>>& all) {
  std::vector<Values> series;
  Values gaps;
  size_t rows = 0;
  for (const Values& values : all) {
    rows += values.size();
    Values sorted = distinct(values);
    if (sorted.size() < 2) continue;
    for (size_t i = 1; i < sorted.size(); ++i) gaps.push_back(sorted[i] - sorted[i - 1]);
    series.push_back(std::move(sorted));
  }
  if (gaps.empty()) return 0;
  std::sort(gaps.begin(), gaps.end());
  // Values of one step that differ in their last bits make small gaps, a fast joint large ones.
  double step = 0;
  for (const double share : {0.0, 0.05, 0.25, 0.5, 0.75}) {
    const double gap = gaps[static_cast<size_t>(share * static_cast<double>(gaps.size() - 1))];
    step = std::max(step, step_by_gap(series, rows, gap));
  }
  return step;
}

}  // namespace seam::measurement
