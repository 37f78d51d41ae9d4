#include "measurement/kinds/photometry/stack/stated_light.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>

#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/regression.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Of all levels together. Tried on 40 made series at each of 6 to 50 levels: with responses that
// are powers, cubics or lifted by glare no level was called wrong, and one that was off by 5 % was
// found in nearly all series of 8 levels or more. A response that bends by a sixth, or in a wave,
// may look like a wrong level.
constexpr double kAlarm = 0.005;
// What is less is no slip but a lamp that is not quite steady.
constexpr double kLeastShare = 0.005;
// And what moves a value by less than this share of its noise does not matter.
constexpr double kLeastOfNoise = 0.1;
// Clipped levels say nothing of their light.
constexpr double kClipped = 0.005;
constexpr size_t kLeastLevels = 6;

struct LitLevel {
  size_t level;
  double x;      // Light over the most.
  double log_q;  // Logarithm of DN above dark over light.
  double noise;  // Of a value, relative to the DN above dark.
};

// Mean of dark frames against exposure: a line where there are several exposures.
std::optional<std::pair<double, double>> dark_line(const PhotometryData& data) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const PhotometryLevel& level : data.levels) {
    if (level.illumination != 0 || level.gain != data.levels[0].gain) continue;
    const double t = level.exposure_s;
    n += 1, x += t, y += level.whole.mean, xx += t * t, xy += t * level.whole.mean;
  }
  if (n == 0) return std::nullopt;
  const double spread = xx - x * x / n;
  const double slope = spread > 1e-12 * xx ? (xy - x * y / n) / spread : 0;
  return std::pair{(y - slope * x) / n, slope};
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
    if (!(level.illumination > 0) || level.gain != data.levels[0].gain) continue;
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

Departure departure_of(const std::vector<LitLevel>& lit, size_t which) {
  const auto others = static_cast<Eigen::Index>(lit.size()) - 1;
  const VectorXd here = basis_at(lit[which].x, others);
  MatrixXd basis(others, here.size());
  VectorXd q(others);
  Eigen::Index at = 0;
  for (size_t i = 0; i < lit.size(); ++i) {
    if (i == which) continue;
    basis.row(at) = basis_at(lit[i].x, others).transpose();
    q[at++] = lit[i].log_q;
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
  out.p_value = f_tail(t * t, 1, freedom) * static_cast<double>(lit.size());
  return out;
}

}  // namespace

std::vector<WrongLight> wrong_lights(const PhotometryData& data) {
  std::vector<WrongLight> wrong;
  if (data.channels != 1) return wrong;
  std::vector<LitLevel> lit = lit_levels(data);
  const size_t most = lit.size() / 4;
  while (lit.size() >= kLeastLevels && wrong.size() < most) {
    size_t worst = lit.size();
    Departure found;
    for (size_t i = 0; i < lit.size(); ++i) {
      const Departure here = departure_of(lit, i);
      const double size = std::abs(here.log_ratio);
      if (here.p_value > kAlarm || size < kLeastShare || size < kLeastOfNoise * lit[i].noise)
        continue;
      if (worst == lit.size() || here.p_value < found.p_value) worst = i, found = here;
    }
    if (worst == lit.size()) break;
    const double ratio = maths::exp(found.log_ratio);
    wrong.push_back({lit[worst].level, ratio, ratio * found.sigma});
    lit.erase(lit.begin() + static_cast<long>(worst));
  }
  // Where the last look still finds one, too many are off: the curve is another, not the light.
  if (!wrong.empty() && wrong.size() == most && lit.size() >= kLeastLevels) {
    for (size_t i = 0; i < lit.size(); ++i)
      if (departure_of(lit, i).p_value < kAlarm &&
          std::abs(departure_of(lit, i).log_ratio) > kLeastShare)
        return {};
  }
  return wrong;
}

}  // namespace seam::measurement
