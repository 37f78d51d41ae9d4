// Kind `photometry`: stacks of flat fields and dark frames.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>

#include "effects/stages/sensor/sensor.h"
#include "effects/stages/timing.h"
#include "measurement/kinds/kinds.h"
#include "measurement/kinds/photometry/photometry_problem.h"
#include "measurement/kinds/photometry/stack/emva.h"
#include "measurement/kinds/photometry/structure/photometry_neighbour_tests.h"
#include "measurement/kinds/photometry/structure/photometry_structure.h"
#include "measurement/numerics/maximise.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

// Predictions of a sample at a level that tests of structure and starts of fits look at: both go
// through every one of them.
constexpr double kMostForTests = 2e5;
constexpr double kLeastForTests = 2048;  // Samples, however many levels there are.

// Where neighbours share noise, as behind a filter in the camera, the variance of single pixels is
// not that of their electrons: a note says so where that moves the gain by more than its own error,
// and where it moves it far, what the standard makes of that variance is left out.
void doubt_shared_noise(const NoiseLikeness& noise, Facts& facts) {
  constexpr double kFar = 1.25;
  // A filter whose weights sum to one divides the variance by the sum of the correlations that it
  // makes between a pixel and all others: of that sum these are the part of the next ones.
  const double by = std::max((1 + 2 * noise.along_rows) * (1 + 2 * noise.along_columns), 0.1);
  const double off = std::max(by, 1 / by);
  const Figure& gain = facts.figures.figures.front();
  if (off - 1 < gain.sigma / gain.value) return;
  const std::string size =
      off > kFar ? fmt::format("{:.1f} times", off) : fmt::format("{:.0f} %", 100 * (off - 1));
  facts.notes.push_back(fmt::format(
      "{}: noise is alike in neighbouring pixels (it correlates by {:.2f} along rows, by {:.2f} "
      "along columns), as a filter in the camera makes it: the gain K comes out some {} too {}{}; "
      "take raw images, without the camera's own processing, or a model with the filter (seam "
      "discover finds mild ones), whose K is that of the noise before it",
      facts.figures.title, noise.along_rows, noise.along_columns, size, by > 1 ? "small" : "large",
      off > kFar ? ", so that figures that rest on noise are left out"
                 : ", and what rests on it is off by as much, beyond the errors that are stated"));
  if (off > kFar) facts.figures = without_noise(std::move(facts.figures));
}

}  // namespace

PhotometryProblem::PhotometryProblem(const MeasurementSet& set)
    : data_(read_photometry(set, facts_)) {
  set_noise_dn_ = facts_.channels[0].noise;
  data_.least_at_top_dn2 = least_at_top(data_, *sums(all_groups()));
  data_.least_at_bottom_dn2 = least_at_bottom(data_, *sums(all_groups()));
  if (data_.channels != 3) facts_.set.lacks.push_back({effects::Need::colour, ""});
  const bool lit =
      std::any_of(data_.levels.begin(), data_.levels.end(),
                  [](const PhotometryLevel& level) { return !(level.illumination == 0); });
  if (!lit) facts_.set.lacks.push_back({effects::Need::light, "no frame has light"});
  const double values = static_cast<double>(data_.samples() * data_.levels.size());
  if (values > kMostForTests) {
    const double most =
        std::max(kLeastForTests, kMostForTests / static_cast<double>(data_.levels.size()));
    thinning_ = thinning_of(data_.width_px, data_.height_px, data_.channels, most);
    small_ = std::make_unique<const PhotometryData>(thinned(data_, thinning_));
  }
  noise_ = noise_likeness({data_, *sums(all_groups())});
  if (noise_is_shared() && !facts_.figures.figures.empty()) doubt_shared_noise(noise_, facts_);
  if (data_.channels > 1) channels_share_ = channels_share_offsets(data_, *sums(all_groups()));
}

std::shared_ptr<const PhotometrySums> PhotometryProblem::sums(const Groups& groups,
                                                              bool small) const {
  const std::scoped_lock lock(mutex_);
  small = small && small_ != nullptr;
  for (const auto& [key, value] : cache_) {
    if (key == std::pair(groups, small)) return value;
  }
  auto value = std::make_shared<const PhotometrySums>(
      sum_frames(small ? *small_ : data_, groups, facts_.group_of_row));
  if (cache_.size() > 6) cache_.erase(cache_.begin());
  cache_.emplace_back(std::pair(groups, small), value);
  return value;
}

bool PhotometryProblem::noise_is_shared() const {
  constexpr double kSure = 1e-4;  // Of ten thousand sets one is doubted by chance.
  return noise_.p_value < kSure;
}

// Photometry has scores, fits and structures of its own; there are no residual vectors.
Evaluation PhotometryProblem::evaluate(const Model&, const Groups&, const Evaluation*) const {
  Evaluation none;
  none.valid = false;
  return none;
}

