#include "measurement/infer/unnamed.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>

#include "measurement/infer/function_beside.h"
#include "measurement/infer/smooth_field.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/parallel_for.h"

namespace seam::measurement {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

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
  void sort_scalars();
  MatrixXd of_scalars(const std::vector<std::vector<double>>& columns) const;
  // Of those that take part; none: not known.
  struct Columns {
    MatrixXd values;
    VectorXd smoother;  // As FieldColumns has it.
  };
  Columns columns_in(const SmoothField& field) const;
  FunctionBeside function_of(const SmoothField& field, const Columns& columns) const;
  std::vector<SmoothField> fields();

  const Problem& problem_;
  const Model& model_;
  Evaluation here_;
  std::vector<size_t> scalars_;  // Those that take part, part by part, and in these by channel.
  PartsOfScalars parts_;
  std::shared_ptr<const MatrixXd> span_;  // Orthonormal: of the fitted parameters.
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
  sort_scalars();
  std::vector<Unknown> mean;
  std::copy_if(unknowns.begin(), unknowns.end(), std::back_inserter(mean),
               [&](const Unknown& u) { return !model.find(u.effect)->definition->spread_only; });
  MatrixXd slopes = MatrixXd(static_cast<Index>(scalars_.size()), 0);
  if (!mean.empty()) slopes = of_scalars(problem.jacobian(model, mean, all, here_));
  for (auto slope : slopes.colwise()) {
    if (const double length = slope.norm(); length > 0) slope /= length;
  }
  span_ = std::make_shared<const MatrixXd>(mean.empty() ? slopes : column_basis(slopes, 1e-6));
  rest_.resize(slopes.rows());
  for (size_t i = 0; i < scalars_.size(); ++i)
    rest_[static_cast<Index>(i)] = here_.beyond_mean(scalars_[i]);
  step_gain_ = 0.5 * rest_.squaredNorm();
  rest_ -= *span_ * (span_->transpose() * rest_);
  step_gain_ -= 0.5 * rest_.squaredNorm();
}

void Residuals::sort_scalars() {
  const Facts& facts = problem_.facts();
  const std::vector<int>& blocks = problem_.blocks();
  const auto count = [&] { return static_cast<Index>(scalars_.size()); };
  for (int part = 0; part < PartsOfScalars::kCount; ++part) {
    parts_.begin_of_part.push_back(count());
    for (size_t channel = 0; channel < facts.channels.size(); ++channel) {
      parts_.begin_of_segment.push_back(count());
      for (size_t i = 0; i < facts.scalars(); ++i) {
        const int unit = blocks.empty() ? facts.group_of(i) : blocks[i];
        if (here_.used[i] && unit % PartsOfScalars::kCount == part &&
            facts.channel_of[i] == static_cast<int>(channel))
          scalars_.push_back(i);
      }
    }
  }
  parts_.begin_of_part.push_back(count());
  parts_.begin_of_segment.push_back(count());
}

std::vector<SmoothField> Residuals::fields() {
  places_ = places_in_channels(problem_, here_);
  for (FieldPlace& place : problem_.field_places(model_, here_))
    places_.push_back(std::move(place));
  return smooth_fields(places_);
}

MatrixXd Residuals::of_scalars(const std::vector<std::vector<double>>& columns) const {
  MatrixXd own(static_cast<Index>(scalars_.size()), static_cast<Index>(columns.size()));
  for (size_t k = 0; k < columns.size(); ++k) {
    for (size_t i = 0; i < scalars_.size(); ++i)
      own(static_cast<Index>(i), static_cast<Index>(k)) = columns[k][scalars_[i]];
  }
  return own;
}

Residuals::Columns Residuals::columns_in(const SmoothField& field) const {
  FieldColumns made = columns_of(problem_.facts(), field);
  if (made.values.empty()) return {};
  return {
      of_scalars(problem_.following(model_, problem_.all_groups(), here_, std::move(made.values))),
      Eigen::Map<const VectorXd>(made.smoother.data(), static_cast<Index>(made.smoother.size()))};
}

FunctionBeside Residuals::function_of(const SmoothField& field, const Columns& columns) const {
  if (columns.values.cols() == 0) return {};
  auto span = span_;
  Index named = 0;
  if (!field.place->named.empty()) {
    MatrixXd along = of_scalars(field.place->named);
    along -= *span_ * (span_->transpose() * along);
    along = column_basis(along, 1e-6);
    named = along.cols();
    MatrixXd both(along.rows(), span_->cols() + named);
    both << *span_, along;
    span = std::make_shared<const MatrixXd>(std::move(both));
  }
  return {parts_, std::move(span), named, columns.values, columns.smoother};
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
  std::vector<FunctionBeside> functions(fields.size());
  std::vector<Columns> kept(fields.size());
  const VectorXd first = rest_;
  const auto count = static_cast<double>(scalars_.size());
  // Each field is two looks.
  const double price = std::log(2.0 * static_cast<double>(fields.size()));
  UnnamedCause cause;
  for (int k = 0; k < kMostFunctions; ++k) {
    parallel_for(fields.size(), [&](size_t f) {
      if (k > 0 && !functions[f].is_testable()) return;
      const Columns columns = kept[f].values.size() > 0 ? kept[f] : columns_in(fields[f]);
      if (fields[f].place->arrives) kept[f] = columns;
      if (k == 0) functions[f] = function_of(fields[f], columns);
      if (functions[f].is_testable()) functions[f].look(columns.values, rest_, kLeastGain);
    });
    for (size_t f = 0; k == 0 && tried != nullptr && f < fields.size(); ++f)
      note_tried(names_of(fields[f]), functions[f].is_testable(),
                 functions[f].log_evidence() - price, *tried);
    const auto best = std::max_element(functions.begin(), functions.end(),
                                       [](const FunctionBeside& a, const FunctionBeside& b) {
                                         return a.log_evidence() < b.log_evidence();
                                       });
    const double gain = best == functions.end() ? 0 : best->log_evidence() - price;
    if (gain < kLeastGain) break;
    cause.lead += gain;
    const SmoothField& field = fields[static_cast<size_t>(best - functions.begin())];
    const auto names = names_of(field);
    if (std::find(cause.depends_on.begin(), cause.depends_on.end(), names) ==
        cause.depends_on.end())
      cause.depends_on.push_back(names);
    rest_ = best->left_of(columns_in(field).values, rest_);
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

std::shared_ptr<const CauseBeside> known_beside(const Problem& problem,
                                                const Assessment& assessment,
                                                const KnownCauses& known) {
  return known.of(0, key_of(problem, assessment), [&] { return best_beside(problem, assessment); });
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
  out.beside = known_beside(problem, assessment, known);
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
                                          double material, const KnownCauses& known) {
  const Explanation& last = explanations.back();
  const Compared at_last = compared(problem, last, known);
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

std::vector<TriedFunction> tried_beside(const Problem& problem, const Assessment& explanation,
                                        const KnownCauses& known) {
  return known_beside(problem, explanation, known)->tried;
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
