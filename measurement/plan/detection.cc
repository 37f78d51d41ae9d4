#include "measurement/plan/detection.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/judge/judge.h"
#include "measurement/judge/material.h"
#include "measurement/numerics/curvature.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/regression.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kFoundFor = 0.95;
constexpr double kUnknown = std::numeric_limits<double>::infinity();
// Chances are good to half a per cent at kFoundFor.
constexpr uint64_t kDraws = 2500;
// A combination of columns with less of the information that each has alone is not determined.
constexpr double kFloor = 1e-13;
constexpr RandomStream kNoise{.seed = 11, .stream = 49};

MatrixXd inverse_information(const MatrixXd& information) {
  return covariance_of(information, kFloor).matrix;
}

// From scores to estimates: of the base's columns alone, padded by zeros, or of all.
MatrixXd estimator(const MatrixXd& information, size_t columns) {
  const auto n = static_cast<Index>(columns);
  MatrixXd out = MatrixXd::Zero(information.rows(), information.cols());
  if (n > 0) out.topLeftCorner(n, n) = inverse_information(information.topLeftCorner(n, n));
  return out;
}

// R with R R' = m.
MatrixXd root_of(const MatrixXd& m) {
  const SymmetricEigen eigen = symmetric_eigen(m);
  return eigen.vectors * eigen.values.cwiseMax(0).cwiseSqrt().asDiagonal();
}

VectorXd normals(uint64_t draw, uint64_t part, Index count) {
  const RandomStream stream = kNoise.child(draw).child(part);
  VectorXd values(count);
  for (Index i = 0; i < count; ++i) values[i] = normal(stream, static_cast<uint64_t>(i));
  return values;
}

void add(const PartInformation& part, PartInformation& sum) {
  if (sum.information.size() == 0) {
    sum = part;
  } else {
    sum.information += part.information, sum.score += part.score;
  }
}

}  // namespace

PartInformation EffectLook::whole() const {
  PartInformation sum = trained;
  for (const PartInformation& part : held) add(part, sum);
  return sum;
}

PartInformation EffectLook::fitted() const {
  return in_turn() ? whole() : trained;
}

Detection::Estimators Detection::estimators_of(const MatrixXd& information) const {
  return {estimator(information, look_.columns()), estimator(information, look_.base)};
}

Detection::Detection(const EffectLook& look)
    : look_(look), fitted_(look.fitted()), of_fitted_(estimators_of(fitted_.information)) {
  for (const PartInformation& part : look.held) {
    roots_.push_back(root_of(part.information));
    if (look.in_turn()) of_rest_.push_back(estimators_of(fitted_.information - part.information));
  }
  if (!look.in_turn()) roots_.push_back(root_of(look.trained.information));
  for (uint64_t number = 0; number < kDraws; ++number) draws_.push_back(drawn(number));
}

namespace {

// A vector that grows with the scale: `slope` of it, and noise.
struct Line {
  VectorXd slope, noise;
};

Line operator*(const MatrixXd& way, const Line& from) {
  return {way * from.slope, way * from.noise};
}

Line operator-(const Line& a, const Line& b) {
  return {a.slope - b.slope, a.noise - b.noise};
}

// The log-likelihood that a part of this information and these scores gains by a step `to`.
struct GainOf {
  const MatrixXd& information;
  const Line& score;
  const Line& to;
  double square() const {
    return to.slope.dot(score.slope) - 0.5 * to.slope.dot(information * to.slope);
  }
  double linear() const {
    return to.slope.dot(score.noise) + to.noise.dot(score.slope) -
           to.slope.dot(information * to.noise);
  }
  double constant() const {
    return to.noise.dot(score.noise) - 0.5 * to.noise.dot(information * to.noise);
  }
};

}  // namespace

