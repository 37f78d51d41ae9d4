// Kind `frames`: whole images, predicted by rendering them.
#include "measurement/frames.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "effects/sensor.h"
#include "effects/timing.h"
#include "measurement/maximise.h"
#include "measurement/sensor_response.h"
#include "sim_core/error.h"

namespace seam::measurement {
namespace {

// A displacement that renderers may differ by: 5 x 5 rays a pixel place an edge to a hundredth.
constexpr double kRendererShiftPx = 0.01;

bool is_spread(const EffectDefinition& effect) { return effect.spread_only; }

effects::SensorExposure exposure_of(const Model& model, double t_s) {
  return {.exposure_s = effects::timing_of(model).exposure_s, .t_s = t_s, .file_bits = 8};
}

}  // namespace

FramesProblem::FramesProblem(const MeasurementSet& set)
    : table_(set.table("frames")), protocol_(set, table_), store_(protocol_) {
  const auto files = table_.texts("file");
  for (size_t row = 0; row < table_.rows(); ++row) {
    Image image = read_png(set.folder / files[row]);
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
  facts_.kind = "frames";
  facts_.kind_bit = effects::kFrames;
  facts_.title = set.title;
  facts_.fingerprint = set.fingerprint();
  facts_.file = table_.file();
  const auto noise = set.noise.find("dn");
  facts_.channels = {{.name = "dn", .noise = noise == set.noise.end() ? 0 : noise->second}};
  facts_.group_of_row = number_groups(table_.texts(table_.has(set.group) ? set.group : "frame"), facts_.groups);
  samples_ = images_.front().size();
  facts_.channel_of.assign(samples_ * images_.size(), 0);
  for (size_t row = 0; row < images_.size(); ++row) facts_.row_of.insert(facts_.row_of.end(), samples_, static_cast<int>(row));
}

std::vector<size_t> FramesProblem::frames_of(const Groups& groups) const {
  std::vector<size_t> frames;
  for (size_t f = 0; f < images_.size(); ++f) {
    if (groups[facts_.group_of_row[f]]) frames.push_back(f);
  }
  return frames;
}

Evaluation FramesProblem::evaluate(const Model& model, const Groups& groups, const Evaluation*) const {
  Evaluation out;
  const size_t n = facts_.scalars();
  out.used.assign(n, 0);
  for (auto* v : {&out.residual, &out.whitened, &out.sigma}) v->assign(n, 0);
  out.log_det.assign(facts_.groups.size(), 0);
  const std::vector<size_t> frames = frames_of(groups);
  std::vector<LightImage> light;
  try {
    light = store_.light(model, frames);
  } catch (const InputError&) {
    out.valid = false;  // No image: the lens cannot be inverted over it.
    return out;
  }
  const effects::SensorChain chain = effects::sensor_of(model);
  for (size_t k = 0; k < frames.size(); ++k) evaluate_frame(model, chain, frames[k], *light[k], out);
  return out;
}

void FramesProblem::evaluate_frame(const Model& model, const effects::SensorChain& chain, size_t frame,
                                   const std::vector<float>& light, Evaluation& out) const {
  const effects::SensorExposure exposure = exposure_of(model, facts_.time_of_row[frame]);
  float low = 1e30f, high = 0;
  for (const float value : light) low = std::min(low, value), high = std::max(high, value);
  std::vector<ResponseTable> tables;
  for (int c = 0; c < 3; ++c) {
    tables.emplace_back(chain, exposure, c, facts_.channels[0].noise, effects::signal_dn(chain, low, exposure),
                        effects::signal_dn(chain, high, exposure));
  }
  const double scale = effects::signal_dn(chain, 1, exposure);
  const size_t first = frame * samples_;
  const double offset2 = chain.pixel_offset_sigma_dn * chain.pixel_offset_sigma_dn +
                         chain.hot_fraction * (1 - chain.hot_fraction) * chain.hot_level_dn * chain.hot_level_dn;
  const double hot_mean = chain.hot_fraction * chain.hot_level_dn;
  double& log_det = out.log_det[facts_.group_of_row[frame]];
  for (size_t i = 0; i < samples_; ++i) {
    const Response response = tables[i % 3].at(scale * light[i]);
    const double gain = chain.pixel_gain_sigma * response.gain_slope;
    const double slope2 = response.offset_slope * response.offset_slope;
    const double variance = response.variance + gain * gain + offset2 * slope2;
    const size_t at = first + i;
    out.residual[at] = images_[frame][i] - response.mean - hot_mean;
    out.sigma[at] = std::sqrt(variance);
    if (left_out(at)) continue;
    out.used[at] = 1;
    out.whitened[at] = out.residual[at] / out.sigma[at];
    log_det += std::log(variance);
  }
  log_det += whiten_shared(chain, frame, out, out.whitened);
}

// Whitens what the samples of a frame share, in `values` (already over their own sigma): row noise,
// column offsets (projections that commute where the variance is even), and the renderer's own error,
// a displacement of the whole image. Returns the logarithm of the determinant.
double FramesProblem::whiten_shared(const effects::SensorChain& chain, size_t frame, const Evaluation& here,
                                    std::vector<double>& values) const {
  const size_t first = frame * samples_;
  double sigma2 = 0, log_det = 0;
  for (size_t i = 0; i < samples_; ++i) sigma2 += here.sigma[first + i] * here.sigma[first + i] / static_cast<double>(samples_);
  share(values, here.used, first, chain.row_sigma_dn * chain.row_sigma_dn / sigma2, true, log_det);
  share(values, here.used, first, chain.column_sigma_dn * chain.column_sigma_dn / sigma2, false, log_det);
  const int width = protocol_.width_px(), height = protocol_.height_px();
  const auto place = [&](int u, int v, int c) {
    return (static_cast<size_t>(std::clamp(v, 0, height - 1)) * width + std::clamp(u, 0, width - 1)) * 3 + c;
  };
  const auto predicted = [&](size_t i) { return images_[frame][i] - here.residual[first + i]; };
  std::vector<double> across(samples_), down(samples_);
  double across2 = 0, down2 = 0, both = 0;
  size_t i = 0;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      for (int c = 0; c < 3; ++c, ++i) {
        if (!here.used[first + i]) continue;
        across[i] = 0.5 * (predicted(place(u + 1, v, c)) - predicted(place(u - 1, v, c))) / here.sigma[first + i];
        down[i] = 0.5 * (predicted(place(u, v + 1, c)) - predicted(place(u, v - 1, c))) / here.sigma[first + i];
        across2 += across[i] * across[i], down2 += down[i] * down[i], both += across[i] * down[i];
      }
    }
  }
  const auto take = [&](const std::vector<double>& direction, double size2) {
    if (!(size2 > 0)) return;
    const double stretch = 1 + kRendererShiftPx * kRendererShiftPx * size2;
    double along = 0;
    for (size_t k = 0; k < samples_; ++k) along += direction[k] * values[first + k];
    const double part = (1 - 1 / std::sqrt(stretch)) * along / size2;
    for (size_t k = 0; k < samples_; ++k) values[first + k] -= part * direction[k];
    log_det += std::log(stretch);
  };
  take(across, across2);
  const double overlap = across2 > 0 ? both / across2 : 0;
  for (size_t k = 0; k < samples_; ++k) down[k] -= overlap * across[k];
  take(down, down2 - overlap * both);
  return log_det;
}

