#include "measurement/kinds/points/target/spacing.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/robust.h"

namespace seam::measurement {
namespace {

constexpr size_t kFewest = 20;
constexpr size_t kMost = 600;  // Observations that are looked at, evenly among all.
constexpr double kGain = 3;

// The plan shifted by the first three and drawn out by the exponential of the fourth.
using Change = Eigen::Vector4d;

class Spacing {
 public:
  Spacing(const std::vector<Vec3>& places, const std::vector<ImagePlace>& seen,
          const std::function<std::optional<ImagePlace>(size_t, const Vec3&)>& image)
      : places_(places), seen_(seen), image_(image) {
    const size_t stride = (places.size() + kMost - 1) / kMost;
    for (size_t i = 0; i < places.size(); i += stride) rows_.push_back(i);
    for (const Vec3& p : places) middle_ += p;
    middle_ /= static_cast<double>(places.size());
    double squares = 0;
    for (const Vec3& p : places) squares += glm::dot(p - middle_, p - middle_);
    extent_m_ = std::sqrt(squares / static_cast<double>(places.size()));
  }

  double extent_m() const { return extent_m_; }

  struct Found {
    Change change = Change::Zero();
    double rms_px = std::numeric_limits<double>::infinity();
  };

  // Gauss and Newton over the first `count` of the four, damped by halving.
  Found best_from(Change start, Eigen::Index count) const {
    constexpr int kSteps = 20;
    Found best{start, rms_of(residuals(start))};
    for (int step = 0; step < kSteps && std::isfinite(best.rms_px); ++step) {
      const Eigen::VectorXd here = residuals(best.change);
      Eigen::MatrixXd slopes(here.size(), count);
      for (Eigen::Index k = 0; k < count; ++k) {
        Change beside = best.change;
        const double by = k < 3 ? 1e-4 * extent_m_ : 1e-4;
        beside[k] += by;
        slopes.col(k) = (residuals(beside) - here) / by;
      }
      if (!slopes.allFinite()) return best;
      const Eigen::VectorXd way = solve_any_rank(slopes, -here);
      if (!way.allFinite()) return best;
      double share = 1;
      Found next;
      for (int halving = 0; halving < 8; ++halving, share /= 2) {
        next.change = best.change;
        next.change.head(count) += share * way;
        next.rms_px = rms_of(residuals(next.change));
        if (next.rms_px < best.rms_px) break;
      }
      if (!(next.rms_px < best.rms_px)) return best;
      const bool done = next.rms_px > (1 - 1e-6) * best.rms_px;
      best = next;
      if (done) return best;
    }
    return best;
  }

  // What stays where pictures are magnified and shifted in place of the target: the part of a wrong
  // focal length and centre.
  double rms_of_magnified() const {
    Eigen::MatrixXd a(2 * static_cast<Eigen::Index>(rows_.size()), 3);
    Eigen::VectorXd b(a.rows());
    for (size_t i = 0; i < rows_.size(); ++i) {
      const auto place = image_(rows_[i], places_[rows_[i]]);
      if (!place) return std::numeric_limits<double>::infinity();
      const auto row = static_cast<Eigen::Index>(2 * i);
      a.row(row) << (*place)[0], 1, 0;
      a.row(row + 1) << (*place)[1], 0, 1;
      b[row] = seen_[rows_[i]][0], b[row + 1] = seen_[rows_[i]][1];
    }
    return rms_of(a * solve_any_rank(a, b) - b);
  }

 private:
  static double rms_of(const Eigen::VectorXd& residuals) {
    if (!residuals.allFinite()) return std::numeric_limits<double>::infinity();
    return std::sqrt(residuals.squaredNorm() / static_cast<double>(residuals.size()));
  }

  Eigen::VectorXd residuals(const Change& change) const {
    const Vec3 shift(change[0], change[1], change[2]);
    const double factor = std::exp(change[3]);
    Eigen::VectorXd values(2 * static_cast<Eigen::Index>(rows_.size()));
    for (size_t i = 0; i < rows_.size(); ++i) {
      const size_t row = rows_[i];
      const auto place = image_(row, middle_ + shift + factor * (places_[row] - middle_));
      const auto at = static_cast<Eigen::Index>(2 * i);
      for (Eigen::Index c = 0; c < 2; ++c)
        values[at + c] = place
                             ? (*place)[static_cast<size_t>(c)] - seen_[row][static_cast<size_t>(c)]
                             : std::numeric_limits<double>::quiet_NaN();
    }
    return values;
  }

  const std::vector<Vec3>& places_;
  const std::vector<ImagePlace>& seen_;
  const std::function<std::optional<ImagePlace>(size_t, const Vec3&)>& image_;
  std::vector<size_t> rows_;
  Vec3 middle_{0.0};
  double extent_m_ = 0;
};

// The usual distance to the nearest other point of a plan.
double neighbour_distance_m(const std::vector<Vec3>& places) {
  constexpr size_t kMostPoints = 400;
  const auto before = [](const Vec3& a, const Vec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  std::vector<Vec3> points = places;
  std::sort(points.begin(), points.end(), before);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  std::vector<double> nearest;
  for (size_t i = 0; i < std::min(points.size(), kMostPoints); ++i) {
    double least = std::numeric_limits<double>::infinity();
    for (size_t k = 0; k < points.size(); ++k) {
      if (k != i) least = std::min(least, glm::length(points[k] - points[i]));
    }
    nearest.push_back(least);
  }
  return nearest.empty() ? 0 : median_of(nearest);
}

}  // namespace

std::optional<WrongSpacing> wrong_spacing(
    const std::vector<Vec3>& places, const std::vector<ImagePlace>& seen,
    const std::function<std::optional<ImagePlace>(size_t, const Vec3&)>& image) {
  if (places.size() < kFewest) return std::nullopt;
  const Spacing spacing(places, seen, image);
  if (!(spacing.extent_m() > 0)) return std::nullopt;
  const auto shifted = spacing.best_from(Change::Zero(), 3);
  Spacing::Found drawn;
  for (const double factor : {1.0, 0.5, 2.0}) {
    Change start = shifted.change;
    start[3] = std::log(factor);
    const auto found = spacing.best_from(start, 4);
    if (found.rms_px < drawn.rms_px) drawn = found;
  }
  WrongSpacing told{.factor = std::exp(drawn.change[3]),
                    .neighbour_m = 0,
                    .before_px = shifted.rms_px,
                    .after_px = drawn.rms_px};
  const bool explains = std::isfinite(drawn.rms_px) && kGain * drawn.rms_px < shifted.rms_px &&
                        kGain * drawn.rms_px < spacing.rms_of_magnified();
  constexpr double kLeast = 0.01, kMostFactor = 5;
  const bool plausible = std::abs(told.factor - 1) > kLeast && told.factor < kMostFactor &&
                         told.factor > 1 / kMostFactor;
  if (!explains || !plausible) return std::nullopt;
  told.neighbour_m = neighbour_distance_m(places);
  return told;
}

}  // namespace seam::measurement
