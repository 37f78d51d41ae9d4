// What kind `frames` predicts of some frames and leaves of them, and how that moves with a model.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "effects/stages/sensor/sensor.h"
#include "effects/stages/timing.h"
#include "measurement/imaging/lens_like.h"
#include "measurement/kinds/frames/frames.h"
#include "measurement/numerics/parallel_for.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

effects::SensorExposure exposure_of(const Model& model, double t_s) {
  return {.exposure_s = effects::timing_of(model).exposure_s, .t_s = t_s, .file_bits = 8};
}

}  // namespace

double mean_square(const FrameResiduals& residuals) {
  double sum = 0, count = 0;
  for (size_t i = 0; i < residuals.used.size(); ++i) {
    if (residuals.used[i]) sum += residuals.whitened[i] * residuals.whitened[i], count += 1;
  }
  return residuals.errors && count > 0 ? sum / count : std::numeric_limits<double>::infinity();
}

bool FramesProblem::predict(const LightStore& store, const Model& model,
                            const effects::SensorChain& chain, const std::vector<size_t>& frames,
                            std::vector<double>& residual, std::vector<double>* variance) const {
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
  residual.resize(frames.size() * samples_);
  if (variance) variance->resize(residual.size());
  parallel_for(frames.size(), [&](size_t k) {
    const effects::SensorExposure exposure = exposure_at(k);
    const std::vector<ResponseTable> own =
        common.empty() ? tables_at(exposure) : std::vector<ResponseTable>();
    predict_frame(chain, common.empty() ? own : common, effects::signal_dn(chain, 1, exposure),
                  frames[k], *light[k], &residual[k * samples_],
                  variance ? &(*variance)[k * samples_] : nullptr);
  });
  return true;
}

void FramesProblem::predict_frame(const effects::SensorChain& chain,
                                  const std::vector<ResponseTable>& tables, double scale,
                                  size_t frame, const std::vector<float>& light, double* residual,
                                  double* variance) const {
  const double offset2 =
      chain.pixel_offset_sigma_dn * chain.pixel_offset_sigma_dn +
      chain.hot_fraction * (1 - chain.hot_fraction) * chain.hot_level_dn * chain.hot_level_dn;
  const double hot_mean = chain.hot_fraction * chain.hot_level_dn;
  for (size_t i = 0; i < samples_; ++i) {
    const Response response = tables[i % 3].at(scale * light[i]);
    residual[i] = images_[frame][i] - response.mean - hot_mean;
    if (!variance) continue;
    const double gain = chain.pixel_gain_sigma * response.gain_slope;
    const double slope2 = response.offset_slope * response.offset_slope;
    variance[i] = response.variance + gain * gain + offset2 * slope2;
  }
}

FrameResiduals FramesProblem::residuals_of(const Model& model, std::vector<size_t> frames) const {
  return residuals_with(store_, model, std::move(frames));
}

FrameResiduals FramesProblem::residuals_with(const LightStore& store, const Model& model,
                                             std::vector<size_t> frames) const {
  const effects::SensorChain chain = effects::sensor_of(model);
  FrameResiduals out{.frames = std::move(frames)};
  if (predict(store, model, chain, out.frames, out.residual, &out.sigma)) whiten(chain, out);
  return out;
}

// Of the predicted images.
std::vector<ImageSlope> FramesProblem::image_slopes_of(const FrameResiduals& here) const {
  std::vector<ImageSlope> slopes(here.frames.size());
  parallel_for(here.frames.size(), [&](size_t k) {
    std::vector<float> predicted(samples_);
    const std::vector<uint16_t>& image = images_[here.frames[k]];
    const double* residual = &here.residual[k * samples_];
    for (size_t i = 0; i < samples_; ++i) predicted[i] = static_cast<float>(image[i] - residual[i]);
    slopes[k] = image_slope(predicted, protocol_.width_px(), protocol_.height_px());
  });
  return slopes;
}

// From the sensor's variances, which stand in `sigma`: adds the renderers' difference to each, then
// whitens what samples share.
void FramesProblem::whiten(const effects::SensorChain& chain, FrameResiduals& out) const {
  constexpr double shift2 = kRendererShiftPx * kRendererShiftPx;
  std::vector<ImageSlope> slopes = image_slopes_of(out);
  out.log_det.assign(out.frames.size(), 0);
  out.used.assign(out.residual.size(), 0);
  out.whitened.assign(out.residual.size(), 0);
  parallel_for(out.frames.size(), [&](size_t k) {
    const size_t first = k * samples_, scalar = out.frames[k] * samples_;
    double product = 1;  // One logarithm for a few variances, of at most 255^2 each.
    for (size_t i = 0; i < samples_; ++i) {
      const double right = slopes[k].right[i], down = slopes[k].down[i];
      double& sigma = out.sigma[first + i];
      const double variance = sigma + shift2 * (right * right + down * down);
      sigma = std::sqrt(variance);
      if (left_out(scalar + i)) continue;
      out.used[first + i] = 1;
      out.whitened[first + i] = out.residual[first + i] / sigma;
      product *= variance;
      if (product > 1e100 || product < 1e-100)
        out.log_det[k] += std::log(std::exchange(product, 1.0));
    }
    out.log_det[k] += std::log(product);
  });
  auto errors = std::make_shared<const FrameErrors>(protocol_.width_px(), protocol_.height_px(),
                                                    chain, std::move(slopes), out.used, out.sigma);
  errors->whiten(out.whitened);
  for (size_t k = 0; k < out.frames.size(); ++k) out.log_det[k] += errors->log_det(k);
  out.errors = std::move(errors);
}

