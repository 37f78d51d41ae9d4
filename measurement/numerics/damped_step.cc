#include "measurement/numerics/damped_step.h"

#include <algorithm>
#include <cmath>

#include "measurement/numerics/linear_algebra.h"
#include "sim_core/system/work_tally.h"

namespace seam::measurement {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Parabola parabola_of(const MatrixXd& jacobian, const Eigen::Ref<const VectorXd>& residuals) {
  return {jacobian.transpose() * jacobian, jacobian.transpose() * residuals, {}, {}};
}

VectorXd damped_step(const Parabola& here, double damping) {
  std::vector<Index> moving;
  for (Index i = 0; i < here.gradient.size(); ++i) {
    const bool held = !here.held.empty() && here.held[static_cast<size_t>(i)];
    if (!held && here.curvature(i, i) > 0) moving.push_back(i);
  }
  VectorXd by = VectorXd::Zero(here.gradient.size());
  if (moving.empty()) return by;
  // Scaled to a unit diagonal, so that units do not matter.
  const VectorXd scale = here.curvature.diagonal()(moving).cwiseSqrt().cwiseInverse();
  MatrixXd unit = scale.asDiagonal() * here.curvature(moving, moving) * scale.asDiagonal();
  unit.diagonal().array() += damping;
  if (here.untold.size() > 0)
    unit.diagonal() += scale.cwiseAbs2().cwiseProduct(VectorXd(here.untold(moving)));
  const VectorXd right = -scale.cwiseProduct(VectorXd(here.gradient(moving)));
  VectorXd step;
  // Where second derivatives are of no minimum, each coordinate goes for itself.
  if (!solve_positive(unit, right, step)) step = right.cwiseQuotient(unit.diagonal());
  by(moving) = scale.cwiseProduct(step);
  return by;
}

DampedSteps::Outcome DampedSteps::take(const Parabola& here, const Worth& worth,
                                       const std::function<bool(const VectorXd& by)>& move) {
  count_fit_step();
  for (int attempt = 0; attempt < rule_.attempts; ++attempt) {
    const VectorXd by = damped_step(here, damping_);
    promised_ = -0.5 * by.dot(here.gradient);
    if (!std::isfinite(promised_)) return Outcome::refused;
    const double least = attempt == 0 ? worth.promise : std::max(worth.promise, worth.again);
    if (promised_ < least || by.isZero(0)) return Outcome::worthless;
    if (move(by)) {
      damping_ = std::max(damping_ * rule_.shrink, rule_.least);
      return Outcome::taken;
    }
    damping_ = std::max(damping_ * rule_.grow, rule_.firm);
  }
  return Outcome::refused;
}

DescentEnd descend(const Descent& fit, const DampingRule& rule, int most) {
  using Reason = DescentEnd::Reason;
  DampedSteps steps(rule);
  for (int i = 0; i < most; ++i) {
    const Parabola here = fit.look();
    const Worth worth = fit.worth();
    const double before = fit.height();
    switch (steps.take(here, worth, fit.move)) {
      case DampedSteps::Outcome::worthless:
        return {Reason::nothing_promised, steps.promised()};
      case DampedSteps::Outcome::refused:
        return {Reason::refused, steps.promised()};
      case DampedSteps::Outcome::taken:
        break;
    }
    if (before - fit.height() < worth.gain) return {Reason::nothing_gained, steps.promised()};
  }
  return {Reason::steps_spent, steps.promised()};
}

}  // namespace seam::measurement
