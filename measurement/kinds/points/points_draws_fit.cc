// Fits of models that draw points of the target or its bendings, or whose points fail now and then:
// parameters of the mean, poses and draws take their steps together, and the spreads follow from
// the draws and the residuals themselves.
// Docs: docs/design/engine.md, "Draws that are estimated".
#include <cmath>

#include "effects/stages/noise.h"
#include "measurement/fitting/parameter_space.h"
#include "measurement/kinds/points/points_problem.h"
#include "measurement/numerics/curvature.h"

namespace seam::measurement {
namespace {

// What a parameter is the spread of.
enum class Spread { none, points, bendings, focuses, motions, shifts, turns, failing, failure };

Spread spread_of(const Model& model, const Coordinate& c) {
  const double value = c.of(model);
  Model other = model;
  c.set(other, value + c.scale);
  const effects::TargetShape here = effects::target_of(model), there = effects::target_of(other);
  const effects::Few few = effects::noise_of(model).point_scatter,
                     changed = effects::noise_of(other).point_scatter;
  const auto is = [&](double now, double then) { return now != then && now == value; };
  if (is(here.scatter_sigma_m, there.scatter_sigma_m)) return Spread::points;
  if (is(here.flex_sigma_m, there.flex_sigma_m)) return Spread::bendings;
  if (is(here.focus_sigma, there.focus_sigma)) return Spread::focuses;
  if (is(here.motion_sigma_rad, there.motion_sigma_rad)) return Spread::motions;
  if (is(here.sway_shift_sigma_m, there.sway_shift_sigma_m)) return Spread::shifts;
  if (is(here.sway_turn_sigma_rad, there.sway_turn_sigma_rad)) return Spread::turns;
  if (is(few.fraction, changed.fraction)) return Spread::failing;
  return is(few.size, changed.size) ? Spread::failure : Spread::none;
}

// Null: no spread of draws.
template <class Sums>
auto sum_of(Spread spread, Sums& sums) -> decltype(&sums.points) {
  switch (spread) {
    case Spread::points:
      return &sums.points;
    case Spread::bendings:
      return &sums.bendings;
    case Spread::focuses:
      return &sums.focuses;
    case Spread::motions:
      return &sums.motions;
    case Spread::shifts:
      return &sums.shifts;
    case Spread::turns:
      return &sums.turns;
    default:
      return nullptr;
  }
}

std::vector<Unknown> of_mean(const Model& model, const std::vector<Unknown>& unknowns) {
  std::vector<Unknown> mean;
  for (const Unknown& unknown : unknowns) {
    if (!model.find(unknown.effect)->definition->spread_only) mean.push_back(unknown);
  }
  return mean;
}

}  // namespace

class PointsProblem::DrawsFit {
 public:
  DrawsFit(const PointsProblem& problem, const Model& start, const std::vector<Unknown>& unknowns,
           const Groups& groups)
      : problem_(problem),
        groups_(groups),
        mean_unknowns_(of_mean(start, unknowns)),
        space_(start, unknowns),
        mean_(start, mean_unknowns_),
        model_(start) {}

  // Nothing where a parameter is of another sort, or a spread vanishes: that is the default's work,
  std::optional<Fit> run();
  // which starts from here.
  const Model& model() const { return model_; }

 private:
  bool suits() const;
  bool go_down();
  bool move(const Eigen::VectorXd& by);
  bool follow();
  void look_for_failures();
  std::unique_ptr<TargetAdjustment> adjustment(const Model& model,
                                               const std::vector<double>& values) const {
    return problem_.adjustment_at(model, groups_, nullptr, values, sigma_);
  }
  // Where the likelihood has the spread, given all else, and the information on its logarithm.
  struct Wish {
    double value = 0, information = 0;
  };
  Wish wish_of(const Coordinate& c) const;
  Fit result(const Evaluation& end) const;

