#include "measurement/kinds/photometry/stack/stated_light.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>

#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/regression.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Of all levels together. Tried on 60 made series at each of 6 to 50 levels, with lamps steady to
// 0.01 to 0.1 %: with responses that are powers, cubics, lifted by glare or bent no level was
// called wrong. Of levels that were off by 5 % one was found in all series of 8 levels or more, two
// in two thirds of those of 8 and nearly all of 12 or more, three in most of 12 or more. A response
// that bends by a sixth, or in a wave, may look like a wrong level.
constexpr double kAlarm = 0.005;
// What is less is no slip but a lamp that is not quite steady.
constexpr double kLeastShare = 0.005;
// And what moves a value by less than this share of its noise does not matter.
constexpr double kLeastOfNoise = 0.1;
// Clipped levels say nothing of their light.
constexpr double kClipped = 0.005;
constexpr size_t kLeastLevels = 6;
// So many levels together are looked for one by one of all choices; more, by adding the next.
constexpr size_t kMostTogether = 3, kMostChoices = 5000;
// A level that is this much brighter than one that is said to have more light needs no curve; less
// than the other is a lamp's scatter. Logarithms.
constexpr double kLeastFall = 0.2, kScatter = 0.02;
// How well a light is known that lies between those of two levels.
constexpr double kBetweenTwo = 0.05;

struct LitLevel {
  size_t level;
  double x;      // Light over the most.
  double log_q;  // Logarithm of DN above dark over light.
  double noise;  // Of a value, relative to the DN above dark.
};

using Levels = std::vector<const PhotometryLevel*>;

// Mean against exposure: a line where there are several exposures.
std::optional<std::pair<double, double>> dark_line(const Levels& levels) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const PhotometryLevel* level : levels) {
    const double t = level->exposure_s;
    n += 1, x += t, y += level->whole.mean, xx += t * t, xy += t * level->whole.mean;
  }
  if (n == 0) return std::nullopt;
  const double spread = xx - x * x / n;
  const double slope = spread > 1e-12 * xx ? (xy - x * y / n) / spread : 0;
  return std::pair{(y - slope * x) / n, slope};
}

// Of the dark frames.
std::optional<std::pair<double, double>> dark_line(const PhotometryData& data) {
  Levels dark;
  for (const PhotometryLevel& level : data.levels)
    if (level.illumination == 0 && level.gain == data.levels[0].gain) dark.push_back(&level);
  return dark_line(dark);
}

std::vector<LitLevel> lit_levels(const PhotometryData& data) {
  std::vector<LitLevel> lit;
  const auto dark = dark_line(data);
  if (!dark) return lit;
  double most = 0;
  for (const PhotometryLevel& level : data.levels)
    if (level.illumination > 0) most = std::max(most, level.light());
  for (size_t l = 0; l < data.levels.size(); ++l) {
    const PhotometryLevel& level = data.levels[l];
    if (!(level.light() > 0) || level.gain != data.levels[0].gain) continue;
    const double above = level.whole.mean - dark->first - dark->second * level.exposure_s;
    if (level.whole.at_top > kClipped || !(above > 0)) continue;
    const double x = level.light() / most;
    lit.push_back({l, x, maths::log(above / x),
                   std::sqrt(std::max(level.whole.temporal_variance, 1.0 / 12)) / above});
  }
  return lit;
}

// The more levels, the more curves are allowed.
VectorXd basis_at(double x, Eigen::Index levels) {
  const double log_x = maths::log(x);
  const Eigen::Index count = levels < 7 ? 3 : levels < 10 ? 4 : levels < 14 ? 6 : 7;
  VectorXd all(7);
  all << 1, x, x * x, log_x, x * x * x, log_x * log_x, 1 / x;
  return all.head(count);
}

// How far a level is from the curve of the others.
struct Departure {
  double log_ratio = 0, sigma = 0, p_value = 1;
};

