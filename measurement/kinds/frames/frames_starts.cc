// Where fits of effects in whole images start.
#include <algorithm>
#include <cmath>
#include <limits>

#include "effects/stages/geometry.h"
#include "measurement/imaging/converter_steps.h"
#include "measurement/imaging/lens_like.h"
#include "measurement/kinds/frames/frames.h"

namespace seam::measurement {
namespace {

// A little away from neutral, where an effect has a slope.
std::vector<double> beside_neutral(const EffectDefinition& effect) {
  std::vector<double> start;
  for (const auto& parameter : effect.parameters) {
    double value = parameter.neutral;
    if (!std::isfinite(value))
      value = 20 * parameter.scale;
    else if (effect.spread_only && !parameter.integer)
      value += 0.3 * parameter.scale;
    else if (!parameter.integer && parameter.min >= parameter.neutral)
      value += 0.02 * parameter.scale;
    start.push_back(std::clamp(value, std::min(parameter.min, value), parameter.max));
  }
  return start;
}

// Of the noise's variance.
constexpr double kLittleLeft = 1.02;

// The angle between the axis and the farthest corner of the image.
double corner_angle_rad(const Model& model, int width_px, int height_px) {
  const effects::Projection projection(model, width_px, height_px);
  double most = 0;
  for (const double u : {0, width_px - 1}) {
    for (const double v : {0, height_px - 1}) {
      const auto ray = projection.unproject(u, v);
      if (ray) most = std::max(most, std::atan2(std::hypot(ray->x, ray->y), ray->z));
    }
  }
  return most;
}

}  // namespace

std::vector<std::vector<double>> FramesProblem::starts(const Model& model,
                                                       const EffectDefinition& effect) const {
  using effects::StartSearch;
  const effects::StartRule& rule = effects::start_rule(effect, facts_.set.kind);
  if (rule.search == StartSearch::listed) return rule.values;
  if (std::all_of(effect.parameters.begin(), effect.parameters.end(),
                  [](const auto& p) { return p.integer; })) {
    if (rule.search != StartSearch::converter_bits) return {};
    std::vector<std::vector<double>> choices;
    for (int bits = std::max(4, fewest_bits(images_, 8)); bits < 8; ++bits)
      choices.push_back({static_cast<double>(bits)});
    return choices;
  }
  if (effect.replaces_base == effects::Base::projection) {
    // Another lens in the place of the model's begins where it maps as that one does.
    const int width_px = protocol_.width_px(), height_px = protocol_.height_px();
    const auto like =
        lens_like(model, effect, width_px, height_px, corner_angle_rad(model, width_px, height_px));
    return like ? std::vector<std::vector<double>>{*like} : std::vector<std::vector<double>>{};
  }
  const std::vector<double> start = beside_neutral(effect);
  if (effect.spread_only) return {start};
  if (rule.search == StartSearch::frequency) return {flicker_start(model)};
  if (rule.search == StartSearch::ceiling) return ceiling_start(model, effect);
  // Large effects lie outside the reach of linear steps: a few sizes of each parameter are tried,
  // unless so little is left of the misfit that no large one can be missing.
  const Groups few_groups = some_training_frames(2);
  const std::vector<size_t> few = frames_of(few_groups);
  const Score before = score(model, few_groups);
  if (before.valid && before.chi2 < kLittleLeft * static_cast<double>(before.n)) return {start};
  std::vector<double> best = start;
  double best_value = likelihood(model, effect, start, few) + 10;
  for (size_t i = 0; i < start.size(); ++i) {
    const auto& parameter = effect.parameters[i];
    for (const double size : {0.5, -0.5, 2.0, -2.0, 6.0, -6.0}) {
      std::vector<double> values = start;
      values[i] = (std::isfinite(parameter.neutral) ? parameter.neutral : start[i]) +
                  size * parameter.scale;
      if (values[i] < parameter.min || values[i] > parameter.max) continue;
      const double there = likelihood(model, effect, values, few);
      if (there > best_value) best_value = there, best = values;
    }
  }
  return {best};
}

double FramesProblem::likelihood(const Model& model, const EffectDefinition& effect,
                                 const std::vector<double>& values,
                                 const std::vector<size_t>& frames) const {
  std::vector<effects::ParameterValue> given;
  for (const double value : values) given.push_back({.value = value});
  Model tried = model;
  tried.set(std::make_shared<const EffectDefinition>(effect), std::move(given));
  const double found = log_likelihood(residuals_with(rough_store_, tried, frames));
  return std::isfinite(found) ? found : -std::numeric_limits<double>::infinity();
}

// A limit that the light never reaches has no slope: it is sought from the brightest sample down.
std::vector<std::vector<double>> FramesProblem::ceiling_start(
    const Model& model, const EffectDefinition& effect) const {
  const std::vector<size_t> few = frames_of(some_training_frames(2));
  double highest = 0;
  for (const size_t frame : few) {
    for (const uint16_t dn : images_[frame]) highest = std::max<double>(highest, dn);
  }
  std::vector<double> start = {highest};
  double start_value = likelihood(model, effect, start, few);
  for (const double share : {0.99, 0.97, 0.94, 0.9, 0.8, 0.7}) {
    const double there = likelihood(model, effect, {share * highest}, few);
    if (there > start_value) start_value = there, start = {share * highest};
  }
  // A limit that brings nothing anywhere is none.
  const double without = log_likelihood(residuals_with(rough_store_, model, few));
  if (start_value < without + 10) return {};
  return {start};
}

}  // namespace seam::measurement