  const PointsProblem& problem_;
  const Groups& groups_;
  const std::vector<Unknown> mean_unknowns_;
  const ParameterSpace space_, mean_;
  Model model_;
  std::vector<double> values_;
  std::unique_ptr<TargetAdjustment> here_;
  std::vector<double> sigma_;                   // By scalar, where points may have failed.
  TargetAdjustment::DrawsSums sums_, squares_;  // Where it was looked at, and where it stands.
  Wish failing_, failure_;
  Eigen::MatrixXd curvature_;
  double height_ = 0, misfit2_ = 1;
  double moved_ = 0;  // What the last change of the spreads was worth.
};

bool PointsProblem::DrawsFit::suits() const {
  if (problem_.data_.rig.type() != Rig::Type::unknown) return false;
  if (problem_.moves() && !effects::target_of(model_).has_draws()) return false;
  for (const Coordinate& c : space_) {
    if (c.parameter->fit_reciprocal || c.parameter->on_demand) return false;
    if (c.spread && spread_of(model_, c) == Spread::none) return false;
  }
  return true;
}

bool PointsProblem::DrawsFit::move(const Eigen::VectorXd& by) {
  const Eigen::VectorXd place = mean_.place(model_);
  const Eigen::VectorXd next = mean_.box().inside(place + by);
  const Model model = mean_.at(model_, next);
  std::vector<double> values = here_->values_after(next - place);
  auto there = adjustment(model, values);
  const double height = there->height();
  if (!(height < height_)) return false;
  model_ = model, values_ = std::move(values), height_ = height;
  squares_ = there->squares();
  return true;
}

// How likely each point has failed where the model stands; of these the share and the size of
// failures follow (a step of expectation and maximisation).
void PointsProblem::DrawsFit::look_for_failures() {
  const std::optional<FewErrors> scatter = scatter_of(model_);
  if (!scatter) return;
  Evaluation here = problem_.blank();
  here_->tell_residuals(here);
  sigma_ = here.sigma;
  const double f = scatter->fraction(), size2 = scatter->size() * scatter->size();
  double points = 0, failed = 0, square = 0, of_share = 0, of_size = 0;
  for (size_t row = 0; row < problem_.data_.p_W.size(); ++row) {
    const double u = here.residual[2 * row], v = here.residual[2 * row + 1];
    double& su = sigma_[2 * row];
    double& sv = sigma_[2 * row + 1];
    // Of a failed point's residual, the part that is the failure's.
    const auto part2 = [&](double r, double sigma) {
      const double share = size2 / (size2 + sigma * sigma);
      return share * (share * r * r + sigma * sigma);
    };
    const double part = part2(u, su) + part2(v, sv);
    const Failure failure = failure_of(*scatter, u, v, su, sv);
    su = failure.sigma_u, sv = failure.sigma_v;
    if (!groups_[problem_.facts_.group_of_row[row]] || !problem_.takes_part(row)) continue;
    ++points, failed += failure.share, square += failure.share * part;
    of_share += std::pow((failure.share - f) / (1 - f), 2);
    of_size += std::pow(failure.share * (part / size2 - 2), 2);
  }
  here_->set_sigma(sigma_);
  failing_ = {failed / std::max(1.0, points), of_share};
  failure_ = {std::sqrt(square / std::max(1e-9, 2 * failed)), of_size};
}

// A spread of draws is where their sum of squares is as large as their freedom (MacKay 1992).
PointsProblem::DrawsFit::Wish PointsProblem::DrawsFit::wish_of(const Coordinate& c) const {
  const Spread spread = spread_of(model_, c);
  if (spread == Spread::failing) return failing_;
  if (spread == Spread::failure) return failure_;
  const TargetAdjustment::DrawsSum& sum = *sum_of(spread, sums_);
  return {c.of(model_) * std::sqrt(sum.square / std::max(sum.freedom, 1e-9)), sum.information};
}

bool PointsProblem::DrawsFit::follow() {
  moved_ = 0;
  std::vector<double> wishes;
  for (const Coordinate& c : space_) {
    if (!c.spread) continue;
    constexpr double kMost = 6;  // A factor a step.
    const double value = c.of(model_), floor = 1e-3 * c.scale;
    const Wish wish = wish_of(c);
    const double next = std::min(std::clamp(wish.value, value / kMost, kMost * value), c.max);
    const Spread spread = spread_of(model_, c);
    if (sum_of(spread, sums_) && !(next > floor)) {
      c.set(model_, 0);
      return false;
    }
    wishes.push_back(std::max(next, floor));
    const double by = std::log(wishes.back() / value);
    moved_ += 0.5 * wish.information * by * by;
  }
  size_t at = 0;
  for (const Coordinate& c : space_) {
    if (c.spread) c.set(model_, wishes[at++]);
  }
  return true;
}

bool PointsProblem::DrawsFit::go_down() {
  constexpr int kMost = 60;
  // In units of log-likelihood, or of the misfit.
  constexpr double kEnough = 1e-4;
  DampedSteps steps({.start = 1e-6, .attempts = 12});
  for (int step = 0; step < kMost; ++step) {
    here_ = adjustment(model_, values_);
    look_for_failures();
    const MovedModels moved(model_, mean_unknowns_);
    std::optional<Parabola> parabola = here_->look(moved.models, moved.steps);
    if (!parabola) return false;
    curvature_ = parabola->curvature;
    parabola->held = mean_.box().held(mean_.place(model_), parabola->gradient);
    height_ = here_->height();
    const auto n = static_cast<double>(std::max<size_t>(1, problem_.facts_.scalars()));
    misfit2_ = std::max(1.0, 2 * height_ / n);
    squares_ = sums_ = here_->sums();
    const double before = height_;
    const auto outcome = steps.take(*parabola, {.promise = kEnough * misfit2_},
                                    [&](const Eigen::VectorXd& by) { return move(by); });
    const bool taken = outcome == DampedSteps::Outcome::taken;
    // The nuisances alone.
    if (!taken && !move(Eigen::VectorXd::Zero(parabola->gradient.size()))) height_ = before;
    for (const Spread s : {Spread::points, Spread::bendings, Spread::focuses, Spread::motions,
                           Spread::shifts, Spread::turns})
      sum_of(s, sums_)->square = sum_of(s, squares_)->square;
    if (!follow()) return false;
    const bool settled = before - height_ < kEnough * misfit2_ && moved_ < kEnough * misfit2_;
    if (settled) return true;
  }
  return true;
}

std::optional<Fit> PointsProblem::DrawsFit::run() {
  if (!suits()) return std::nullopt;
  Evaluation near;
  near.nuisance_values = problem_.start_beside(model_, groups_);
  const Evaluation first =
      problem_.evaluate(model_, groups_, near.nuisance_values.empty() ? nullptr : &near);
  if (!first.valid) return std::nullopt;
  values_ = first.nuisance_values;
  if (!go_down()) return std::nullopt;
  Evaluation warm;
  warm.nuisance_values = values_;
  const Evaluation end = problem_.evaluate(model_, groups_, &warm);
  if (!end.valid) return std::nullopt;
  problem_.remember_end(model_, groups_, end.nuisance_values);
  return result(end);
}

Fit PointsProblem::DrawsFit::result(const Evaluation& end) const {
  const Eigen::VectorXd place = space_.place(model_);
  Fit fit = space_.fit_at(model_, place, log_likelihood_of(problem_, end), true);
  // Spreads have no curvature here, and are not known by it.
  const auto count = static_cast<Eigen::Index>(space_.size());
  Eigen::MatrixXd curvature = Eigen::MatrixXd::Zero(count, count);
  std::vector<Eigen::Index> which;
  for (Eigen::Index i = 0; i < count; ++i) {
    if (!space_[static_cast<size_t>(i)].spread) which.push_back(i);
  }
  curvature(which, which) = curvature_;
  if (!which.empty())
    space_.state(covariance_of(curvature, 1e-13), misfit_of(problem_, end), place, fit);
  for (size_t i = 0; i < space_.size(); ++i) {
    if (!space_[i].spread) continue;
    const double z = space_[i].of(model_);
    space_.state(i, z / std::sqrt(wish_of(space_[i]).information), z, fit);
  }
  return fit;
}

Fit PointsProblem::fit(const Model& given, const std::vector<Unknown>& unknowns,
                       const Groups& groups) const {
  const Model start = with_cameras_placed(given, unknowns, groups);
  if (effects::target_of(start).has_draws() || scatter_of(start)) {
    DrawsFit together(*this, start, unknowns, groups);
    if (auto fit = together.run()) return *std::move(fit);
    return Problem::fit(together.model(), unknowns, groups);
  }
  return Problem::fit(start, unknowns, groups);
}

}  // namespace seam::measurement