// Whitens an offset that the samples of each row (or column) share, of this relative variance.
void FramesProblem::share(std::vector<double>& values, const std::vector<char>& used, size_t first, double ratio,
                          bool rows, double& log_det) const {
  if (ratio <= 0) return;
  const auto width = static_cast<size_t>(protocol_.width_px()), height = static_cast<size_t>(protocol_.height_px());
  const size_t units = rows ? height : width, members = (rows ? width : height) * 3;
  const double stretch = 1 + ratio * static_cast<double>(members);
  const double shrink = 1 - 1 / std::sqrt(stretch);
  for (size_t unit = 0; unit < units; ++unit) {
    const auto at = [&](size_t k) {
      const size_t place = k / 3;
      return first + (rows ? unit * width + place : place * width + unit) * 3 + k % 3;
    };
    double mean = 0;
    for (size_t k = 0; k < members; ++k) mean += values[at(k)] / static_cast<double>(members);
    for (size_t k = 0; k < members; ++k) {
      if (used[at(k)]) values[at(k)] -= shrink * mean;
    }
    log_det += std::log(stretch);
  }
}

// Differences large enough that the renderer's own sampling of edges does not show: about a third
// of the noise, root mean square, on the first frame.
double FramesProblem::step_of(const Model& model, const Unknown& unknown, const Groups& groups) const {
  const std::string key = fmt::format("{}.{}", unknown.effect, unknown.parameter);
  {
    const std::scoped_lock lock(steps_mutex_);
    if (const auto known = steps_.find(key); known != steps_.end()) return known->second;
  }
  const double step = find_step(model, unknown, groups);
  const std::scoped_lock lock(steps_mutex_);
  return steps_.try_emplace(key, step).first->second;
}