Score PhotometryProblem::score(const Model& model, const Groups& groups) const {
  const HeldView held = view_of(model, groups);
  const PhotometryData& data = held.view.data;
  auto cells = cell_score(data, *held.sums, cells_, model, set_noise_dn_, channels_share_);
  PhotometryScore own =
      cells ? std::move(*cells)
            : score_photometry(data, *held.sums, predict(data, *held.sums, model, set_noise_dn_),
                               channels_share_);
  const double of_frame = held.view.log_mixing * static_cast<double>(data.samples());
  for (const LevelSums& level : held.sums->levels) {
    for (const int frame : level.frames)
      own.by_frame[static_cast<size_t>(frame)] -= of_frame, own.log_likelihood -= of_frame;
  }
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

std::vector<std::vector<double>> PhotometryProblem::starts(const Model& model,
                                                           const EffectDefinition& effect) const {
  const HeldView small = view_of(model, training_groups(), true),
                 whole = view_of(model, training_groups());
  return photometry_starts(small.view, whole.view, model, effect, noise_);
}

std::vector<Groups> PhotometryProblem::regimes() const {
  const Groups none(facts_.groups.size(), 0);
  std::vector<Groups> regimes(data_.levels.size() + 1, none);
  for (size_t level = 0; level < data_.levels.size(); ++level) {
    for (const int frame : data_.levels[level].frames) {
      const auto group = static_cast<size_t>(facts_.group_of_row[static_cast<size_t>(frame)]);
      regimes[level][group] = 1;
      if (data_.levels[level].illumination == 0) regimes.back()[group] = 1;
    }
  }
  return regimes;
}

double PhotometryProblem::looks(const Model& model, const EffectDefinition& effect) const {
  using effects::StartSearch;
  const StartSearch search = effects::start_rule(effect, facts_.set.kind).search;
  if (search == StartSearch::frequency)
    return effect.stage == effects::Stage::sensor ? wave_looks(data_) : flicker_looks(data_, model);
  if (search == StartSearch::converter_bits)
    return std::max(1, data_.file_bits - data_.fewest_bits);
  return Problem::looks(model, effect);
}

std::vector<Figure> PhotometryProblem::figures(const Model& model) const {
  const effects::SensorChain chain = effects::sensor_of(model);
  // Where a filter was found, the noise before it says what the standard's figures cannot.
  if (!has_system_gain(facts_.figures) && !chain.mixing.acts()) return {};
  const auto gain = emva_gain(data_, chain);
  if (!gain) return {};
  return {{.name = "K of the model", .unit = "DN/e-", .value = *gain}};
}

void PhotometryProblem::check_model(const Model& model) const {
  if (!effects::has_base(model, effects::Base::response)) {
    throw InputError(
        fmt::format("model '{}': {} is missing: a photometry set needs gain_dn and black_dn",
                    model.name(), effects::base_name(effects::Base::response)));
  }
  const effects::ModelEffect& response = *effects::base_of(model, effects::Base::response);
  const bool is_fitted = std::any_of(response.parameters.begin(), response.parameters.end(),
                                     [](const auto& value) { return value.refitted(); });
  if (!is_fitted && effects::sensor_of(model).is_cubic() &&
      predict(data_, *sums(all_groups()), model, set_noise_dn_).falls)
    throw InputError(
        fmt::format("model '{}': its response bends so far that more light gives lower values "
                    "within the light of this set",
                    model.name()));
}

std::vector<Structure> PhotometryProblem::structure(const Model& model, const Groups& groups,
                                                    int) const {
  return photometry_structure(view_of(model, groups, true).view, model);
}

const Problem& PhotometryProblem::with_residuals() const {
  std::call_once(means_made_, [&] {
    const MeanSource whole{data_, sums(all_groups())},
        quick{small_ ? *small_ : data_, sums(all_groups(), true)};
    means_ = std::make_unique<const PhotometryMeans>(whole, quick, facts_, set_noise_dn_,
                                                     channels_share_);
  });
  return *means_;
}

std::vector<char> PhotometryProblem::find_outliers(const Model&) const {
  return std::vector<char>(facts_.scalars(), 0);
}

std::string PhotometryProblem::no_outliers_because() const {
  return "a pixel that stays odd is an effect (hot_pixels, pixel_gain_spread), and one odd value "
         "among many frames is lost in its pixel's mean";
}

namespace {

// Between exposures that are more alike, a pattern that grows with them is one that stays.
bool has_unlike_exposures(const PhotometryData& data) {
  constexpr double kUnlike = 1.5;
  const auto [shortest, longest] = std::minmax_element(
      data.levels.begin(), data.levels.end(),
      [](const PhotometryLevel& a, const PhotometryLevel& b) { return a.dark_s() < b.dark_s(); });
  return shortest != data.levels.end() && longest->dark_s() > kUnlike * shortest->dark_s();
}

}  // namespace

std::string PhotometryProblem::not_testable(const Model& model, const EffectDefinition& effect,
                                            size_t parameter) const {
  const effects::Parameter& definition = effect.parameters[parameter];
  if (definition.integer) return "";
  const std::string why = Problem::not_testable(model, effect, parameter);
  // A frequency is sought over all that the rows can tell: no step beside its start says more.
  if (!why.empty() ||
      effects::start_rule(effect, facts_.set.kind).search == effects::StartSearch::frequency)
    return why;
  const effects::SensorChain alone = chain_of(effect);
  if (alone.mixing.acts() && !noise_is_shared())
    return "noise of neighbouring pixels is independent";
  if (alone.dark_sigma_dn_per_s > 0 && !has_unlike_exposures(data_))
    return "all frames have nearly the same exposure time";
  const double here = model.find(effect.name)->parameters[parameter].value;
  const auto likelihood = [&](const Model& one) {
    return log_likelihood(view_of(one, training_groups()).view, one);
  };
  const double now = likelihood(model);
  // A typical step, and a good part of the way to neutral: scales are made for 8 bits, and near an
  // optimum small steps change nothing.
  for (const double size : {0.1 * definition.scale, 0.5 * (here - definition.neutral)}) {
    if (!std::isfinite(size) || size == 0) continue;
    Model other = model;
    other.set_value(effect.name, parameter,
                    here + size <= definition.max ? here + size : here - size);
    if (std::abs(likelihood(other) - now) >= 1e-3) return "";
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