// From the curve of the levels that are not left out.
Departure departure_of(const std::vector<LitLevel>& lit, const std::vector<size_t>& left_out,
                       size_t which) {
  std::vector<size_t> rest;
  for (size_t i = 0; i < lit.size(); ++i) {
    if (i != which && std::find(left_out.begin(), left_out.end(), i) == left_out.end())
      rest.push_back(i);
  }
  const auto others = static_cast<Eigen::Index>(rest.size());
  const VectorXd here = basis_at(lit[which].x, others);
  MatrixXd basis(others, here.size());
  VectorXd q(others);
  for (Eigen::Index row = 0; row < others; ++row) {
    const LitLevel& level = lit[rest[static_cast<size_t>(row)]];
    basis.row(row) = basis_at(level.x, others).transpose();
    q[row] = level.log_q;
  }
  const VectorXd fit = solve_any_rank(basis, q);
  // The others' weights in what they predict here.
  const VectorXd weights = solve_any_rank(basis.transpose(), here);
  const double freedom = static_cast<double>(others - here.size());
  // A lamp is not known better than this, however well few levels happen to fit.
  constexpr double kSteady = 1e-4;
  const double scatter = std::max(std::sqrt((q - basis * fit).squaredNorm() / freedom), kSteady);
  Departure out{.log_ratio = lit[which].log_q - here.dot(fit)};
  out.sigma = scatter * std::sqrt(1 + weights.squaredNorm());
  const double t = out.log_ratio / out.sigma;
  out.p_value = f_tail(t * t, 1, freedom);
  return out;
}

// Levels that stand off the curve of all others, the least sure of them first told by `p_value`.
struct Choice {
  std::vector<size_t> levels;
  std::vector<Departure> found;
  double p_value = 1;
};

// Whether the two darkest or the two brightest are among them: there a curve that none of
// `basis_at` is looks the same.
bool hold_an_end(const std::vector<LitLevel>& lit, const std::vector<size_t>& levels) {
  size_t darker_two = 0, brighter_two = 0;
  for (const size_t level : levels) {
    const auto darker = std::count_if(lit.begin(), lit.end(),
                                      [&](const LitLevel& l) { return l.x < lit[level].x; });
    darker_two += darker < 2;
    brighter_two += static_cast<size_t>(darker) + 2 >= lit.size();
  }
  return darker_two > 1 || brighter_two > 1;
}

// `choices`: how many like this one are looked at.
Choice tried(const std::vector<LitLevel>& lit, const std::vector<size_t>& levels, double choices) {
  if (hold_an_end(lit, levels)) return {};
  Choice choice{.levels = levels, .found = {}, .p_value = 0};
  for (const size_t level : levels) {
    const Departure here = departure_of(lit, levels, level);
    const double size = std::abs(here.log_ratio);
    if (size < kLeastShare || size < kLeastOfNoise * lit[level].noise) return {};
    choice.found.push_back(here);
    choice.p_value = std::max(choice.p_value, here.p_value * choices);
    if (choice.p_value > kAlarm) return {};
  }
  return choice;
}

// The best of all choices of so many levels. Two that are off pull the curve of the others so far
// that neither stands off it alone.
Choice best_of(const std::vector<LitLevel>& lit, size_t count) {
  std::vector<size_t> levels(count);
  for (size_t i = 0; i < count; ++i) levels[i] = i;
  double choices = 1;
  for (size_t i = 0; i < count; ++i)
    choices *= static_cast<double>(lit.size() - i) / static_cast<double>(i + 1);
  if (choices > kMostChoices) return {};
  Choice best;
  for (;;) {
    Choice here = tried(lit, levels, choices);
    if (!here.levels.empty() && here.p_value < best.p_value) best = std::move(here);
    size_t last = count;
    while (last > 0 && levels[last - 1] == lit.size() - count + last - 1) --last;
    if (last == 0) return best;
    ++levels[last - 1];
    for (size_t i = last; i < count; ++i) levels[i] = levels[i - 1] + 1;
  }
}

// The same with one level more.
Choice with_another(const std::vector<LitLevel>& lit, const Choice& choice) {
  Choice best;
  for (size_t i = 0; i < lit.size(); ++i) {
    if (std::find(choice.levels.begin(), choice.levels.end(), i) != choice.levels.end()) continue;
    std::vector<size_t> levels = choice.levels;
    levels.push_back(i);
    Choice here = tried(lit, levels, static_cast<double>(lit.size()));
    if (!here.levels.empty() && here.p_value < best.p_value) best = std::move(here);
  }
  return best;
}

