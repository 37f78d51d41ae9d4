// Kind `frames`: whole images, predicted by rendering them.
#include "measurement/kinds/frames/frames.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "effects/stages/sensor/sensor.h"
#include "effects/stages/timing.h"
#include "measurement/imaging/lens_like.h"
#include "measurement/numerics/parallel_for.h"
#include "measurement/problem/fit_key.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

effects::SensorExposure exposure_of(const Model& model, double t_s) {
  return {.exposure_s = effects::timing_of(model).exposure_s, .t_s = t_s, .file_bits = 8};
}

}  // namespace

FramesProblem::FramesProblem(const MeasurementSet& set, const Instruments& instruments)
    : table_(set.table("frames")),
      protocol_(set, table_, instruments),
      store_(light_store(Detail::fine)),
      rough_store_(light_store(Detail::rough)) {
  for (size_t row = 0; row < table_.rows(); ++row) {
    Image image = read_png(set.inside(table_, row, "file"));
    if (image.width_px != protocol_.width_px() || image.height_px != protocol_.height_px() ||
        image.channels != 3 || image.bits != 8) {
      table_.fail(row, "file",
                  fmt::format("an image of {} x {}, {} channels of {} bits", image.width_px,
                              image.height_px, image.channels, image.bits),
                  fmt::format("{} x {}, 3 channels of 8 bits", protocol_.width_px(),
                              protocol_.height_px()));
    }
    images_.push_back(std::move(image.samples));
    facts_.line_of_row.push_back(table_.line(row));
    facts_.time_of_row.push_back((protocol_.stamp(row) - protocol_.reference()).s());
  }
  facts_.set.kind = effects::kFrames;
  facts_.title = set.title;
  facts_.fingerprint = set.fingerprint();
  facts_.file = table_.file();
  facts_.channels = {{.name = "dn", .noise = set.noise_of("dn")}};
  facts_.group_of_row =
      number_groups(table_.texts(table_.has(set.group) ? set.group : "frame"), facts_.groups);
  samples_ = images_.front().size();
  facts_.channel_of.assign(samples_ * images_.size(), 0);
  for (size_t row = 0; row < images_.size(); ++row)
    facts_.row_of.insert(facts_.row_of.end(), samples_, static_cast<int>(row));
}

LightStore FramesProblem::light_store(Detail detail) const {
  return {protocol_.frames(), protocol_.width_px(), protocol_.height_px(),
          [this, detail](const Model& model, const std::vector<size_t>& frames) {
            return protocol_.render(model, frames, detail);
          }};
}

std::vector<size_t> FramesProblem::frames_of(const Groups& groups) const {
  std::vector<size_t> frames;
  for (size_t f = 0; f < images_.size(); ++f) {
    if (groups[facts_.group_of_row[f]]) frames.push_back(f);
  }
  return frames;
}

Evaluation FramesProblem::evaluate(const Model& model, const Groups& groups,
                                   const Evaluation*) const {
  return evaluate_with(store_, model, groups);
}

Evaluation FramesProblem::evaluate_with(const LightStore& store, const Model& model,
                                        const Groups& groups) const {
  const std::vector<size_t> frames = frames_of(groups);
  const effects::SensorChain chain = effects::sensor_of(model);
  Evaluation out;
  for (auto* v : {&out.residual, &out.sigma, &out.whitened}) v->assign(facts_.scalars(), 0);
  out.used.assign(facts_.scalars(), 0);
  out.log_det.assign(facts_.groups.size(), 0);
  out.valid = predict(store, model, chain, frames, [&](size_t k) {
    const size_t first = frames[k] * samples_;
    return Prediction{.residual = &out.residual[first], .variance = &out.sigma[first]};
  });
  if (out.valid) whiten(chain, frames, out);
  return out;
}

// Searches ask for the same again: what each of many effects would add to is one model.
Score FramesProblem::score(const Model& model, const Groups& groups) const {
  const std::string key = fmt::format("{};{}", times_marked(), fit_key(model, {}, groups));
  {
    const std::scoped_lock lock(scores_mutex_);
    if (const auto known = scores_.find(key); known != scores_.end()) return known->second;
  }
  const Score score = Problem::score(model, groups);
  const std::scoped_lock lock(scores_mutex_);
  return scores_.try_emplace(key, score).first->second;
}