double FramesProblem::log_likelihood(const FrameResiduals& residuals) const {
  if (!residuals.errors) return -std::numeric_limits<double>::infinity();
  const double constant = std::log(2 * maths::kPi);
  double sum = 0;
  for (size_t k = 0; k < residuals.frames.size(); ++k) {
    double of_frame = 0;
    for (size_t i = k * samples_; i < (k + 1) * samples_; ++i) {
      if (!residuals.used[i]) continue;
      of_frame -= 0.5 * (residuals.whitened[i] * residuals.whitened[i] + constant);
    }
    sum += of_frame - 0.5 * residuals.log_det[k];
  }
  return sum;
}

// Differences large enough that the renderer's own sampling of edges does not show: about a third
// of the noise, root mean square, on the first frame.
double FramesProblem::step_of(const Model& model, const Unknown& unknown,
                              const std::vector<size_t>& frames) const {
  const std::string key = fmt::format("{}.{}", unknown.effect, unknown.parameter);
  {
    const std::scoped_lock lock(steps_mutex_);
    if (const auto known = steps_.find(key); known != steps_.end()) return known->second;
  }
  const double step = find_step(model, unknown, frames[frames.size() / 2]);
  const std::scoped_lock lock(steps_mutex_);
  return steps_.try_emplace(key, step).first->second;
}

double FramesProblem::find_step(const Model& model, const Unknown& unknown, size_t frame) const {
  const auto& parameter = model.find(unknown.effect)->definition->parameters[unknown.parameter];
  const double value = model.find(unknown.effect)->parameters[unknown.parameter].value;
  const FrameResiduals here = residuals_of(model, {frame});
  std::vector<double> there;
  double h = 0.02 * std::min(parameter.scale, std::max(1.0, std::abs(parameter.scale)));
  double coarse = 0;  // A step that changes much.
  for (int attempt = 0; attempt < 3; ++attempt) {
    if (value + h > parameter.max) h = -h;
    Model moved = model;
    moved.set_value(unknown.effect, unknown.parameter, value + h);
    if (!predict(store_, moved, effects::sensor_of(moved), {frame}, there, nullptr)) {
      h *= 0.1;
      continue;
    }
    double square = 0, count = 0;
    for (size_t i = 0; i < samples_; ++i) {
      if (!here.used[i]) continue;
      const double d = (there[i] - here.residual[i]) / here.sigma[i];
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

std::vector<std::vector<double>> FramesProblem::slopes_of(const Model& model,
                                                          const std::vector<Unknown>& unknowns,
                                                          const FrameResiduals& here) const {
  std::vector<std::vector<double>> columns(unknowns.size(),
                                           std::vector<double>(here.residual.size(), 0));
  if (!here.errors || here.frames.empty()) return columns;
  const bool far = mean_square(here) > 2;
  std::vector<double> plus, minus;
  for (size_t u = 0; u < unknowns.size(); ++u) {
    const std::string& effect = unknowns[u].effect;
    const size_t index = unknowns[u].parameter;
    const auto& parameter = model.find(effect)->definition->parameters[index];
    const double value = model.find(effect)->parameters[index].value;
    double h = step_of(model, unknowns[u], here.frames);
    if (value + h > parameter.max || value + h < parameter.min) h = -h;
    const auto predict_at = [&](double moved_value, std::vector<double>& residual) {
      Model moved = model;
      moved.set_value(effect, index, moved_value);
      return predict(store_, moved, effects::sensor_of(moved), here.frames, residual, nullptr);
    };
    if (!predict_at(value + h, plus)) continue;
    // Far from the truth one side will do.
    const bool both = !far && value - h >= parameter.min && value - h <= parameter.max;
    const bool central = both && predict_at(value - h, minus);
    std::vector<double>& column = columns[u];
    for (size_t i = 0; i < column.size(); ++i) {
      if (!here.used[i]) continue;
      const double rise = central ? (plus[i] - minus[i]) / 2 : plus[i] - here.residual[i];
      column[i] = rise / h / here.sigma[i];
    }
    here.errors->whiten(column);
  }
  return columns;
}

}  // namespace seam::measurement