// Levels to leave out so that more light is never much darker: the fewest, by the longest chain of
// levels that rise.
std::vector<size_t> falls(const std::vector<LitLevel>& lit) {
  std::vector<size_t> order(lit.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return lit[a].x < lit[b].x; });
  const auto log_above = [&](size_t i) { return lit[i].log_q + maths::log(lit[i].x); };
  std::vector<size_t> length(lit.size(), 1), before(lit.size(), lit.size());
  for (size_t b = 0; b < order.size(); ++b) {
    for (size_t a = 0; a < b; ++a) {
      if (log_above(order[b]) < log_above(order[a]) - kScatter || length[a] < length[b]) continue;
      length[b] = length[a] + 1, before[b] = a;
    }
  }
  std::vector<char> rises(lit.size(), 0);
  auto at = static_cast<size_t>(std::max_element(length.begin(), length.end()) - length.begin());
  for (; at < lit.size(); at = before[at]) rises[order[at]] = 1;
  std::vector<size_t> out;
  for (size_t i = 0; i < lit.size(); ++i) {
    bool falls = false;
    for (size_t j = 0; j < lit.size() && !rises[i]; ++j) {
      const double rise = log_above(j) - log_above(i);
      falls =
          falls || (rises[j] && std::abs(rise) > kLeastFall && (rise > 0) != (lit[j].x > lit[i].x));
    }
    if (falls) out.push_back(i);
  }
  return out;
}

// The light of a level by its value, between those of the two nearest of `lit` (in logarithms).
WrongLight by_value(const std::vector<LitLevel>& lit, const LitLevel& level) {
  const auto log_above = [](const LitLevel& l) { return l.log_q + maths::log(l.x); };
  std::vector<LitLevel> near = lit;
  std::sort(near.begin(), near.end(), [&](const LitLevel& a, const LitLevel& b) {
    return std::abs(log_above(a) - log_above(level)) < std::abs(log_above(b) - log_above(level));
  });
  const double slope =
      (log_above(near[1]) - log_above(near[0])) / (maths::log(near[1].x) - maths::log(near[0].x));
  const double log_x =
      maths::log(near[0].x) + (log_above(level) - log_above(near[0])) / std::max(slope, 0.1);
  const double ratio = maths::exp(log_x - maths::log(level.x));
  return {level.level, ratio, kBetweenTwo * ratio};
}

}  // namespace

std::vector<WrongLight> wrong_lights(const PhotometryData& data) {
  std::vector<WrongLight> wrong;
  if (data.channels != 1) return wrong;
  std::vector<LitLevel> lit = lit_levels(data);
  const size_t most = lit.size() / 4;
  std::vector<LitLevel> fallen;
  const std::vector<size_t> falling = falls(lit);
  if (falling.size() <= most) {
    for (auto i = falling.rbegin(); i != falling.rend(); ++i) {
      fallen.push_back(lit[*i]);
      lit.erase(lit.begin() + static_cast<std::ptrdiff_t>(*i));
    }
  }
  const size_t left = lit.size() >= kLeastLevels ? most - fallen.size() : 0;
  Choice choice;
  for (size_t count = 1; count <= std::min(left, kMostTogether); ++count) {
    choice = best_of(lit, count);
    if (choice.p_value < kAlarm) break;
  }
  while (choice.p_value < kAlarm && lit.size() - choice.levels.size() >= kLeastLevels) {
    const Choice more = with_another(lit, choice);
    if (!(more.p_value < kAlarm)) break;
    choice = more;
    // Too many are off: the curve is another, not the light.
    if (choice.levels.size() > left) choice = {};
  }
  if (choice.p_value < kAlarm) {
    for (size_t i = 0; i < choice.levels.size(); ++i) {
      const double ratio = maths::exp(choice.found[i].log_ratio);
      wrong.push_back({lit[choice.levels[i]].level, ratio, ratio * choice.found[i].sigma});
    }
  }
  if (lit.size() >= 2) {
    for (const LitLevel& level : fallen) wrong.push_back(by_value(lit, level));
  }
  return wrong;
}