Detection::Draw Detection::drawn(uint64_t number) const {
  const auto columns = static_cast<Index>(look_.columns());
  const auto score_of = [&](const PartInformation& part, size_t which) {
    return Line{part.score, roots_[which] * normals(number, which, columns)};
  };
  std::vector<Line> scores;
  Line fitted{VectorXd::Zero(columns), VectorXd::Zero(columns)};
  for (size_t g = 0; g < look_.held.size(); ++g) {
    scores.push_back(score_of(look_.held[g], g));
    fitted.slope += scores[g].slope, fitted.noise += scores[g].noise;
  }
  if (!look_.in_turn()) fitted = score_of(look_.trained, look_.held.size());
  const auto gain = [](const MatrixXd& information, const Line& score, const Line& with,
                       const Line& without) {
    const GainOf more{information, score, with}, less{information, score, without};
    return Quadratic{more.square() - less.square(), more.linear() - less.linear(),
                     more.constant() - less.constant()};
  };
  const Line with = of_fitted_.with * fitted, without = of_fitted_.without * fitted;
  Draw draw{.trained = gain(fitted_.information, fitted, with, without)};
  for (size_t g = 0; g < look_.held.size(); ++g) {
    const MatrixXd& own = look_.held[g].information;
    if (!look_.in_turn()) {
      draw.held.push_back(gain(own, scores[g], with, without));
      continue;
    }
    const Line rest = fitted - scores[g];
    draw.held.push_back(gain(own, scores[g], of_rest_[g].with * rest, of_rest_[g].without * rest));
  }
  const Line change = with - without;
  for (const MatrixXd& movement : look_.movement)
    draw.moved2.push_back({change.slope.dot(movement * change.slope),
                           2 * change.slope.dot(movement * change.noise),
                           change.noise.dot(movement * change.noise)});
  if (look_.residuals > 0) {
    // What is left scatters about the noise; where it is more, a likelihood ratio is worth less.
    const double scatter = normal(kNoise.child(number).child("left"), 0);
    const double left2 = std::max(0.0, 1 + std::sqrt(2 / look_.residuals) * scatter);
    const double excess = std::sqrt(left2) * kMisfit / limit_at_noise(look_.residuals);
    draw.misfit = std::max(1.0, excess * excess);
  }
  return draw;
}

bool Detection::is_found(const Draw& draw, double scale) const {
  double held = 0;
  for (const Quadratic& gain : draw.held) held += gain.at(scale);
  // Where each group is left out in turn, all are fitted together, too.
  const double total = look_.together * (draw.trained.at(scale) + (look_.in_turn() ? 0 : held));
  if (!(total / draw.misfit > look_.price) || !(held > kUnluckyLoss)) return false;
  double moved2 = 0;
  for (const Quadratic& channel : draw.moved2) moved2 = std::max(moved2, channel.at(scale));
  return moved2 >= look_.material * look_.material;
}

double Detection::chance(double scale) const {
  const auto found = std::count_if(draws_.begin(), draws_.end(),
                                   [&](const Draw& draw) { return is_found(draw, scale); });
  return static_cast<double>(found) / static_cast<double>(draws_.size());
}

double Detection::scale_found(double most) const {
  double high = std::min(1.0, most);
  while (chance(high) < kFoundFor) {
    if (high >= most) return std::numeric_limits<double>::infinity();
    high = std::min(2 * high, most);
  }
  double low = 0;
  constexpr double kGoodTo = 1e-3;
  while (high - low > kGoodTo * high) {
    const double middle = 0.5 * (low + high);
    (chance(middle) < kFoundFor ? low : high) = middle;
  }
  return high;
}

std::vector<double> standard_errors(const EffectLook& look) {
  const Covariance covariance = covariance_of(look.fitted().information, kFloor);
  std::vector<double> errors;
  for (Index i = 0; i < covariance.matrix.rows(); ++i)
    errors.push_back(covariance.known[static_cast<size_t>(i)] ? std::sqrt(covariance.matrix(i, i))
                                                              : kUnknown);
  return errors;
}

double gain_of(const PartInformation& whole, size_t base) {
  const auto of = [&](size_t columns) {
    return 0.5 * whole.score.dot(estimator(whole.information, columns) * whole.score);
  };
  return of(static_cast<size_t>(whole.score.size())) - of(base);
}

}  // namespace seam::measurement
