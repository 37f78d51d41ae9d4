#include "measurement/infer/unnamed.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "measurement/infer/random_effect.h"
#include "measurement/infer/smooth_field.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/parallel_for.h"

namespace seam::measurement {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Groups, or where they are few their blocks, in so many parts: each is predicted from the others.
constexpr int kParts = 4;
// Functions of one cause, and the least log-evidence that a further one gains.
constexpr int kMostFunctions = 3;
constexpr double kLeastGain = 4.6;

// A function that depends on something says more than noise of unknown cause, and takes its place
// where it takes what that takes. Of a large cause its one linear step falls this share short of a
// fit.
constexpr double kStepFallsShort = 0.05;

// One explanation's residuals, without what its own parameters can still take of them.
class Residuals {
 public:
  Residuals(const Problem& problem, const Model& model, const std::vector<Unknown>& unknowns);

  bool valid() const { return !scalars_.empty(); }
  // The best functions, one after another, while each gains; nothing where the first does not.
  std::optional<UnnamedCause> best_cause(std::vector<TriedFunction>* tried);
  double squares() const { return rest_.squaredNorm(); }
  // Of log-likelihood, by one linear step of the explanation's own parameters.
  double step_gain() const { return step_gain_; }

 private:
  // A function's columns, without what follows them, and what they gain.
  struct Function {
    MatrixXd columns, gram;
    std::vector<RandomCoefficients> priors;  // As rough and as smooth as FieldColumns has them.
    MatrixXd named;                          // Orthonormal: of FieldPlace::named.
    std::array<MatrixXd, kParts> gram_of_part;
    RandomEffect effect;
  };
  VectorXd own_of(const std::vector<double>& column) const;
  MatrixXd own_of(const std::vector<std::vector<double>>& columns) const;
  auto rows_of(const auto& matrix, int part) const {
    return matrix.middleRows(begins_[part], begins_[part + 1] - begins_[part]);
  }
  Function function_of(const SmoothField& field) const;
  VectorXd beside_named(const Function& function) const;
  double named_gain(const Function& function) const;
  double held_out_gain(const Function& function) const;
  std::vector<SmoothField> fields();

