#include "measurement/fitting/leave_out.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/fitting/parameter_space.h"
#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {
namespace {

Eigen::Index index(size_t i) {
  return static_cast<Eigen::Index>(i);
}

// Likelihoods of the parts, from a score of all groups.
double likelihood_of(const Problem& problem, const HeldPart& part, const Score& score) {
  if (part.block >= 0) return score.by_block[static_cast<size_t>(part.block)];
  double sum = 0;
  for (size_t g = 0; g < problem.facts().groups.size(); ++g)
    sum += part.groups[g] ? score.by_group[g] : 0;
  return sum;
}

class LeaveOut {
 public:
  LeaveOut(const Problem& problem, const Fit& whole, const std::vector<Unknown>& unknowns)
      : problem_(problem),
        whole_(whole),
        space_(whole.model, unknowns),
        place_(space_.place(whole.model)),
        parts_(held_parts(problem, whole.model)),
        here_(problem.evaluate(whole.model, problem.all_groups())),
        misfit_(here_.valid && !here_.used.empty() ? misfit_of(problem, here_) : 1),
        steps_(Eigen::MatrixXd::Zero(index(unknowns.size()), index(parts_.size()))) {
    for (size_t i = 0; i < unknowns.size(); ++i) {
      if (space_[i].spread) spreads_.push_back(i);
      // What stands at its bound stays there, and what nobody asked for.
      const bool waits = space_[i].parameter->on_demand && whole.sigma[i] == 0;
      if (!space_[i].spread && !whole.at_bound[i] && !waits) mean_.push_back(i);
    }
  }

  std::vector<Score> run() {
    if (here_.used.empty()) return {};
    if (!here_.valid) return std::vector<Score>(parts_.size(), Score{.valid = false});
    if (!mean_.empty()) step_means();
    for (const size_t i : spreads_) step_spread(i);
    std::vector<Score> scores;
    for (size_t p = 0; p < parts_.size(); ++p) {
      const Model model = model_without(p);
      const Evaluation there = problem_.evaluate(model, parts_[p].groups);
      Score score = parts_[p].block < 0 ? score_of(problem_, there)
                                        : score_of_block(problem_, there, parts_[p].block);
      // The nuisances of one group alone are fitted once, not once a block.
      if (parts_[p].block > 0) score.nuisances = 0;
      scores.push_back(std::move(score));
    }
    return scores;
  }

 private:
  void step_means();
  void step_spread(size_t i);
  Model model_without(size_t part) const;