bool FramesProblem::predict(const LightStore& store, const Model& model,
                            const effects::SensorChain& chain, const std::vector<size_t>& frames,
                            const std::function<Prediction(size_t k)>& place) const {
  std::vector<LightImage> light;
  try {
    light = store.light(model, frames);
  } catch (const InputError&) {
    return false;  // No image: the lens cannot be inverted over it.
  }
  float low = std::numeric_limits<float>::max(), high = 0;
  for (const LightImage& image : light) {
    const auto [least, most] = std::minmax_element(image->begin(), image->end());
    low = std::min(low, *least), high = std::max(high, *most);
  }
  const auto tables_at = [&](const effects::SensorExposure& exposure) {
    std::vector<ResponseTable> tables;
    for (int c = 0; c < 3; ++c) {
      tables.emplace_back(chain, exposure, c, SetNoise{facts_.channels[0].noise},
                          effects::signal_dn(chain, low, exposure),
                          effects::signal_dn(chain, high, exposure));
    }
    return tables;
  };
  const auto exposure_at = [&](size_t k) {
    return exposure_of(model, facts_.time_of_row[frames[k]]);
  };
  // Only maps of time give each frame a response of its own; a table costs as much as a frame.
  std::vector<ResponseTable> common;
  if (chain.maps.empty() && !frames.empty()) common = tables_at(exposure_at(0));
  parallel_for(frames.size(), [&](size_t k) {
    const effects::SensorExposure exposure = exposure_at(k);
    const std::vector<ResponseTable> own =
        common.empty() ? tables_at(exposure) : std::vector<ResponseTable>();
    predict_frame(chain, common.empty() ? own : common, effects::signal_dn(chain, 1, exposure),
                  frames[k], *light[k], place(k));
  });
  return true;
}

void FramesProblem::predict_frame(const effects::SensorChain& chain,
                                  const std::vector<ResponseTable>& tables, double scale,
                                  size_t frame, const std::vector<float>& light,
                                  const Prediction& out) const {
  const double offset2 =
      chain.pixel_offset_sigma_dn * chain.pixel_offset_sigma_dn +
      chain.hot_fraction * (1 - chain.hot_fraction) * chain.hot_level_dn * chain.hot_level_dn;
  const double hot_mean = chain.hot_fraction * chain.hot_level_dn;
  for (size_t i = 0; i < samples_; ++i) {
    const Response response = tables[i % 3].at(scale * light[i]);
    out.residual[i] = images_[frame][i] - response.mean - hot_mean;
    if (!out.variance) continue;
    const double gain = chain.pixel_gain_sigma * response.gain_slope;
    const double slope2 = response.offset_slope * response.offset_slope;
    out.variance[i] = response.variance + gain * gain + offset2 * slope2;
  }
}

// Of the predicted images.
std::vector<ImageSlope> FramesProblem::slopes_of(const std::vector<size_t>& frames,
                                                 const Evaluation& here) const {
  std::vector<ImageSlope> slopes(frames.size());
  parallel_for(frames.size(), [&](size_t k) {
    std::vector<float> predicted(samples_);
    const double* residual = &here.residual[frames[k] * samples_];
    for (size_t i = 0; i < samples_; ++i)
      predicted[i] = static_cast<float>(images_[frames[k]][i] - residual[i]);
    slopes[k] = image_slope(predicted, protocol_.width_px(), protocol_.height_px());
  });
  return slopes;
}

// Adds the renderers' difference to each sample's variance, then whitens what samples share.
void FramesProblem::whiten(const effects::SensorChain& chain, const std::vector<size_t>& frames,
                           Evaluation& out) const {
  constexpr double shift2 = kRendererShiftPx * kRendererShiftPx;
  std::vector<ImageSlope> slopes = slopes_of(frames, out);
  std::vector<double> log_det_of(frames.size(), 0);
  parallel_for(frames.size(), [&](size_t k) {
    const size_t first = frames[k] * samples_;
    double log_det = 0;
    double product = 1;  // One logarithm for a few variances, of at most 255^2 each.
    for (size_t i = 0; i < samples_; ++i) {
      const double right = slopes[k].right[i], down = slopes[k].down[i];
      double& sigma = out.sigma[first + i];
      const double variance = sigma + shift2 * (right * right + down * down);
      sigma = std::sqrt(variance);
      if (left_out(first + i)) continue;
      out.used[first + i] = 1;
      out.whitened[first + i] = out.residual[first + i] / sigma;
      product *= variance;
      if (product > 1e100 || product < 1e-100) log_det += std::log(std::exchange(product, 1.0));
    }
    log_det_of[k] = log_det + std::log(product);
  });
  auto errors = std::make_shared<const FrameErrors>(protocol_.width_px(), protocol_.height_px(),
                                                    chain, frames, std::move(slopes), out);
  errors->whiten(out.whitened);
  for (size_t k = 0; k < frames.size(); ++k)
    out.log_det[facts_.group_of_row[frames[k]]] += log_det_of[k] + errors->log_det(k);
  out.reusable = std::move(errors);
}

