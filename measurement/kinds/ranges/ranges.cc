// Kind `ranges`: distances that the robot's own algorithm measured, predicted by the whole
// simulator.
#include "measurement/kinds/ranges/ranges.h"

#include <algorithm>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <set>

#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

// What a float holds of a distance, and files round to.
constexpr double kRounding_m = 2e-5;

// Expected sample standard deviation of n normal values over sigma, to 1 %.
double bias_of_spread(double n) {
  return 1 - 1 / (4 * (n - 1));
}

}  // namespace

RangesProblem::RangesProblem(const MeasurementSet& set, const Instruments& instruments)
    : data_(read_ranges(set, facts_)), simulation_(set, data_.places, instruments) {
  const double noise = set.noise_of("measured_m");
  facts_.channels = {{.name = "mean_m", .noise = noise}, {.name = "spread_m", .noise = noise}};
  scatter_.assign(data_.places.size(), {});
}

void RangesProblem::place(const Model& given) {
  simulation_.look_about(given);
  std::vector<size_t> all;
  for (size_t p = 0; p < data_.places.size(); ++p) all.push_back(p);
  const auto predictions = simulation_.predict(given, all);
  for (const RangeRow& row : data_.rows) {
    if (predictions[row.place].seen > 0) continue;
    const BallPlace& at = data_.places[row.place];
    const size_t index = static_cast<size_t>(&row - data_.rows.data());
    throw InputError(fmt::format(
        "{}:{}: with model '{}' the detector sees no ball at {} m, {} rad, where one was measured",
        facts_.file, facts_.line_of_row[index], given.name(), at.true_m, at.bearing_rad));
  }
  scatter_ = simulation_.scatter(given, kPlaceAccuracy_px);
}

Evaluation RangesProblem::evaluate(const Model& model, const Groups& groups,
                                   const Evaluation*) const {
  return evaluate_smoothed(model, groups, 0);
}

Evaluation RangesProblem::evaluate_smoothed(const Model& model, const Groups& groups,
                                            double dither_px) const {
  Evaluation out;
  const size_t n = facts_.scalars();
  out.used.assign(n, 0);
  for (auto* v : {&out.residual, &out.whitened}) v->assign(n, 0);
  out.sigma.assign(n, 1);
  out.log_det.assign(facts_.groups.size(), 0);
  std::set<size_t> wanted;
  for (size_t row = 0; row < data_.rows.size(); ++row) {
    if (groups[facts_.group_of_row[row]]) wanted.insert(data_.rows[row].place);
  }
  const std::vector<size_t> places(wanted.begin(), wanted.end());
  std::vector<RangePrediction> predictions(data_.places.size());
  try {
    const auto found = simulation_.predict(model, places, dither_px);
    for (size_t i = 0; i < places.size(); ++i) predictions[places[i]] = found[i];
  } catch (const InputError&) {
    out.valid = false;  // No image: the lens cannot be inverted over it.
    return out;
  }
  for (size_t i = 0; i < n; ++i) {
    const RangeRow& row = data_.rows[facts_.row_of[i]];
    if (!groups[facts_.group_of(i)]) continue;
    const RangePrediction& p = predictions[row.place];
    if (p.seen == 0) {
      out.valid = false;
      return out;
    }
    const double noise = facts_.channels[0].noise, count = row.count;
    const double variance = p.variance_m2 + noise * noise;
    const double fourth = p.fourth_m4 + 6 * p.variance_m2 * noise * noise + 3 * std::pow(noise, 4);
    // What the sides of a place share counts for each in proportion, so that for all of them
    // together it counts once. Jumps are rare events, whose number grows with the way.
    const double way = std::max(1.0, dither_px / kPlaceAccuracy_px),
                 rounding = kRounding_m * kRounding_m;
    const RangeSimulation::Scatter& scatter = scatter_[row.place];
    double sigma2 = 0;
    if (facts_.channel_of[i] == 0) {
      out.residual[i] = row.mean_m - p.mean_m;
      sigma2 = variance / count +
               (p.own_variance_m2 + p.pattern_variance_m2 + scatter.mean_m2 * way + rounding) /
                   row.share;
    } else {
      out.residual[i] = row.spread_m - std::sqrt(variance) * bias_of_spread(count);
      const double own = variance_of_spread(p.variance_m2, p.fourth_m4, p.seen);
      sigma2 = variance_of_spread(variance, fourth, count) +
               (own + scatter.spread_m2 * way + rounding) / row.share;
    }
    out.sigma[i] = std::sqrt(sigma2);
  }
  whiten_diagonal(*this, groups, out);
  return out;
}

void RangesProblem::check_model(const Model& model) const {
  if (!model.has("pinhole") && !model.has("fisheye")) {
    throw InputError(fmt::format(
        "model '{}': pinhole is missing: a set of ranges needs a projection", model.name()));
  }
}

bool RangesProblem::acts(const EffectDefinition& effect) const {
  // Of angles: a distance measured by a resting head has no spread from the encoder's steps.
  if (effect.name == "encoder_quantisation") return false;
  return Problem::acts(effect);
}

