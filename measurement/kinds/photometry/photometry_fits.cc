// Fits of flat fields: where they start, and how noise is kept from hiding what the mean lacks.
#include <algorithm>
#include <cmath>

#include "effects/questions.h"
#include "effects/stages/sensor/sensor.h"
#include "measurement/kinds/photometry/photometry_problem.h"
#include "measurement/kinds/photometry/photometry_smooth.h"
#include "measurement/problem/fit_key.h"
#include "sim_core/base/error.h"
#include "sim_core/base/hash.h"

namespace seam::measurement {
namespace {

bool is_logarithmic(const EffectDefinition& effect, const effects::Parameter& parameter) {
  if (parameter.min < 0) return false;
  // The gain has the unit of the light, which may be any.
  if (effect.base == effects::Base::response && parameter.required) return true;
  return effect.spread_only || parameter.name == "gamma" || parameter.name == "depth";
}

// DN that an electron makes; without photon noise they are counted in DN.
double dn_per_electron(const effects::SensorChain& chain) {
  return chain.has_shot_noise() ? 1 / chain.electrons_per_dn : 1;
}

bool makes_dark(const effects::ModelEffect& effect) {
  effects::SensorChain alone;
  if (effect.definition->sensor) effect.definition->sensor(effect.values(), alone);
  return alone.dark_electrons_per_s > 0;
}

// Whether it mixes neighbours: it changes what the images are compared by.
bool mixes(const effects::ModelEffect& effect) {
  return chain_of(*effect.definition).mixing.acts();
}

// The model with as many DN of electrons that need no light as another has that says otherwise how
// many electrons make a DN: else these two would have to find each other along a bent valley, and
// noise would stand for what is wrong on the way.
Model with_dark_of(Model model, const Model& other) {
  const double times =
      dn_per_electron(effects::sensor_of(other)) / dn_per_electron(effects::sensor_of(model));
  if (times == 1) return model;
  for (const effects::ModelEffect& effect : other.effects()) {
    if (!makes_dark(effect) || !model.has(effect.definition->name)) continue;
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      const double most = effect.definition->parameters[i].max;
      model.set_value(effect.definition->name, i,
                      std::min(times * effect.parameters[i].value, most));
    }
  }
  return model;
}

constexpr size_t kMostOptima = 2000;

// A square matrix of this many rows, with rows and columns of 0 for what is added.
std::vector<double> with_more_rows(const std::vector<double>& matrix, size_t rows, size_t more) {
  std::vector<double> out(more * more, 0);
  for (size_t i = 0; i < rows; ++i)
    std::copy_n(matrix.begin() + static_cast<std::ptrdiff_t>(i * rows), rows,
                out.begin() + static_cast<std::ptrdiff_t>(i * more));
  return out;
}

}  // namespace

Fit PhotometryProblem::fit(const Model& given, const std::vector<Unknown>& unknowns,
                           const Groups& groups) const {
  // A candidate beside parameters that are at their optimum already: if it gains nothing alone, the
  // others need not move. A spread takes the place of another one, which is too wide without it.
  const std::string candidate = unknowns.empty() ? "" : unknowns.back().effect;
  std::vector<Unknown> others, own;
  for (const Unknown& unknown : unknowns)
    (unknown.effect == candidate ? own : others).push_back(unknown);
  Model without = given;
  without.remove(candidate);
  const Model start = with_dark_of(given, without);
  const auto is_spread = [&](const Unknown& unknown) {
    return start.find(unknown.effect)->definition->spread_only;
  };
  const bool shares = !own.empty() && is_spread(own.front()) &&
                      std::any_of(others.begin(), others.end(), is_spread);
  std::vector<double> curvature;
  bool beside = false;
  if (!others.empty()) {
    const std::string key = fit_key(without, others, groups);
    const std::scoped_lock lock(mutex_);
    const auto optimum = std::find_if(optima_.begin(), optima_.end(),
                                      [&](const auto& known) { return known.first == key; });
    beside = optimum != optima_.end() && !shares;
    if (optimum != optima_.end())
      curvature = with_more_rows(optimum->second, others.size(), unknowns.size());
  }
  Fit fit;
  bool enough = false;
  if (beside) {
    const double base = log_likelihood(view_of(without, groups).view, without);
    std::vector<double> own_curvature;
    const Fit alone = fit_all(start, own, groups, own_curvature);
    enough = alone.log_likelihood - base < 2;
    fit = enough ? widened(alone, unknowns, others.size())
                 : fit_all(alone.model, unknowns, groups, curvature);
  } else {
    fit = fit_all(start, unknowns, groups, curvature);
  }
  if (!own.empty() && !enough && is_spread(own.front()) && !mixes(*start.find(candidate)))
    fit = without_misfit(fit, start, unknowns, groups);
  if (!enough) {
    const std::scoped_lock lock(mutex_);
    if (optima_.size() > kMostOptima) optima_.clear();
    optima_.emplace_back(fit_key(fit.model, unknowns, groups), std::move(curvature));
  }
  return fit;
}