  const Problem& problem_;
  const Model& model_;
  Evaluation here_;
  std::vector<size_t> scalars_;                // Those that take part, part by part.
  std::array<Index, kParts + 1> begins_ = {};  // Of each part among them, then the end.
  MatrixXd span_;                              // Orthonormal: of the fitted parameters.
  VectorXd rest_;
  double step_gain_ = 0;
  std::vector<FieldPlace> places_;
};

Residuals::Residuals(const Problem& problem, const Model& model,
                     const std::vector<Unknown>& unknowns)
    : problem_(problem), model_(model) {
  const Groups all = problem.all_groups();
  here_ = problem.evaluate(model, all);
  if (!here_.valid || here_.whitened.size() < problem.facts().scalars()) return;
  const std::vector<int>& blocks = problem.blocks();
  for (int part = 0; part < kParts; ++part) {
    for (size_t i = 0; i < problem.facts().scalars(); ++i) {
      const int unit = blocks.empty() ? problem.facts().group_of(i) : blocks[i];
      if (here_.used[i] && unit % kParts == part) scalars_.push_back(i);
    }
    begins_[part + 1] = static_cast<Index>(scalars_.size());
  }
  std::vector<Unknown> mean;
  std::copy_if(unknowns.begin(), unknowns.end(), std::back_inserter(mean),
               [&](const Unknown& u) { return !model.find(u.effect)->definition->spread_only; });
  const auto columns =
      mean.empty() ? std::vector<std::vector<double>>() : problem.jacobian(model, mean, all, here_);
  MatrixXd slopes(static_cast<Index>(scalars_.size()), static_cast<Index>(columns.size()));
  for (size_t k = 0; k < columns.size(); ++k) {
    for (size_t i = 0; i < scalars_.size(); ++i)
      slopes(static_cast<Index>(i), static_cast<Index>(k)) = columns[k][scalars_[i]];
    const double length = slopes.col(static_cast<Index>(k)).norm();
    if (length > 0) slopes.col(static_cast<Index>(k)) /= length;
  }
  span_ = columns.empty() ? slopes : column_basis(slopes, 1e-6);
  std::vector<double> beyond = here_.whitened;
  for (size_t i = 0; i < problem.facts().scalars(); ++i) beyond[i] = here_.beyond_mean(i);
  rest_ = own_of(beyond);
  for (const size_t i : scalars_) step_gain_ += 0.5 * beyond[i] * beyond[i];
  step_gain_ -= 0.5 * rest_.squaredNorm();
}

std::vector<SmoothField> Residuals::fields() {
  places_ = places_in_channels(problem_, here_);
  for (FieldPlace& place : problem_.field_places(model_, here_))
    places_.push_back(std::move(place));
  return smooth_fields(places_);
}

VectorXd Residuals::own_of(const std::vector<double>& column) const {
  VectorXd own(static_cast<Index>(scalars_.size()));
  for (size_t i = 0; i < scalars_.size(); ++i) own[static_cast<Index>(i)] = column[scalars_[i]];
  if (span_.cols() > 0) own -= span_ * (span_.transpose() * own);
  return own;
}

MatrixXd Residuals::own_of(const std::vector<std::vector<double>>& columns) const {
  MatrixXd own(static_cast<Index>(scalars_.size()), static_cast<Index>(columns.size()));
  for (size_t k = 0; k < columns.size(); ++k) own.col(static_cast<Index>(k)) = own_of(columns[k]);
  return own;
}

Residuals::Function Residuals::function_of(const SmoothField& field) const {
  FieldColumns made = columns_of(problem_.facts(), field);
  if (made.values.empty()) return {};
  const auto columns =
      problem_.following(model_, problem_.all_groups(), here_, std::move(made.values));
  const auto count = static_cast<Index>(columns.size());
  Function function{.columns = own_of(columns), .gram = MatrixXd::Zero(count, count)};
  if (!field.place->named.empty()) {
    function.named = column_basis(own_of(field.place->named), 1e-6);
    function.columns -= function.named * (function.named.transpose() * function.columns);
  }
  for (int part = 0; part < kParts; ++part) {
    const auto own = rows_of(function.columns, part);
    function.gram += function.gram_of_part[part] = own.transpose() * own;
  }
  function.priors.emplace_back(function.gram, VectorXd::Ones(count));
  function.priors.emplace_back(function.gram,
                               Eigen::Map<const VectorXd>(made.smoother.data(), count));
  return function;
}

VectorXd Residuals::beside_named(const Function& function) const {
  if (function.named.cols() == 0) return rest_;
  return rest_ - function.named * (function.named.transpose() * rest_);
}

// Log-evidence of what effects with names do and a function brings along.
double Residuals::named_gain(const Function& function) const {
  const double price = 0.5 * std::log(static_cast<double>(scalars_.size()));
  const double taken = 0.5 * (rest_.squaredNorm() - beside_named(function).squaredNorm());
  return std::max(0.0, taken - price * static_cast<double>(function.named.cols()));
}

// Of log-likelihood, each part predicted from all others.
double Residuals::held_out_gain(const Function& function) const {
  const VectorXd rest = beside_named(function);
  const VectorXd all = function.columns.transpose() * rest;
  double gain = 0;
  for (int part = 0; part < kParts; ++part) {
    const MatrixXd& gram = function.gram_of_part[part];
    const VectorXd right = rows_of(function.columns, part).transpose() * rows_of(rest, part);
    const VectorXd b = coefficients_of(function.gram - gram, all - right, function.effect.spread);
    gain += right.dot(b) - 0.5 * b.dot(gram * b);
  }
  return gain;
}

// One line for each set of covariates, by the place in which it gains most.
void note_tried(const std::vector<std::string>& covariates, bool is_testable, double log_evidence,
                std::vector<TriedFunction>& tried) {
  for (TriedFunction& known : tried) {
    if (known.covariates != covariates) continue;
    known.is_testable = known.is_testable || is_testable;
    known.log_evidence = std::max(known.log_evidence, log_evidence);
    return;
  }
  tried.push_back({covariates, is_testable, log_evidence});
}

std::optional<UnnamedCause> Residuals::best_cause(std::vector<TriedFunction>* tried) {
  const std::vector<SmoothField> fields = this->fields();
  std::vector<Function> functions(fields.size());
  parallel_for(fields.size(), [&](size_t f) { functions[f] = function_of(fields[f]); });
  const VectorXd first = rest_;
  const auto count = static_cast<double>(scalars_.size());
  // Each field is two looks.
  const double price = std::log(2.0 * static_cast<double>(fields.size()));
  UnnamedCause cause;
  for (int k = 0; k < kMostFunctions; ++k) {
    parallel_for(fields.size(), [&](size_t f) {
      Function& function = functions[f];
      function.effect = {};
      if (function.columns.cols() == 0) return;
      const VectorXd right = function.columns.transpose() * rest_;
      for (const RandomCoefficients& prior : function.priors) {
        RandomEffect effect = prior.effect(right);
        if (effect.log_evidence > function.effect.log_evidence) function.effect = std::move(effect);
      }
      if (function.effect.log_evidence > kLeastGain && held_out_gain(function) <= 0)
        function.effect.log_evidence = 0;
      if (function.effect.log_evidence > kLeastGain)
        function.effect.log_evidence += named_gain(function);
    });
    for (size_t f = 0; k == 0 && tried != nullptr && f < fields.size(); ++f)
      note_tried(names_of(fields[f]), functions[f].columns.cols() > 0,
                 functions[f].effect.log_evidence - price, *tried);
    const auto best = std::max_element(functions.begin(), functions.end(),
                                       [](const Function& a, const Function& b) {
                                         return a.effect.log_evidence < b.effect.log_evidence;
                                       });
    const double gain = best == functions.end() ? 0 : best->effect.log_evidence - price;
    if (gain < kLeastGain) break;
    cause.lead += gain;
    const auto names = names_of(fields[static_cast<size_t>(best - functions.begin())]);
    if (std::find(cause.depends_on.begin(), cause.depends_on.end(), names) ==
        cause.depends_on.end())
      cause.depends_on.push_back(names);
    rest_ -= best->columns * best->effect.coefficients;
    rest_ = beside_named(*best);
  }
  if (cause.depends_on.empty()) return std::nullopt;
  cause.noise_units =
      std::sqrt((first - rest_).squaredNorm() / (count * problem_.facts().values_of_scalar));
  cause.error_before = std::sqrt(first.squaredNorm() / count);
  cause.error_after = std::sqrt(rest_.squaredNorm() / count);
  cause.takes = std::min(1.0, (first.squaredNorm() - rest_.squaredNorm()) /
                                  std::max(first.squaredNorm() - count, 1.0));
  return cause;
}

// The model with the noise that another has found, in what both have of it.
Model with_noise_of(Model model, const Model& other) {
  for (const effects::ModelEffect& effect : other.effects()) {
    const std::string& name = effect.definition->name;
    if (!effect.definition->spread_only || !model.has(name)) continue;
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      if (model.find(name)->parameters[i].refitted())
        model.set_value(name, i, effect.parameters[i].value);
    }
  }
  return model;
}

