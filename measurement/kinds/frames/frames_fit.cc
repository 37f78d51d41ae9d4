// Fits of whole images: renderings are dear, so parameters of the mean take few linear steps, and
// parameters of the spread, which need none, are sought on the likelihood in between.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/fitting/parameter_space.h"
#include "measurement/kinds/frames/frames.h"
#include "measurement/numerics/damped_step.h"
#include "measurement/numerics/maximise.h"
#include "measurement/problem/fit_key.h"

namespace seam::measurement {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Two of at least four frames, far from each other and from both ends.
std::vector<size_t> two_of(const std::vector<size_t>& frames) {
  return {frames[frames.size() / 4], frames[3 * frames.size() / 4]};
}

class FrameFit {
 public:
  FrameFit(const FramesProblem& problem, const Model& start, const std::vector<Unknown>& unknowns,
           std::vector<size_t> frames)
      : problem_(problem),
        frames_(std::move(frames)),
        space_(start, unknowns),
        model_(start),
        here_(problem.residuals_of(start, frames_)) {
    likelihood_ = problem.log_likelihood(here_);
    for (size_t i = 0; i < unknowns.size(); ++i) (space_[i].spread ? spread_ : mean_).push_back(i);
  }

  // By more than the noise again.
  bool is_far() const { return here_.errors && mean_square(here_) > 2; }

  // Steps alone, as far as they lead: where the fit to all frames may begin.
  Model end_of_steps() {
    for (int round = 0; round < 8 && here_.errors && step();) ++round;
    return model_;
  }

  Fit run() {
    bool converged = mean_.empty();
    for (int round = 0; round < 8 && !converged && here_.errors; ++round) {
      if (round == 1) fit_spread();
      converged = !step();
    }
    if (here_.errors) fit_spread();
    const VectorXd place = space_.place(model_);
    Fit fit = space_.fit_at(model_, place, likelihood_, converged);
    if (information_.size() > 0) space_.state(covariance_of(information_, 1e-10), 1, place, fit);
    for (size_t k = 0; k < searched_.sigma.size(); ++k) {
      fit.sigma[spread_[k]] = searched_.sigma[k];
      for (size_t j = 0; j < spread_.size(); ++j) {
        fit.covariance[spread_[k] * space_.size() + spread_[j]] =
            searched_.covariance[k * spread_.size() + j];
      }
    }
    return fit;
  }

 private:
  double likelihood(const Model& model, const std::vector<size_t>& frames) const {
    return problem_.log_likelihood(problem_.residuals_of(model, frames));
  }

  // Half of what chi-square is above the number of values.
  double excess() const {
    double sum = 0;
    for (size_t i = 0; i < here_.used.size(); ++i) {
      if (here_.used[i]) sum += here_.whitened[i] * here_.whitened[i] - 1;
    }
    return std::max(0.0, 0.5 * sum);
  }

  Parabola look() {
    std::vector<Unknown> chosen;
    for (const size_t i : mean_) chosen.push_back(space_[i].unknown);
    const auto columns = problem_.slopes_of(model_, chosen, here_);
    const Eigen::Map<const VectorXd> z(here_.whitened.data(),
                                       static_cast<Eigen::Index>(here_.whitened.size()));
    MatrixXd jacobian = MatrixXd::Zero(z.size(), static_cast<Eigen::Index>(space_.size()));
    for (size_t k = 0; k < columns.size(); ++k) {
      jacobian.col(static_cast<Eigen::Index>(mean_[k])) =
          Eigen::Map<const VectorXd>(columns[k].data(), z.size());
    }
    Parabola out = parabola_of(jacobian, z);
    information_ = out.curvature;
    out.held = space_.box().held(space_.place(model_), out.gradient);
    return out;
  }

  bool move_to(Model candidate) {
    FrameResiduals there = problem_.residuals_of(candidate, frames_);
    const double value = problem_.log_likelihood(there);
    if (!(value > likelihood_)) return false;
    model_ = std::move(candidate), here_ = std::move(there), likelihood_ = value;
    return true;
  }

