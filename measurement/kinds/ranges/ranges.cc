// Kind `ranges`: distances that the robot's own algorithm measured, predicted by the whole
// simulator.
#include "measurement/kinds/ranges/ranges.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "effects/registry.h"
#include "measurement/kinds/missed_channel.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

// What a float holds of a distance, and files round to.
constexpr double kRounding_m = 2e-5;

// Expected sample standard deviation of n normal values over sigma, to 1 %.
double bias_of_spread(double n) {
  return 1 - 1 / (4 * (n - 1));
}

// What a resting robot that looks at a resting ball cannot tell.
std::vector<effects::Lack> lacks_at_rest() {
  using effects::Need;
  return {
      {Need::moving_view, "robot and ball rest: no row sees anything else at another time"},
      {Need::moving_body, "the robot stands"},
      {Need::bearings, "distances were measured, not bearings"},
      {Need::wide_view,
       "it differs from other radial effects only far from the middle of the image"},
      {Need::frame_times, "the frames have no times"},
      // A wide enough pattern would explain any misfit.
      {Need::repeated_pixels,
       "a fixed pattern shifts each place by an amount of its own, as any other error of the place "
       "does"},
      {Need::moving_joint, "the head had come to rest"},
      {Need::pan_reversals, "only the tilt moved before the head rested"},
      {Need::roll_reversals, "only the tilt moved before the head rested"},
  };
}

}  // namespace

RangesProblem::RangesProblem(const MeasurementSet& set, const Instruments& instruments)
    : data_(read_ranges(set, facts_)), simulation_(set, data_.places, instruments) {
  const double noise = set.noise_of("measured_m");
  facts_.channels = {{.name = "mean_m", .noise = noise}, {.name = "spread_m", .noise = noise}};
  facts_.set.lacks = lacks_at_rest();
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
  check_columns(model, {effects::Stage::geometry, effects::Stage::detector});
  if (!effects::has_base(model, effects::Base::projection)) {
    throw InputError(fmt::format("model '{}': {} is missing: a set of ranges needs a projection",
                                 model.name(), effects::base_name(effects::Base::projection)));
  }
}

std::string RangesProblem::not_testable(const Model& model, const EffectDefinition& effect,
                                        size_t parameter) const {
  if (data_.places.size() < 2)
    return "the ball was at one place alone: whatever changes the distance there explains it";
  return Problem::not_testable(model, effect, parameter);
}

std::vector<std::vector<double>> RangesProblem::starts(const Model& model,
                                                       const EffectDefinition& effect) const {
  const effects::StartRule& rule = effects::start_rule(effect, facts_.set.kind);
  if (rule.search == effects::StartSearch::listed) return rule.values;
  if (rule.search == effects::StartSearch::converter_bits) {
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
      if (!std::isfinite(p.neutral)) start[i] = 5 * p.scale;
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
    const ChannelMisfit misfit = misfit_of_channel(facts_, here, channel);
    if (misfit.count == 0) continue;
    std::erase_if(found, [&](const Structure& s) {
      return s.residual == name &&
             misfit.count * s.strength * s.strength < kClear * misfit.sigma2 / misfit.count;
    });
    add_missed_channel(found, name, "place", misfit, misfit.p_value(), kMissed);
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
  const std::string known = Problem::advice(a, b);
  if (!known.empty()) return known;
  const auto first = effects::find_effect(a), second = effects::find_effect(b);
  if (!first || !second || first->family != second->family) return "";
  switch (first->family) {
    case effects::Family::pointing:
      return "A resting head that always looks at the ball sees where the camera points, not why: "
             "film known points from several head angles (a set of kind points).";
    case effects::Family::brightness:
      return "Brightness reaches the distance through the colour table alone: take flat fields (a "
             "set of kind photometry).";
    case effects::Family::noise:
      return "Noise reaches the distance through a few pixels of the ball's edge: take flat fields "
             "(a set of kind photometry).";
    default:
      return "";
  }
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