double FramesProblem::find_step(const Model& model, const Unknown& unknown, const Groups& groups) const {
  const auto& parameter = model.find(unknown.effect)->definition->parameters[unknown.parameter];
  const double value = model.find(unknown.effect)->parameters[unknown.parameter].value;
  Groups one(groups.size(), 0);
  const std::vector<size_t> frames = frames_of(groups);
  if (frames.empty()) return 0;
  one[facts_.group_of_row[frames[frames.size() / 2]]] = 1;
  const Evaluation here = evaluate(model, one);
  double h = 0.02 * std::min(parameter.scale, std::max(1.0, std::abs(parameter.scale)));
  for (int attempt = 0; attempt < 3; ++attempt) {
    if (value + h > parameter.max) h = -h;
    Model moved = model;
    moved.set_value(unknown.effect, unknown.parameter, value + h);
    const Evaluation there = evaluate(moved, one);
    if (!there.valid) {
      h *= 0.1;
      continue;
    }
    double square = 0, count = 0;
    for (size_t i = 0; i < here.used.size(); ++i) {
      if (!here.used[i]) continue;
      const double d = (there.residual[i] - here.residual[i]) / here.sigma[i];
      square += d * d, count += 1;
    }
    const double rms = std::sqrt(square / std::max(count, 1.0));
    if (rms > 0.1 && rms < 1) break;
    const double most = 0.5 * (parameter.max - parameter.min);
    h = std::min(std::abs(h) * std::clamp(0.3 / std::max(rms, 1e-9), 0.02, 30.0), std::max(most, 1e-12));
  }
  return h;
}

std::vector<std::vector<double>> FramesProblem::jacobian(const Model& model, const std::vector<Unknown>& unknowns,
                                                         const Groups& groups, const Evaluation& here) const {
  std::vector<std::vector<double>> columns;
  double chi2 = 0, count = 0;
  for (size_t i = 0; i < here.used.size(); ++i) {
    if (here.used[i]) chi2 += here.whitened[i] * here.whitened[i], count += 1;
  }
  const bool far = chi2 > 2 * count;
  const std::vector<size_t> frames = frames_of(groups);
  const effects::SensorChain chain = effects::sensor_of(model);
  for (const Unknown& unknown : unknowns) {
    const auto& parameter = model.find(unknown.effect)->definition->parameters[unknown.parameter];
    const double value = model.find(unknown.effect)->parameters[unknown.parameter].value;
    double h = step_of(model, unknown, groups);
    if (value + h > parameter.max || value + h < parameter.min) h = -h;
    std::vector<double> column(facts_.scalars(), 0);
    Model moved = model;
    moved.set_value(unknown.effect, unknown.parameter, value + h);
    const Evaluation plus = evaluate(moved, groups);
    // Far from the truth one side will do.
    const bool both = !far && value - h >= parameter.min && value - h <= parameter.max;
    Evaluation minus;
    if (both) {
      moved.set_value(unknown.effect, unknown.parameter, value - h);
      minus = evaluate(moved, groups);
    }
    const bool central = both && minus.valid;
    for (size_t i = 0; i < column.size() && plus.valid; ++i) {
      if (!here.used[i]) continue;
      const double rise = central ? (plus.residual[i] - minus.residual[i]) / 2 : plus.residual[i] - here.residual[i];
      column[i] = rise / h / here.sigma[i];
    }
    for (const size_t frame : frames) whiten_shared(chain, frame, here, column);
    columns.push_back(std::move(column));
  }
  return columns;
}