std::vector<OddFrame> odd_frames(const PhotometryData& data) {
  constexpr double kLeastRatio = 1.25, kLeastSigmas = 1;  // Sigmas of a single value.
  std::vector<OddFrame> odd;
  const auto dark = dark_line(data);
  for (const PhotometryLevel& level : data.levels) {
    if (level.illumination == 0 || level.frames.size() < 2) continue;
    const double black = dark ? dark->first + dark->second * level.exposure_s : 0;
    std::vector<double> above;
    for (const int frame : level.frames) {
      const auto& image = data.images[static_cast<size_t>(frame)];
      double sum = 0;
      for (const uint16_t value : image) sum += value;
      above.push_back(sum / static_cast<double>(image.size()) - black);
    }
    // Of a pair the second is as good as the first.
    const double middle = above.size() == 2 ? above[1] : median_of(above);
    const auto nearest = std::min_element(above.begin(), above.end(), [&](double a, double b) {
      return std::abs(a - middle) < std::abs(b - middle);
    });
    const double noise = std::sqrt(std::max(level.whole.temporal_variance, 1.0 / 12));
    for (size_t i = 0; i < above.size(); ++i) {
      if (std::abs(above[i] - middle) < kLeastSigmas * noise) continue;
      if (above[i] < kLeastRatio * middle && middle < kLeastRatio * above[i]) continue;
      odd.push_back(
          {static_cast<size_t>(level.frames[i]),
           static_cast<size_t>(level.frames[static_cast<size_t>(nearest - above.begin())]),
           above[i], middle});
    }
  }
  return odd;
}

std::vector<BrightDark> bright_darks(const PhotometryData& data) {
  constexpr double kFarAbove = 10, kLikeOthers = 1;  // In noises of a single value.
  std::vector<BrightDark> bright;
  if (data.channels != 1) return bright;
  for (size_t l = 0; l < data.levels.size(); ++l) {
    const PhotometryLevel& level = data.levels[l];
    if (level.light() != 0 || level.gain != data.levels[0].gain) continue;
    Levels others;
    double variance = 1.0 / 12;
    for (const PhotometryLevel& other : data.levels) {
      if (&other == &level || other.illumination != 0 || other.gain != level.gain) continue;
      others.push_back(&other);
      variance = std::max(variance, other.whole.temporal_variance);
    }
    // Two that differ do not say which of them is dark.
    if (others.size() < (level.illumination == 0 ? 2 : 1)) continue;
    const auto [dark, slope] = *dark_line(others);
    const auto above = [&, dark = dark, slope = slope](const PhotometryLevel& at) {
      return (at.whole.mean - dark - slope * at.exposure_s) / std::sqrt(variance);
    };
    const bool agree = std::all_of(others.begin(), others.end(), [&](const auto* other) {
      return std::abs(above(*other)) < kLikeOthers;
    });
    if (agree && above(level) > kFarAbove)
      bright.push_back({l, above(level) * std::sqrt(variance)});
  }
  return bright;
}

std::optional<FallingLight> falling_lights(const PhotometryData& data) {
  if (data.channels != 1) return std::nullopt;
  const std::vector<LitLevel> lit = lit_levels(data);
  if (lit.size() < 4 || falls(lit).size() <= lit.size() / 4) return std::nullopt;
  const auto above = [](const LitLevel& l) { return maths::exp(l.log_q) * l.x; };
  const LitLevel *low = nullptr, *high = nullptr;
  for (const LitLevel& a : lit) {
    for (const LitLevel& b : lit) {
      if (a.x <= b.x || above(a) >= above(b)) continue;
      if (low == nullptr || above(a) * above(*high) < above(b) * above(*low)) low = &a, high = &b;
    }
  }
  if (low == nullptr) return std::nullopt;
  return FallingLight{low->level, high->level, above(*low), above(*high)};
}

}  // namespace seam::measurement