std::string RangesProblem::not_testable(const Model&, const EffectDefinition& effect,
                                        size_t parameter) const {
  using effects::Stage;
  const std::string& name = effect.parameters[parameter].name;
  if (data_.places.size() < 2)
    return "the ball was at one place alone: whatever changes the distance there explains it";
  if (effect.stage == Stage::timing)
    return "robot and ball rest: no row sees anything else at another time";
  if (effect.stage == Stage::locomotion) return "the robot stands";
  if (effect.name == "bearing_scale" || effect.name == "bearing_noise")
    return "distances were measured, not bearings";
  if (effect.name == "fisheye")
    return "it differs from other radial effects only far from the middle of the image";
  if (effect.name == "lamp_flicker") return "the frames have no times";
  // A wide enough pattern would explain any misfit.
  if (effect.name == "pixel_gain_spread" || effect.name == "pixel_offset_spread" ||
      effect.name == "column_offsets" || effect.name == "hot_pixels")
    return "a fixed pattern shifts each place by an amount of its own, as any other error of the "
           "place does";
  if (effect.servo && effect.name != "gravity_sag" && effect.name != "backlash" &&
      effect.name != "stiction")
    return "the head had come to rest";
  if (effect.name == "backlash" && name != "tilt_width_rad")
    return "only the tilt moved before the head rested";
  return "";
}

std::vector<std::vector<double>> RangesProblem::starts(const Model& model,
                                                       const EffectDefinition& effect) const {
  if (effect.name == "quantisation") {
    std::vector<std::vector<double>> choices;
    for (int bits = 3; bits < 8; ++bits) choices.push_back({static_cast<double>(bits)});
    return choices;
  }
  if (std::all_of(effect.parameters.begin(), effect.parameters.end(),
                  [](const auto& p) { return p.integer; }))
    return {};
  auto all = Problem::starts(model, effect);
  for (auto& start : all) {
    for (size_t i = 0; i < start.size(); ++i) {
      const effects::Parameter& p = effect.parameters[i];
      if (p.integer) continue;
      if (!std::isfinite(p.neutral)) start[i] = p.name == "full_dn" ? 240 : 5 * p.scale;
      // Nothing has a slope where it begins: a blur's square, a noise's variance.
      else if (p.min >= p.neutral)
        start[i] = std::min(p.neutral + 0.3 * p.scale, p.max);
    }
  }
  if (all.size() == 2 && all[0] == all[1]) all.pop_back();
  return all;
}

// Residuals that are less than the scatter of predictions can still be smooth: no structure that
// such data could show. And those that are more at some places, without any order, are one: each
// place is tested for an offset of its own.
std::vector<Structure> RangesProblem::structure(const Model& model, const Groups& groups,
                                                int fitted) const {
  constexpr double kClear = 20;  // Of a chi-square with a few degrees of freedom.
  std::vector<Structure> found = Problem::structure(model, groups, fitted);
  const Evaluation here = evaluate(model, groups);
  for (size_t channel = 0; channel < facts_.channels.size(); ++channel) {
    const std::string& name = facts_.channels[channel].name;
    double count = 0, square = 0, chi2 = 0, residual2 = 0;
    for (size_t i = 0; i < here.used.size(); ++i) {
      if (!here.used[i] || facts_.channel_of[i] != static_cast<int>(channel)) continue;
      ++count, square += here.sigma[i] * here.sigma[i];
      chi2 += here.whitened[i] * here.whitened[i], residual2 += here.residual[i] * here.residual[i];
    }
    if (count == 0) continue;
    std::erase_if(found, [&](const Structure& s) {
      return s.residual == name && count * s.strength * s.strength < kClear * square / count;
    });
    const double p = boost::math::gamma_q(0.5 * count, 0.5 * std::min(chi2, 1200.0));
    const bool told = std::any_of(found.begin(), found.end(), [&](const Structure& s) {
      return s.residual == name && s.p_value < 1e-3;
    });
    if (p < 1e-3 && !told) {
      found.push_back({.residual = name,
                       .moment = "mean",
                       .covariate = "place",
                       .strength = std::sqrt(std::max(0.0, residual2 - square) / count),
                       .p_value = std::max(p, 1e-300)});
    }
  }
  strongest_first(facts_, found);
  return found;
}

std::vector<char> RangesProblem::find_outliers(const Model&) const {
  std::vector<char> flags;
  for (const int row : facts_.row_of) flags.push_back(data_.rows[static_cast<size_t>(row)].outlier);
  return flags;
}

std::string RangesProblem::advice(const std::string& a, const std::string& b) const {
  const auto one_of = [&](std::initializer_list<const char*> names) {
    const auto has = [&](const std::string& name) {
      return std::find(names.begin(), names.end(), name) != names.end();
    };
    return has(a) && has(b);
  };
  if (one_of({"mount_misalignment", "encoder_offset", "principal_point_offset", "gravity_sag",
              "encoder_scale", "backlash"}))
    return "A resting head that always looks at the ball sees where the camera points, not why: "
           "film known points "
           "from several head angles (a set of kind points).";
  if (one_of({"range_scale", "focal_length_error"}))
    return "Put the ball at the side too: a wrong focal length moves it in the image, a scale of "
           "the result does not.";
  if (one_of({"range_scale", "range_offset"}))
    return "Measure from near and from far: a scale grows with the distance.";
  if (one_of({"linear_response", "vignetting", "response_gamma", "white_balance", "veiling_glare",
              "saturation"}))
    return "Brightness reaches the distance through the colour table alone: take flat fields (a "
           "set of kind photometry).";
  if (one_of({"read_noise", "shot_noise", "row_noise"}))
    return "Noise reaches the distance through a few pixels of the ball's edge: take flat fields "
           "(a set of kind photometry).";
  return "";
}

Kind ranges_kind() {
  return {.bit = effects::kRanges,
          .observations = {.file = "ranges", .measured = {"measured_m"}},
          .open = [](const MeasurementSet& set,
                     const Instruments& instruments) -> std::unique_ptr<Problem> {
            return std::make_unique<RangesProblem>(set, instruments);
          },
          .measure = measure_ranges};
}

}  // namespace seam::measurement