std::vector<std::vector<double>> FramesProblem::starts(const Model& model, const EffectDefinition& effect) const {
  std::vector<double> start;
  for (const auto& parameter : effect.parameters) {
    double value = parameter.neutral;
    if (!std::isfinite(value)) value = parameter.name == "full_dn" ? 240 : 20 * parameter.scale;
    else if (is_spread(effect) && !parameter.integer) value += 0.3 * parameter.scale;
    else if (!parameter.integer && parameter.min >= parameter.neutral) value += 0.02 * parameter.scale;
    start.push_back(std::clamp(value, std::min(parameter.min, value), parameter.max));
  }
  if (std::any_of(effect.parameters.begin(), effect.parameters.end(), [](const auto& p) { return p.integer; })) {
    if (effect.name != "quantisation") return {};
    std::vector<std::vector<double>> choices;
    for (int bits = 4; bits < 8; ++bits) choices.push_back({static_cast<double>(bits)});
    return choices;
  }
  if (is_spread(effect)) return {start};
  // Large effects lie outside the reach of linear steps: a few sizes of each parameter are tried.
  Groups few(facts_.groups.size(), 0);
  const std::vector<size_t> training = frames_of(complement(folds().front()));
  for (size_t k = 0; k < std::min<size_t>(2, training.size()); ++k) {
    few[facts_.group_of_row[training[k * training.size() / 2]]] = 1;
  }
  const auto likelihood = [&](const std::vector<double>& values) {
    std::vector<effects::ParameterValue> given;
    for (const double value : values) given.push_back({.value = value});
    Model tried = model;
    tried.set(std::make_shared<const EffectDefinition>(effect), std::move(given));
    const Score score = Problem::score(tried, few);
    return score.valid && std::isfinite(score.log_likelihood) ? score.log_likelihood : -std::numeric_limits<double>::infinity();
  };
  std::vector<double> best = start;
  double best_value = likelihood(start) + 10;
  for (size_t i = 0; i < start.size(); ++i) {
    const auto& parameter = effect.parameters[i];
    for (const double size : {0.5, -0.5, 2.0, -2.0, 6.0, -6.0}) {
      std::vector<double> values = start;
      values[i] = (std::isfinite(parameter.neutral) ? parameter.neutral : start[i]) + size * parameter.scale;
      if (values[i] < parameter.min || values[i] > parameter.max) continue;
      const double there = likelihood(values);
      if (there > best_value) best_value = there, best = values;
    }
  }
  return {best};
}

bool FramesProblem::acts(const EffectDefinition& effect) const {
  // Spreads in time and angle have no closed form over whole images.
  if (effect.name == "frame_jitter" || effect.name == "encoder_quantisation" || effect.name == "frame_sync") return false;
  return Problem::acts(effect);
}

void FramesProblem::check_model(const Model& model) const {
  if (!model.has("pinhole") && !model.has("fisheye")) {
    throw InputError(fmt::format("model '{}': pinhole is missing: a set of frames needs a projection", model.name()));
  }
}

std::vector<char> FramesProblem::find_outliers(const Model&) const { return std::vector<char>(facts_.scalars(), 0); }

Kind frames_kind() {
  return {.name = "frames",
          .open = [](const MeasurementSet& set) -> std::unique_ptr<Problem> { return std::make_unique<FramesProblem>(set); },
          .measure = measure_frames};
}

}  // namespace seam::measurement