  const Problem& problem_;
  const Fit& whole_;
  const ParameterSpace space_;
  const Eigen::VectorXd place_;
  const std::vector<HeldPart> parts_;
  const Evaluation here_;
  const double misfit_;
  Eigen::MatrixXd steps_;      // Of the coordinates, a column a part.
  std::vector<double> reach_;  // What a part's step does to all residuals, in units.
  std::vector<size_t> mean_, spreads_;
};

// Where all residuals leave no slope, those without the part have minus the part's slope.
void LeaveOut::step_means() {
  std::vector<Unknown> unknowns;
  for (const size_t i : mean_) unknowns.push_back(space_[i].unknown);
  const auto columns = problem_.jacobian(whole_.model, unknowns, problem_.all_groups(), here_);
  const Eigen::Index count = index(mean_.size());
  Eigen::MatrixXd jacobian(index(here_.whitened.size()), count);
  for (size_t k = 0; k < mean_.size(); ++k) {
    const double slope = space_[mean_[k]].slope(place_[index(mean_[k])]);
    jacobian.col(index(k)) =
        (std::isfinite(slope) ? slope : 1) *
        Eigen::Map<const Eigen::VectorXd>(columns[k].data(), index(columns[k].size()));
  }
  const Eigen::MatrixXd all = jacobian.transpose() * jacobian;
  const Eigen::VectorXd scale =
      all.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();  // To a unit diagonal.
  const Eigen::VectorXd untold = space_.untold();
  reach_.assign(parts_.size(), 0);
  for (size_t p = 0; p < parts_.size(); ++p) {
    Eigen::MatrixXd rest = all;
    Eigen::VectorXd slope = Eigen::VectorXd::Zero(count);
    for (size_t i = 0; i < here_.used.size(); ++i) {
      if (!here_.used[i] || !parts_[p].unseen[i]) continue;
      const auto row = jacobian.row(index(i));
      rest.noalias() -= row.transpose() * row;
      slope += here_.whitened[i] * row.transpose();
    }
    constexpr double kFloor = 1e-9;  // Of the information that a coordinate has alone.
    Eigen::MatrixXd scaled = scale.asDiagonal() * rest * scale.asDiagonal();
    scaled.diagonal().array() += kFloor;
    for (Eigen::Index k = 0; k < count; ++k)
      scaled(k, k) += scale[k] * scale[k] * untold[index(mean_[static_cast<size_t>(k)])];
    const Eigen::VectorXd step =
        scale.asDiagonal() * solve_symmetric(scaled, scale.asDiagonal() * slope);
    if (!step.allFinite()) continue;
    for (size_t k = 0; k < mean_.size(); ++k) steps_(index(mean_[k]), index(p)) = step[index(k)];
    reach_[p] = 0.5 * step.dot(all * step);
  }
}

// A step of Newton in the square of a sigma, in which the likelihood is smooth at zero.
void LeaveOut::step_spread(size_t i) {
  const Coordinate& c = space_[i];
  const double z = place_[index(i)], floor = 1e-3 * c.scale;
  const double square = std::max(z * z, floor * floor), h = 0.1 * square;
  const auto score_at = [&](double q) {
    const Model moved = space_.with(whole_.model, i, std::sqrt(q));
    return score_of(problem_, problem_.evaluate(moved, problem_.all_groups(), &here_));
  };
  const Score below = score_at(square - h), middle = score_at(square), above = score_at(square + h);
  const auto slope = [&](double low, double high) { return (high - low) / (2 * h); };
  const auto bend = [&](double low, double mid, double high) {
    return (high - 2 * mid + low) / (h * h);
  };
  const double all_slope = slope(below.log_likelihood, above.log_likelihood);
  const double all_bend = bend(below.log_likelihood, middle.log_likelihood, above.log_likelihood);
  for (size_t p = 0; p < parts_.size(); ++p) {
    const auto of = [&](const Score& s) { return likelihood_of(problem_, parts_[p], s); };
    const double left_slope = all_slope - slope(of(below), of(above));
    const double left_bend = all_bend - bend(of(below), of(middle), of(above));
    // Inside its bounds the slope of all is what differences leave of zero.
    const double down = z > floor ? left_slope - all_slope : left_slope;
    if (!(left_bend < 0)) continue;
    const double next = std::clamp(square - down / left_bend, square / 4, 4 * square);
    steps_(index(i), index(p)) = std::sqrt(next) - std::max(z, floor);
  }
}

Model LeaveOut::model_without(size_t p) const {
  const Eigen::VectorXd step = steps_.col(index(p));
  const Model near = space_.moved(whole_.model, step);
  // Parts that weigh much, or that alone tell a value, are far from what a step can tell: as far as
  // it holds for the rest.
  constexpr double kMuch = 2;  // In units of the misfit.
  if (reach_.empty() || reach_[p] < kMuch * misfit_ * misfit_) return near;
  const auto seen = [&](const Model& model) {
    const Evaluation there = problem_.evaluate(model, problem_.all_groups(), &here_);
    double sum = there.valid ? 0 : std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < there.used.size(); ++i)
      sum += there.used[i] && !parts_[p].unseen[i] ? there.whitened[i] * there.whitened[i] : 0;
    return sum;
  };
  const double before = seen(whole_.model);
  for (double share = 1; share > 0.05; share *= 0.4) {
    const Model tried = space_.moved(whole_.model, share * step);
    if (seen(tried) < before) return tried;
  }
  return whole_.model;
}

}  // namespace

double memory_s(const Model& model) {
  double longest = 0;
  for (const effects::ModelEffect& effect : model.effects()) {
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      const std::string& name = effect.definition->parameters[i].name;
      const bool seconds = name.size() > 2 && name.ends_with("_s") && !name.ends_with("per_s");
      const double value = std::abs(effect.parameters[i].value);
      if (seconds && std::isfinite(value)) longest = std::max(longest, value);
    }
  }
  return longest;
}

std::vector<HeldPart> held_parts(const Problem& problem, const Model& model) {
  const Facts& facts = problem.facts();
  const std::vector<int>& block = problem.blocks();
  std::vector<HeldPart> parts;
  if (facts.groups.size() > 1 || problem.block_count() < 2) {
    for (const Groups& fold : problem.folds()) {
      HeldPart part{.groups = fold, .unseen = std::vector<char>(facts.scalars(), 0)};
      for (size_t i = 0; i < facts.scalars(); ++i) part.unseen[i] = fold[facts.group_of(i)];
      parts.push_back(std::move(part));
    }
    return parts;
  }
  const double gap = memory_s(model);
  const auto time = [&](size_t i) { return facts.time_of_row[facts.row_of[i]]; };
  for (size_t b = 0; b < problem.block_count(); ++b) {
    HeldPart part{.groups = problem.all_groups(),
                  .block = static_cast<int>(b),
                  .unseen = std::vector<char>(facts.scalars(), 0)};
    double first = std::numeric_limits<double>::infinity(), last = -first;
    for (size_t i = 0; i < facts.scalars(); ++i) {
      if (block[i] == part.block) first = std::min(first, time(i)), last = std::max(last, time(i));
    }
    // The gap takes no more than half as much on each side as the block itself.
    const double beside = std::min(gap, 0.5 * (last - first));
    for (size_t i = 0; i < facts.scalars(); ++i) {
      const bool near = time(i) > first - beside && time(i) < last + beside;
      part.unseen[i] = block[i] == part.block || (beside > 0 && near);
    }
    parts.push_back(std::move(part));
  }
  return parts;
}

std::vector<Score> scores_held_out(const Problem& problem, const Fit& whole,
                                   const std::vector<Unknown>& unknowns) {
  return LeaveOut(problem, whole, unknowns).run();
}

}  // namespace seam::measurement