// A spread wide enough hides any misfit of the mean. Where the last unknowns' effect does, or one
// that was added earlier does beside it, it is given what the data say of it beside the misfit, and
// the others are fitted to that. The given model's own noise stays free.
Fit PhotometryProblem::without_misfit(const Fit& fit, const Model& start,
                                      const std::vector<Unknown>& unknowns,
                                      const Groups& groups) const {
  const std::string candidate = unknowns.back().effect;
  Model base = start;
  base.remove(candidate);
  base = with_dark_of(base, start);
  std::vector<Unknown> spreads;
  for (const Unknown& unknown : unknowns) {
    const effects::ModelEffect& effect = *start.find(unknown.effect);
    if (effect.definition->spread_only && !mixes(effect)) spreads.push_back(unknown);
  }
  std::vector<double> curvature;
  const HeldView rough = rough_view(base, groups);
  const Fit plain = fit_to([&](const Model&) { return rough; }, start, spreads, {}, curvature);
  Model model = fit.model;
  std::vector<Unknown> others;
  std::vector<size_t> place, held, told;  // Among all unknowns; what is held, among spreads.
  for (size_t i = 0, spread = 0; i < unknowns.size(); ++i) {
    const effects::ModelEffect& effect = *start.find(unknowns[i].effect);
    bool hides = false;
    if (effect.definition->spread_only && !mixes(effect)) {
      const double honest = plain.value[spread], apart = std::abs(fit.value[i] - honest);
      const bool added =
          unknowns[i].effect == candidate || !effect.parameters[unknowns[i].parameter].free;
      hides = added && apart > 0.25 * std::abs(honest) && apart > 5 * plain.sigma[spread];
      if (hides) {
        model.set_value(unknowns[i].effect, unknowns[i].parameter, honest);
        model = with_dark_of(model, fit.model);
        held.push_back(i), told.push_back(spread);
      }
      ++spread;
    }
    if (!hides) others.push_back(unknowns[i]), place.push_back(i);
  }
  if (held.empty()) return fit;
  curvature.clear();
  const Fit beside = fit_all(model, others, groups, curvature);
  Fit out = beside;
  const size_t n = unknowns.size();
  out.value.assign(n, 0), out.sigma.assign(n, 0), out.at_bound.assign(n, 0);
  out.covariance.assign(n * n, 0);
  for (size_t i = 0; i < others.size(); ++i) {
    out.value[place[i]] = beside.value[i], out.sigma[place[i]] = beside.sigma[i];
    out.at_bound[place[i]] = beside.at_bound[i];
    for (size_t k = 0; k < others.size(); ++k)
      out.covariance[place[i] * n + place[k]] = beside.covariance[i * others.size() + k];
  }
  for (size_t k = 0; k < held.size(); ++k) {
    const size_t at = held[k], from = told[k];
    out.value[at] = plain.value[from], out.sigma[at] = plain.sigma[from];
    out.at_bound[at] = plain.at_bound[from];
    out.covariance[at * n + at] = plain.sigma[from] * plain.sigma[from];
  }
  return out;
}

// A fit of the last unknowns alone, with the others as they stand.
Fit PhotometryProblem::widened(const Fit& alone, const std::vector<Unknown>& unknowns,
                               size_t fixed) const {
  Fit fit = alone;
  fit.value.clear(), fit.sigma.clear(), fit.at_bound.clear();
  const size_t n = unknowns.size();
  fit.covariance.assign(n * n, 0);
  for (size_t i = 0; i < n; ++i) {
    const auto& value = alone.model.find(unknowns[i].effect)->parameters[unknowns[i].parameter];
    const bool is_fixed = i < fixed;
    fit.value.push_back(is_fixed ? value.value : alone.value[i - fixed]);
    fit.sigma.push_back(is_fixed ? value.sigma.value_or(0) : alone.sigma[i - fixed]);
    fit.at_bound.push_back(is_fixed ? 0 : alone.at_bound[i - fixed]);
    fit.covariance[i * n + i] = fit.sigma[i] * fit.sigma[i];
  }
  return fit;
}