// Differences large enough that the renderer's own sampling of edges does not show: about a third
// of the noise, root mean square, on the first frame.
double FramesProblem::step_of(const Model& model, const Unknown& unknown,
                              const Groups& groups) const {
  const std::string key = fmt::format("{}.{}", unknown.effect, unknown.parameter);
  {
    const std::scoped_lock lock(steps_mutex_);
    if (const auto known = steps_.find(key); known != steps_.end()) return known->second;
  }
  const double step = find_step(model, unknown, groups);
  const std::scoped_lock lock(steps_mutex_);
  return steps_.try_emplace(key, step).first->second;
}

double FramesProblem::find_step(const Model& model, const Unknown& unknown,
                                const Groups& groups) const {
  const auto& parameter = model.find(unknown.effect)->definition->parameters[unknown.parameter];
  const double value = model.find(unknown.effect)->parameters[unknown.parameter].value;
  Groups one(groups.size(), 0);
  const std::vector<size_t> frames = frames_of(groups);
  if (frames.empty()) return 0;
  one[facts_.group_of_row[frames[frames.size() / 2]]] = 1;
  const std::vector<size_t> chosen = frames_of(one);
  const Evaluation here = evaluate(model, one);
  std::vector<double> there(samples_);
  double h = 0.02 * std::min(parameter.scale, std::max(1.0, std::abs(parameter.scale)));
  double coarse = 0;  // A step that changes much.
  for (int attempt = 0; attempt < 3; ++attempt) {
    if (value + h > parameter.max) h = -h;
    Model moved = model;
    moved.set_value(unknown.effect, unknown.parameter, value + h);
    if (!predict_means(moved, chosen, there)) {
      h *= 0.1;
      continue;
    }
    double square = 0, count = 0;
    for (size_t i = 0; i < samples_; ++i) {
      const size_t at = chosen.front() * samples_ + i;
      if (!here.used[at]) continue;
      const double d = (there[i] - here.residual[at]) / here.sigma[at];
      square += d * d, count += 1;
    }
    const double rms = std::sqrt(square / std::max(count, 1.0));
    if (rms > 0.1 && rms < 1) break;
    // Rounding hides smaller ones: a limit of clipped samples.
    if (rms < 1e-9 && coarse > 0) return coarse;
    if (rms >= 1) coarse = std::abs(h);
    const double most = 0.5 * (parameter.max - parameter.min);
    h = std::min(std::abs(h) * std::clamp(0.3 / std::max(rms, 1e-9), 0.02, 30.0),
                 std::max(most, 1e-12));
  }
  // What bends the image's corners alone changes few samples, and those by more than an edge is
  // wide.
  constexpr double kMostBend_px = 0.5;
  Model moved = model;
  moved.set_value(unknown.effect, unknown.parameter, std::min(value + h, parameter.max));
  const double bend_px =
      lens_difference_px(model, moved, protocol_.width_px(), protocol_.height_px());
  return bend_px > kMostBend_px ? h * kMostBend_px / bend_px : h;
}

std::vector<std::vector<double>> FramesProblem::jacobian(const Model& model,
                                                         const std::vector<Unknown>& unknowns,
                                                         const Groups& groups,
                                                         const Evaluation& here) const {
  std::vector<std::vector<double>> columns;
  if (!here.valid) return {unknowns.size(), std::vector<double>(facts_.scalars(), 0)};
  const bool far = mean_square(here) > 2;
  const std::vector<size_t> frames = frames_of(groups);
  const FrameErrors& errors = *static_cast<const FrameErrors*>(here.reusable.get());
  std::vector<double> plus(frames.size() * samples_), minus(plus.size());
  for (const Unknown& unknown : unknowns) {
    const auto& parameter = model.find(unknown.effect)->definition->parameters[unknown.parameter];
    const double value = model.find(unknown.effect)->parameters[unknown.parameter].value;
    double h = step_of(model, unknown, groups);
    if (value + h > parameter.max || value + h < parameter.min) h = -h;
    std::vector<double>& column = columns.emplace_back(facts_.scalars(), 0);
    Model moved = model;
    moved.set_value(unknown.effect, unknown.parameter, value + h);
    if (!predict_means(moved, frames, plus)) continue;
    // Far from the truth one side will do.
    const bool both = !far && value - h >= parameter.min && value - h <= parameter.max;
    moved.set_value(unknown.effect, unknown.parameter, value - h);
    const bool central = both && predict_means(moved, frames, minus);
    for (size_t k = 0; k < frames.size(); ++k) {
      for (size_t i = 0; i < samples_; ++i) {
        const size_t at = frames[k] * samples_ + i, near = k * samples_ + i;
        if (!here.used[at]) continue;
        const double rise =
            central ? (plus[near] - minus[near]) / 2 : plus[near] - here.residual[at];
        column[at] = rise / h / here.sigma[at];
      }
    }
    errors.whiten(column);
  }
  return columns;
}