// Of models with the same effects.
bool same_values(const Model& a, const Model& b) {
  return std::ranges::equal(a.effects(), b.effects(), [](const auto& one, const auto& other) {
    return std::ranges::equal(one.values(), other.values());
  });
}

CauseBeside best_beside(const Problem& problem, const Assessment& assessment) {
  CauseBeside out;
  Residuals residuals(problem.with_residuals(), assessment.model, assessment.unknowns);
  if (!residuals.valid()) return out;
  out.step_gain = residuals.step_gain();
  out.cause = residuals.best_cause(&out.tried);
  return out;
}

// What is known of an explanation, and its log-evidence where its parameters fit all groups.
struct Compared {
  std::shared_ptr<const CauseBeside> beside;
  double log_evidence = 0;
};

// `other_noise` is the explanation's model with another noise than its own.
Compared compared(const Problem& problem, const Explanation& explanation, const KnownCauses& known,
                  const Model* other_noise = nullptr) {
  Assessment assessment = *explanation.assessment;
  Compared out{.log_evidence = explanation.log_evidence};
  if (other_noise != nullptr) {
    const Groups all = problem.all_groups();
    out.log_evidence += problem.score(*other_noise, all).log_likelihood -
                        problem.score(assessment.model, all).log_likelihood;
    assessment.model = *other_noise;
  }
  out.beside =
      known.of(0, key_of(problem, assessment), [&] { return best_beside(problem, assessment); });
  // Rows were fitted: where averages of them are seen, these may ask for another step.
  if (&problem.with_residuals() == &problem || other_noise != nullptr)
    out.log_evidence += out.beside->step_gain;
  return out;
}

