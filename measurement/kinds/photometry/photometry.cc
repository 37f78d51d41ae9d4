// Kind `photometry`: stacks of flat fields and dark frames.
#include <algorithm>
#include <cmath>
#include <mutex>

#include "effects/stages/sensor/sensor.h"
#include "effects/stages/timing.h"
#include "measurement/kinds/kinds.h"
#include "measurement/kinds/photometry/photometry_problem.h"
#include "measurement/kinds/photometry/photometry_structure.h"
#include "measurement/numerics/maximise.h"
#include "sim_core/base/error.h"

namespace seam::measurement {

PhotometryProblem::PhotometryProblem(const MeasurementSet& set)
    : data_(read_photometry(set, facts_)) {
  set_noise_dn_ = facts_.channels[0].noise;
  if (data_.channels != 3) facts_.set.lacks.push_back({effects::Need::colour, ""});
  const bool lit =
      std::any_of(data_.levels.begin(), data_.levels.end(),
                  [](const PhotometryLevel& level) { return !(level.illumination == 0); });
  if (!lit) facts_.set.lacks.push_back({effects::Need::light, "no frame has light"});
  if (data_.channels > 1) channels_share_ = channels_share_offsets(data_, *sums(all_groups()));
}

std::shared_ptr<const PhotometrySums> PhotometryProblem::sums(const Groups& groups) const {
  const std::scoped_lock lock(mutex_);
  for (const auto& [key, value] : cache_) {
    if (key == groups) return value;
  }
  auto value =
      std::make_shared<const PhotometrySums>(sum_frames(data_, groups, facts_.group_of_row));
  if (cache_.size() > 8) cache_.erase(cache_.begin());
  cache_.emplace_back(groups, value);
  return value;
}

// Photometry has scores, fits and structures of its own; there are no residual vectors.
Evaluation PhotometryProblem::evaluate(const Model&, const Groups&, const Evaluation*) const {
  Evaluation none;
  none.valid = false;
  return none;
}

Score PhotometryProblem::score(const Model& model, const Groups& groups) const {
  const auto sum = sums(groups);
  const PhotometryPrediction prediction = predict(data_, *sum, model, set_noise_dn_);
  const PhotometryScore own = score_photometry(data_, *sum, prediction, channels_share_);
  Score score{.chi2 = own.chi2,
              .n = own.values,
              .nuisances = own.nuisances,
              .log_likelihood = own.log_likelihood};
  score.by_group.assign(facts_.groups.size(), 0);
  for (size_t f = 0; f < data_.frames.size(); ++f)
    score.by_group[facts_.group_of_row[f]] += own.by_frame[f];
  score.native = {std::sqrt(own.square / static_cast<double>(std::max<int64_t>(own.values, 1)))};
  score.native_sum2 = {own.square};
  score.native_count = {own.values};
  score.valid = std::isfinite(own.chi2);
  return score;
}

namespace {

bool is_logarithmic(const EffectDefinition& effect, const effects::Parameter& parameter) {
  if (parameter.min < 0) return false;
  return effect.spread_only || parameter.name == "gamma" || parameter.name == "depth";
}

}  // namespace

// What a fit on these groups left at its optimum: the model's values and which of them were sought.
std::string PhotometryProblem::optimum_key(const Model& model, const std::vector<Unknown>& unknowns,
                                           const Groups& groups) const {
  std::string key(groups.begin(), groups.end());
  for (const effects::ModelEffect& effect : model.effects()) {
    key += effect.definition->name;
    for (const double value : effect.values()) key += fmt::format(",{:a}", value);
  }
  for (const Unknown& unknown : unknowns)
    key += fmt::format(";{}.{}", unknown.effect, unknown.parameter);
  return key;
}

Fit PhotometryProblem::fit(const Model& start, const std::vector<Unknown>& unknowns,
                           const Groups& groups) const {
  // A candidate beside parameters that are at their optimum already: if it gains nothing alone, the
  // others need not move.
  const std::string candidate = unknowns.empty() ? "" : unknowns.back().effect;
  std::vector<Unknown> others, own;
  for (const Unknown& unknown : unknowns)
    (unknown.effect == candidate ? own : others).push_back(unknown);
  Model without = start;
  without.remove(candidate);
  bool beside = false;
  if (!others.empty()) {
    const std::scoped_lock lock(mutex_);
    const std::string key = optimum_key(without, others, groups);
    beside = std::find(optima_.begin(), optima_.end(), key) != optima_.end();
  }
  Fit fit;
  bool enough = false;
  if (beside) {
    const auto sum = sums(groups);
    const double base = log_likelihood(view_of(*sum), without);
    const Fit alone = fit_all(start, own, groups);
    enough = alone.log_likelihood - base < 2;
    fit = enough ? widened(alone, start, unknowns, others.size())
                 : fit_all(alone.model, unknowns, groups);
  } else {
    fit = fit_all(start, unknowns, groups);
  }
  if (!enough) {
    const std::scoped_lock lock(mutex_);
    if (optima_.size() > 200) optima_.clear();
    optima_.push_back(optimum_key(fit.model, unknowns, groups));
  }
  return fit;
}

// A fit of the last unknowns alone, with the others as they stand.
Fit PhotometryProblem::widened(const Fit& alone, const Model& start,
                               const std::vector<Unknown>& unknowns, size_t fixed) const {
  Fit fit = alone;
  fit.value.clear(), fit.sigma.clear(), fit.at_bound.clear();
  const size_t n = unknowns.size();
  fit.covariance.assign(n * n, 0);
  for (size_t i = 0; i < n; ++i) {
    const auto& value = start.find(unknowns[i].effect)->parameters[unknowns[i].parameter];
    const bool is_fixed = i < fixed;
    fit.value.push_back(is_fixed ? value.value : alone.value[i - fixed]);
    fit.sigma.push_back(is_fixed ? value.sigma.value_or(0) : alone.sigma[i - fixed]);
    fit.at_bound.push_back(is_fixed ? 0 : alone.at_bound[i - fixed]);
    fit.covariance[i * n + i] = fit.sigma[i] * fit.sigma[i];
  }
  return fit;
}

Fit PhotometryProblem::fit_all(const Model& start, const std::vector<Unknown>& unknowns,
                               const Groups& groups) const {
  const auto sum = sums(groups);
  const PhotometryView view = view_of(*sum);
  std::vector<SearchParameter> parameters;
  const double span =
      std::max(1e-3, std::abs(data_.frames.back().time_s - data_.frames.front().time_s));
  for (const Unknown& unknown : unknowns) {
    const effects::ModelEffect& effect = *start.find(unknown.effect);
    const effects::Parameter& parameter = effect.definition->parameters[unknown.parameter];
    SearchParameter search{.start = effect.parameters[unknown.parameter].value,
                           .min = parameter.min,
                           .max = parameter.max};
    search.logarithmic = is_logarithmic(*effect.definition, parameter) && search.start > 0;
    search.step = search.logarithmic ? 0.02 : 2e-3 * parameter.scale;
    // A lobe of the frequency is as narrow as the set is long.
    if (parameter.name == "frequency_hz") search.step = 0.01 / span;
    if (search.logarithmic) search.min = std::max(search.min, 1e-6 * parameter.scale);
    parameters.push_back(search);
  }
  Model model = start;
  const auto set_all = [&](const std::vector<double>& values) {
    for (size_t i = 0; i < unknowns.size(); ++i)
      model.set_value(unknowns[i].effect, unknowns[i].parameter, values[i]);
  };
  const Maximum maximum = maximise(
      [&](const std::vector<double>& values) {
        set_all(values);
        return log_likelihood(view, model);
      },
      parameters);
  set_all(maximum.value);
  return {.model = model,
          .value = maximum.value,
          .sigma = maximum.sigma,
          .at_bound = maximum.at_bound,
          .covariance = maximum.covariance,
          .log_likelihood = maximum.log_likelihood,
          .converged = maximum.converged};
}

std::vector<std::vector<double>> PhotometryProblem::starts(const Model& model,
                                                           const EffectDefinition& effect) const {
  const auto sum = sums(training_groups());
  return photometry_starts(view_of(*sum), model, effect);
}

double PhotometryProblem::looks(const Model& model, const EffectDefinition& effect) const {
  using effects::StartSearch;
  const StartSearch search = effects::start_rule(effect, facts_.set.kind).search;
  if (search == StartSearch::frequency) return flicker_looks(data_, model);
  if (search == StartSearch::converter_bits)
    return std::max(1, data_.file_bits - data_.fewest_bits);
  return Problem::looks(model, effect);
}

void PhotometryProblem::check_model(const Model& model) const {
  if (!effects::has_base(model, effects::Base::response)) {
    throw InputError(
        fmt::format("model '{}': {} is missing: a photometry set needs gain_dn and black_dn",
                    model.name(), effects::base_name(effects::Base::response)));
  }
}

std::vector<Structure> PhotometryProblem::structure(const Model& model, const Groups& groups,
                                                    int) const {
  const auto sum = sums(groups);
  return photometry_structure(view_of(*sum), model);
}

std::vector<char> PhotometryProblem::find_outliers(const Model&) const {
  return std::vector<char>(facts_.scalars(), 0);
}

std::string PhotometryProblem::no_outliers_because() const {
  return "a pixel that stays odd is an effect (hot_pixels, pixel_gain_spread), and one odd value "
         "among many frames is lost in its pixel's mean";
}

std::string PhotometryProblem::not_testable(const Model& model, const EffectDefinition& effect,
                                            size_t parameter) const {
  const effects::Parameter& definition = effect.parameters[parameter];
  if (definition.integer) return "";
  const std::string why = Problem::not_testable(model, effect, parameter);
  // A frequency is sought over all that the rows can tell: no step beside its start says more.
  if (!why.empty() ||
      effects::start_rule(effect, facts_.set.kind).search == effects::StartSearch::frequency)
    return why;
  const double here = model.find(effect.name)->parameters[parameter].value;
  const auto sum = sums(training_groups());
  const PhotometryView view = view_of(*sum);
  const double now = log_likelihood(view, model);
  // A typical step, and a good part of the way to neutral: scales are made for 8 bits, and near an
  // optimum small steps change nothing.
  for (const double size : {0.1 * definition.scale, 0.5 * (here - definition.neutral)}) {
    if (!std::isfinite(size) || size == 0) continue;
    Model other = model;
    other.set_value(effect.name, parameter,
                    here + size <= definition.max ? here + size : here - size);
    if (std::abs(log_likelihood(view, other) - now) >= 1e-3) return "";
  }
  return "it does not change the prediction of these data";
}

Kind photometry_kind() {
  return {.bit = effects::kPhotometry,
          .observations = {.file = "frames", .keys = {"file"}},
          .open = [](const MeasurementSet& set, const Instruments&) -> std::unique_ptr<Problem> {
            return std::make_unique<PhotometryProblem>(set);
          },
          .measure = [](const Model& truth, const MeasurementSet& protocol,
                        const MeasureOptions& options,
                        const Instruments&) { measure_photometry(truth, protocol, options); }};
}

}  // namespace seam::measurement
