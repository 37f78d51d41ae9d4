#include "measurement/noise/driven_errors.h"

#include <Eigen/Core>
#include <cmath>
#include <stdexcept>

#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

// Small enough to stand without memory of its own: a model has few effects that wander.
constexpr int kMostWanders = 6;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 2 + kMostWanders, 1>;
using Square =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 2 + kMostWanders, 2 + kMostWanders>;

// Kalman's filter of the state and the wanders, and their covariance without any measurement.
class Filter {
 public:
  Filter(const DrivenStart& start, double draw_sigma, const std::vector<effects::Wander>& wanders)
      : variance_(draw_sigma * draw_sigma),
        wanders_(wanders),
        size_(2 + static_cast<Eigen::Index>(wanders.size())),
        mean_(Vector::Zero(size_)),
        known_(Square::Zero(size_, size_)),
        seen_(Vector::Ones(size_)) {
    seen_[1] = 0;
    for (size_t i = 0; i < wanders_.size(); ++i) {
      const auto at = 2 + static_cast<Eigen::Index>(i);
      known_(at, at) = wanders_[i].sigma * wanders_[i].sigma;
    }
    alone_ = known_;
    mean_[0] = start.q, known_(0, 0) = start.variance;
  }

  void move(const DrivenStep& step, double dt_s) {
    Square next = Square::Zero(size_, size_);
    next.topLeftCorner<2, 2>() << step.q_of_q, step.q_of_w, step.w_of_q, step.w_of_w;
    Square added = Square::Zero(size_, size_);
    const Eigen::Vector2d draw(step.q_of_draw, step.w_of_draw);
    const Eigen::Vector2d square(step.q_of_square, step.w_of_square);
    // The square of a normal draw has a mean, too, and is uncorrelated with the draw.
    added.topLeftCorner<2, 2>() = variance_ * draw * draw.transpose() +
                                  2 * variance_ * variance_ * square * square.transpose();
    for (size_t i = 0; i < wanders_.size(); ++i) {
      const auto at = 2 + static_cast<Eigen::Index>(i);
      const double kept = wanders_[i].tau_s > 0 ? maths::exp(-dt_s / wanders_[i].tau_s) : 0;
      next(at, at) = kept;
      added(at, at) = (1 - kept * kept) * wanders_[i].sigma * wanders_[i].sigma;
    }
    mean_ = next * mean_;
    mean_.head<2>() += variance_ * square;
    known_ = next * known_ * next.transpose() + added;
    alone_ = next * alone_ * next.transpose() + added;
  }

  // Of the error itself, without its own noise.
  double variance_alone() const { return seen_.dot(alone_ * seen_); }
  double variance() const { return seen_.dot(known_ * seen_); }
  double expected() const { return seen_.dot(mean_); }

  void learn(double residual, double whole_variance) {
    const Vector gain = known_ * seen_ / whole_variance;
    mean_ += gain * (residual - expected());
    known_ -= gain * (seen_.transpose() * known_).eval();
    known_ = 0.5 * (known_ + known_.transpose()).eval();
  }

 private:
  double variance_;
  const std::vector<effects::Wander>& wanders_;
  Eigen::Index size_;
  Vector mean_;
  Square known_, alone_;
  Vector seen_;  // What a residual has of each.
};

}  // namespace

void whiten_driven(const Facts& facts, const std::vector<size_t>& scalars,
                   const std::vector<double>& time_s, const std::vector<DrivenStep>& steps,
                   const DrivenStart& start, double draw_sigma,
                   const std::vector<effects::Wander>& wanders, Evaluation& evaluation) {
  if (wanders.size() > kMostWanders)
    throw std::length_error("more errors that wander than are whitened beside a driven one");
  Filter filter(start, draw_sigma, wanders);
  for (size_t k = 0; k < scalars.size(); ++k) {
    if (k > 0) filter.move(steps[k - 1], time_s[k] - time_s[k - 1]);
    const size_t i = scalars[k];
    const double own = evaluation.sigma[i] * evaluation.sigma[i];
    if (evaluation.used[i]) {
      const double whole = own + filter.variance();
      evaluation.whitened[i] = (evaluation.residual[i] - filter.expected()) / std::sqrt(whole);
      evaluation.log_det[facts.group_of(i)] += std::log(whole / own);
      filter.learn(evaluation.residual[i], whole);
    }
    evaluation.sigma[i] = std::sqrt(own + filter.variance_alone());
  }
}

}  // namespace seam::measurement