// Ahead of the last explanation, all of whose causes have names.
std::optional<UnnamedCause> ahead_of(const Compared& last, const Compared& here,
                                     bool noise_follows) {
  std::optional<UnnamedCause> cause = here.beside->cause;
  const double ahead = here.log_evidence - last.log_evidence;
  if (!cause || !std::isfinite(ahead)) return std::nullopt;
  // Where something is left that is no noise, evidence is too sure.
  const double misfit = std::max(1.0, cause->error_after * cause->error_after);
  const double short_by = noise_follows ? kStepFallsShort * cause->lead : 0;
  cause->lead = (cause->lead + short_by + ahead) / misfit;
  return cause;
}

}  // namespace

std::optional<UnnamedCause> unnamed_cause(const Problem& problem,
                                          const std::vector<Explanation>& explanations,
                                          double material, const KnownCauses& known,
                                          std::vector<TriedFunction>* tried) {
  const Explanation& last = explanations.back();
  const Compared at_last = compared(problem, last, known);
  if (tried != nullptr) *tried = at_last.beside->tried;
  std::vector<std::optional<UnnamedCause>> causes;
  for (size_t e = 0; e + 1 < explanations.size(); ++e) {
    const Explanation& explanation = explanations[e];
    const auto beside = [&](const Model* other_noise) {
      return ahead_of(at_last, compared(problem, explanation, known, other_noise),
                      explanation.noise_follows);
    };
    causes.push_back(beside(nullptr));
    if (!causes.back()) continue;
    // Noise that is fitted takes what an explanation leaves, and hides a part of a cause.
    const Model& own = explanation.assessment->model;
    const Model quiet = with_noise_of(own, last.assessment->model);
    if (same_values(quiet, own)) continue;
    auto other = beside(&quiet);
    if (other && other->lead > causes.back()->lead) causes.back() = std::move(other);
  }
  causes.push_back(ahead_of(at_last, at_last, last.noise_follows));
  // What is too small to count beside the last makes no other explanation better than it.
  const bool is_trace = causes.back() && causes.back()->noise_units < material;
  const double trace = is_trace ? std::max(0.0, causes.back()->lead) : 0;
  std::optional<UnnamedCause> best;
  for (size_t e = 0; e < causes.size(); ++e) {
    std::optional<UnnamedCause>& cause = causes[e];
    if (!cause || cause->noise_units < material) continue;
    cause->beside = e;
    cause->lead -= trace;
    // Of equals the one with the fewest effects: beside a cause without a name small ones with
    // names are not to be trusted.
    if (cause->lead > 0 && (!best || cause->lead > best->lead + kLeastGain))
      best = std::move(cause);
  }
  return best;
}

std::vector<double> own_shares(const Problem& problem, const Assessment& explanation,
                               const std::vector<std::vector<std::string>>& sets) {
  // Residuals, and what smooth functions gain of them.
  struct Left {
    double squares = 0, gain = 0;
  };
  const auto left_by = [&](const Model& model,
                           const std::vector<Unknown>& unknowns) -> std::optional<Left> {
    Residuals residuals(problem.with_residuals(), model, unknowns);
    if (!residuals.valid()) return std::nullopt;
    Left left{.squares = residuals.squares()};
    if (const auto cause = residuals.best_cause(nullptr)) left.gain = cause->lead;
    return left;
  };
  std::vector<double> shares(sets.size(), 1);
  if (sets.empty()) return shares;
  const auto with = left_by(explanation.model, explanation.unknowns);
  if (!with) return shares;
  for (size_t i = 0; i < sets.size(); ++i) {
    Model model = explanation.model;
    std::vector<Unknown> unknowns = explanation.unknowns;
    for (const std::string& effect : sets[i]) {
      model.remove(effect);
      std::erase_if(unknowns, [&](const Unknown& unknown) { return unknown.effect == effect; });
    }
    const auto without = left_by(model, unknowns);
    if (!without) continue;
    const double taken = 0.5 * (without->squares - with->squares);
    if (taken > 0) shares[i] = 1 - (without->gain - with->gain) / taken;
  }
  return shares;
}

}  // namespace seam::measurement