Fit PhotometryProblem::fit_all(const Model& start, const std::vector<Unknown>& unknowns,
                               const Groups& groups, std::vector<double>& curvature) const {
  const auto views = [&](bool small) {
    return [this, &groups, small](const Model& model) { return view_of(model, groups, small); };
  };
  const Model from = with_straight_response(views(false)(start).view, start, unknowns);
  return fit_to(views(false), from, unknowns, small_ ? views(true) : ViewsOfModels(), curvature);
}

// A response whose gain is sought begins at the straight line through the levels' means where that
// is likelier.
Model PhotometryProblem::with_straight_response(const PhotometryView& view, const Model& start,
                                                const std::vector<Unknown>& unknowns) const {
  const effects::ModelEffect* response = effects::base_of(start, effects::Base::response);
  if (response == nullptr) return start;
  const auto line = straight_response(view);
  if (!line) return start;
  const std::string& name = response->definition->name;
  Model model = start;
  bool moved = false;
  for (const Unknown& unknown : unknowns) {
    if (unknown.effect != name) continue;
    const bool is_gain = response->definition->parameters[unknown.parameter].required;
    model.set_value(name, unknown.parameter, is_gain ? line->first : line->second);
    moved = moved || is_gain;
  }
  if (!moved) return start;
  return log_likelihood(view, model) > log_likelihood(view, start) ? model : start;
}

std::vector<SearchParameter> PhotometryProblem::sought(const Model& start,
                                                       const std::vector<Unknown>& unknowns) const {
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
    const bool has_unit_of_light = effect.definition->base == effects::Base::response;
    if (search.logarithmic && !has_unit_of_light)
      search.min = std::max(search.min, 1e-6 * parameter.scale);
    parameters.push_back(search);
  }
  return parameters;
}

Fit PhotometryProblem::fit_to(const ViewsOfModels& views, const Model& start,
                              const std::vector<Unknown>& unknowns, const ViewsOfModels& first,
                              std::vector<double>& curvature) const {
  std::vector<SearchParameter> parameters = sought(start, unknowns);
  const bool seeks_dark =
      std::any_of(unknowns.begin(), unknowns.end(),
                  [&](const Unknown& unknown) { return makes_dark(*start.find(unknown.effect)); });
  const auto with = [&](const std::vector<double>& values) {
    Model model = start;
    for (size_t i = 0; i < unknowns.size(); ++i)
      model.set_value(unknowns[i].effect, unknowns[i].parameter, values[i]);
    return seeks_dark ? model : with_dark_of(std::move(model), start);
  };
  const auto find = [&](const ViewsOfModels& looks) {
    const auto likelihood = [&](const std::vector<double>& values) {
      const Model model = with(values);
      const HeldView held = looks(model);
      PhotometryView view = held.view;
      view.near = &start;
      return log_likelihood(view, model);
    };
    return maximise(likelihood, parameters, Calls::side_by_side, curvature);
  };
  // Where each look takes all samples, the way is found on the small sensor's.
  if (first && !cells_stand_for(views(start).view, start)) {
    const double more = static_cast<double>(data_.samples()) /
                        static_cast<double>(first(start).view.data.samples());
    const Maximum rough = find(first);
    for (size_t i = 0; i < parameters.size(); ++i) {
      parameters[i].start = rough.value[i];
      parameters[i].step = rough.step[i] / std::sqrt(more);
      parameters[i].step_fits = true;
    }
    curvature = rough.curvature;
  }
  Maximum maximum = find(views);
  // Where a long bent valley leaves errors beyond reason, another try has steps that fit where the
  // first one ended.
  const auto is_unsure = [&] {
    for (size_t i = 0; i < unknowns.size(); ++i) {
      const double scale =
          start.find(unknowns[i].effect)->definition->parameters[unknowns[i].parameter].scale;
      if (std::isfinite(maximum.axis_sigma[i]) &&
          maximum.axis_sigma[i] > 10 * std::max(std::abs(maximum.value[i]), scale))
        return true;
    }
    return false;
  };
  for (int more = 0; more < 2 && is_unsure(); ++more) {
    curvature.clear();
    for (size_t i = 0; i < parameters.size(); ++i) parameters[i].start = maximum.value[i];
    maximum = find(views);
  }
  curvature = maximum.curvature;
  return {.model = with(maximum.value),
          .value = maximum.value,
          .sigma = maximum.sigma,
          .at_bound = maximum.at_bound,
          .covariance = maximum.covariance,
          .log_likelihood = maximum.log_likelihood,
          .converged = maximum.converged};
}

}  // namespace seam::measurement