  // One linear step; true when another one promises more. What is left after a step of linear size
  // is below the renderer's own differences; a model that is far off needs no exact optimum.
  bool step() {
    const DescentEnd end = descend(
        {.look = [&] { return look(); },
         .move = [&](const VectorXd& by) { return move_to(space_.moved(model_, by)); },
         .height = [&] { return -likelihood_; },
         .worth =
             [&] {
               return Worth{.promise = 0.02, .again = 1, .gain = std::max(0.5, 0.004 * excess())};
             }},
        {.start = 1e-10, .shrink = 0, .least = 1e-10, .grow = 100, .firm = 1e-6, .attempts = 5}, 1);
    return end.reason == DescentEnd::Reason::steps_spent && end.promised >= 2;
  }

  // Parameters of the spread that are sought on the likelihood of some frames, from where the model
  // stands.
  Maximum search_spread(const std::vector<size_t>& frames) {
    std::vector<SearchParameter> parameters;
    for (const size_t i : spread_) {
      const effects::Parameter& parameter = *space_[i].parameter;
      const double value = space_[i].of(model_);
      const bool positive = parameter.min >= 0 && value > 0;
      parameters.push_back(
          {.start = value,
           .min = positive ? std::max(parameter.min, 1e-5 * parameter.scale) : parameter.min,
           .max = parameter.max,
           .step = positive ? 0.05 : 0.05 * parameter.scale,
           .logarithmic = positive});
    }
    Model model = model_;
    return maximise(
        [&](const std::vector<double>& values) {
          set_spread(model, values);
          return likelihood(model, frames);
        },
        parameters);
  }

  void set_spread(Model& model, const std::vector<double>& values) const {
    for (size_t k = 0; k < spread_.size(); ++k) space_[spread_[k]].set(model, values[k]);
  }

  // Two frames hold as many samples as a spread needs to be found: all frames only make it exact,
  // and that only where it helps the two at all (one that helps all by five standard errors fails
  // here once in 40).
  bool helps_on_few() {
    constexpr double kHelps = 0.05;  // Gain of log-likelihood.
    if (frames_.size() < 4) return true;
    const std::vector<size_t> few = two_of(frames_);
    const Maximum maximum = search_spread(few);
    std::vector<double> neutral;
    for (const size_t i : spread_) neutral.push_back(space_[i].parameter->neutral);
    Model without = model_;
    set_spread(without, neutral);
    set_spread(model_, maximum.value);
    here_ = problem_.residuals_of(model_, frames_);
    likelihood_ = problem_.log_likelihood(here_);
    return maximum.log_likelihood > likelihood(without, few) + kHelps;
  }

  void fit_spread() {
    if (spread_.empty()) return;
    if (searched_.value.empty() && !helps_on_few()) return;
    searched_ = search_spread(frames_);
    if (searched_.log_likelihood < likelihood_) return;
    set_spread(model_, searched_.value);
    here_ = problem_.residuals_of(model_, frames_);
    likelihood_ = searched_.log_likelihood;
  }

  const FramesProblem& problem_;
  const std::vector<size_t> frames_;
  const ParameterSpace space_;
  Model model_;
  FrameResiduals here_;
  double likelihood_ = 0;
  std::vector<size_t> mean_, spread_;
  MatrixXd information_;  // At the last look.
  Maximum searched_;      // Of the spread on all groups; empty where only a few were asked.
};

}  // namespace

Fit FramesProblem::fit(const Model& start, const std::vector<Unknown>& unknowns,
                       const Groups& groups) const {
  // Looks and exchanges ask for some fits again.
  const std::string key = fit_key(start, unknowns, groups);
  {
    const std::scoped_lock lock(fits_mutex_);
    if (const auto known = fits_.find(key); known != fits_.end()) return known->second;
  }
  const Fit fit = fit_anew(start, unknowns, groups);
  const std::scoped_lock lock(fits_mutex_);
  return fits_.try_emplace(key, fit).first->second;
}

Fit FramesProblem::fit_anew(const Model& start, const std::vector<Unknown>& unknowns,
                            const Groups& groups) const {
  const std::vector<size_t> frames = frames_of(groups);
  FrameFit fit(*this, start, unknowns, frames);
  if (frames.size() < 4 || !fit.is_far()) return fit.run();
  // Two frames show the way; what all say beyond is a last step or two.
  const Model near = FrameFit(*this, start, unknowns, two_of(frames)).end_of_steps();
  return FrameFit(*this, near, unknowns, frames).run();
}

}  // namespace seam::measurement