// Residuals of these frames, one after another; false: no image.
bool FramesProblem::predict_means(const Model& model, const std::vector<size_t>& frames,
                                  std::vector<double>& residual) const {
  return predict(store_, model, effects::sensor_of(model), frames,
                 [&](size_t k) { return Prediction{.residual = &residual[k * samples_]}; });
}

// Groups of `count` training frames, evenly spread.
Groups FramesProblem::some_training_frames(size_t count) const {
  Groups groups(facts_.groups.size(), 0);
  const std::vector<size_t> training = frames_of(training_groups());
  count = std::min(count, training.size());
  for (size_t k = 0; k < count; ++k)
    groups[facts_.group_of_row[training[k * training.size() / count]]] = 1;
  return groups;
}

std::optional<Groups> FramesProblem::screening_groups() const {
  return some_training_frames(3);
}

// Two right renderers displace edges, each sample by its own amount and all by a common one, up to
// twice kRendererShiftPx. What differs by no more than that, beside an edge or on it, cannot be
// told apart, however many samples say so.
bool FramesProblem::is_visible(const Model& a, const Model& b) const {
  constexpr double kShare = 0.02;
  constexpr double kAccuracy2 = 4 * kRendererShiftPx * kRendererShiftPx;
  const Groups groups = some_training_frames(3);
  const Evaluation before = evaluate(a, groups), after = evaluate(b, groups);
  if (!before.valid || !after.valid) return true;
  const std::vector<size_t> frames = frames_of(groups);
  const std::vector<ImageSlope> slopes = slopes_of(frames, before);
  double mean_excess = 0, mean_accuracy = 0, spread_change = 0, spread_accuracy = 0;
  for (size_t k = 0; k < frames.size(); ++k) {
    const std::vector<float> square =
        steepest_nearby(slopes[k], protocol_.width_px(), protocol_.height_px());
    for (size_t i = 0; i < samples_; ++i) {
      const size_t at = frames[k] * samples_ + i;
      const double tolerance = kAccuracy2 * square[i];
      const double mean = after.residual[at] - before.residual[at];
      const double spread = after.sigma[at] * after.sigma[at] - before.sigma[at] * before.sigma[at];
      mean_excess += std::max(0.0, mean * mean - tolerance);
      mean_accuracy += tolerance;
      const double right = slopes[k].right[i], down = slopes[k].down[i];
      spread_change += std::abs(spread);
      spread_accuracy += kAccuracy2 * (right * right + down * down);
    }
  }
  // Errors at edges look like a spread of all bright samples: only the sums can be compared.
  return mean_excess > kShare * mean_accuracy || spread_change > spread_accuracy;
}

void FramesProblem::check_model(const Model& model) const {
  if (!effects::has_base(model, effects::Base::projection)) {
    throw InputError(fmt::format("model '{}': {} is missing: a set of frames needs a projection",
                                 model.name(), effects::base_name(effects::Base::projection)));
  }
}

std::vector<char> FramesProblem::find_outliers(const Model&) const {
  return std::vector<char>(facts_.scalars(), 0);
}

std::string FramesProblem::no_outliers_because() const {
  return "a pixel that stays odd is an effect (hot_pixels, pixel_gain_spread), and neighbouring "
         "pixels differ at every edge of the scene";
}

Kind frames_kind() {
  return {.bit = effects::kFrames,
          .observations = {.file = "frames", .keys = {"file"}},
          .open = [](const MeasurementSet& set,
                     const Instruments& instruments) -> std::unique_ptr<Problem> {
            return std::make_unique<FramesProblem>(set, instruments);
          },
          .measure = measure_frames};
}

}  // namespace seam::measurement
