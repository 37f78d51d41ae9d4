// Cells of samples under a field of light.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "effects/exact_key.h"
#include "effects/stages/optics.h"
#include "measurement/imaging/sensor_response.h"
#include "measurement/kinds/photometry/likelihood/cell_sums.h"
#include "measurement/kinds/photometry/likelihood/photometry_cells.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

bool acts_on_light(const effects::ModelEffect& effect) {
  return effect.definition->gain || effect.definition->optics;
}

// What the field of light depends on.
std::string light_key(const PhotometrySums& sums, const effects::Model& model) {
  std::string key = std::to_string(sums.id);
  for (const effects::ModelEffect& effect : model.effects()) {
    if (acts_on_light(effect)) key += effects::exact_key(effect);
  }
  return key;
}

std::string wave_key(const effects::PatternWave& wave) {
  if (!(wave.amplitude_dn > 0)) return "";
  return fmt::format(";{:a},{:a},{:a}", wave.period_px, wave.angle_rad, wave.phase_rad);
}

// The model with the parameters of its light rounded, so that fields that hardly differ have one.
effects::Model with_rounded_light(const effects::Model& model) {
  constexpr double kSteps = 4096;  // As many as cells have from dark to light.
  effects::Model rounded = model;
  for (const effects::ModelEffect& effect : model.effects()) {
    for (size_t i = 0; i < effect.parameters.size() && acts_on_light(effect); ++i) {
      rounded.set_value(effect.definition->name, i,
                        std::round(effect.parameters[i].value * kSteps) / kSteps);
    }
  }
  return rounded;
}

// A wave that hardly differs, so that all of these have one.
effects::PatternWave rounded_wave(const PhotometryData& data, effects::PatternWave wave) {
  constexpr double kSteps = 512;  // Of a cycle over the sensor: a third of a cell is high.
  const double turn = 2 * maths::kPi;
  const auto rounded = [](double x) { return std::round(x * kSteps) / kSteps; };
  const double u = rounded(maths::cos(wave.angle_rad) / wave.period_px * data.sensor_width()) /
                   data.sensor_width(),
               v = rounded(maths::sin(wave.angle_rad) / wave.period_px * data.sensor_height()) /
                   data.sensor_height();
  wave.period_px = 1 / std::max(std::hypot(u, v), 1e-9);
  wave.angle_rad = maths::atan2(v, u);
  wave.phase_rad = turn * rounded(wave.phase_rad / turn);
  return wave;
}

// The wave of amplitude 1, by sample: a sine of a sum, from the sines and cosines of its parts.
std::vector<double> unit_wave(const PhotometryData& data, const effects::PatternWave& wave) {
  effects::PatternWave sine = wave, cosine = wave, ahead = wave;
  sine.phase_rad = 0, cosine.phase_rad = maths::kPi / 2;
  ahead.phase_rad += maths::kPi / 2;
  std::vector<double> across_sine, across_cosine;
  for (int u = 0; u < data.width_px; ++u) {
    across_sine.push_back(sine.unit_at(data.column(u), 0));
    across_cosine.push_back(cosine.unit_at(data.column(u), 0));
  }
  std::vector<double> unit;
  unit.reserve(data.samples());
  for (int v = 0; v < data.height_px; ++v) {
    const double down_sine = wave.unit_at(0, data.row(v)),
                 down_cosine = ahead.unit_at(0, data.row(v));
    for (int u = 0; u < data.width_px; ++u)
      unit.insert(unit.end(), static_cast<size_t>(data.channels),
                  across_sine[u] * down_cosine + across_cosine[u] * down_sine);
  }
  return unit;
}

// Whether the wave is cut off at some level.
bool wave_is_cut_somewhere(const PhotometryData& data, const PhotometrySums& sums,
                           const effects::SensorChain& chain) {
  for (size_t l = 0; l < data.levels.size(); ++l) {
    const PhotometryLevel& level = data.levels[l];
    if (sums.levels[l].frames.empty() || std::isnan(level.illumination)) continue;
    const effects::SensorExposure exposure{.exposure_s = level.exposure_s,
                                           .exposure_ratio = level.exposure_ratio,
                                           .gain = level.gain,
                                           .file_bits = data.file_bits};
    if (is_wave_cut(chain, exposure, effects::signal_dn(chain, level.illumination, exposure)))
      return true;
  }
  return false;
}

// The samples' mean light by cell, how far each is from it, the rows' mean and the range.
void compare_light(const PhotometryData& data, const std::vector<double>& light,
                   LightCells& cells) {
  const SortedSamples& sorted = *cells.sorted;
  const auto channels = static_cast<size_t>(data.channels);
  cells.row_light.assign(data.rows(), 0);
  cells.least.assign(channels, 1e300), cells.most.assign(channels, -1e300);
  cells.light.assign(sorted.count(), 0);
  const size_t row_samples = data.width_px * channels;
  for (size_t i = 0; i < light.size(); ++i) {
    const size_t c = i % channels;
    cells.least[c] = std::min(cells.least[c], light[i]);
    cells.most[c] = std::max(cells.most[c], light[i]);
    cells.row_light[i / row_samples * channels + c] += light[i] / data.width_px;
    cells.light[sorted.of_sample[i]] += light[i];
  }
  for (size_t cell = 0; cell < sorted.count(); ++cell) cells.light[cell] /= sorted.samples[cell];
  cells.offset.resize(light.size());
  cells.offset2.assign(sorted.count(), 0);
  for (size_t i = 0; i < light.size(); ++i) {
    const uint16_t cell = sorted.of_sample[i];
    const double offset = light[i] - cells.light[cell];
    cells.offset[i] = static_cast<float>(offset);
    cells.offset2[cell] += offset * offset;
  }
}

// Whether samples stand as near to their cells' mean light as cells are wide.
bool stays_narrow(const LightCells& cells) {
  constexpr double kWidths = 2, kFinest = 4096;
  const SortedSamples& sorted = *cells.sorted;
  std::vector<double> farthest(sorted.count());
  for (size_t c = 0; c + 1 < sorted.first.size(); ++c) {
    for (size_t cell = sorted.first[c]; cell < sorted.first[c + 1]; ++cell)
      farthest[cell] = kWidths * std::max(sorted.width[c], cells.most[c] / kFinest);
  }
  for (size_t i = 0; i < cells.offset.size(); ++i) {
    // Light that is no number is not near anything.
    if (!(std::abs(cells.offset[i]) <= farthest[sorted.of_sample[i]])) return false;
  }
  return true;
}

void place_bounds(LightCells& cells) {
  const SortedSamples& sorted = *cells.sorted;
  for (size_t cell = 0; cell < sorted.count(); ++cell) {
    const auto c = static_cast<size_t>(sorted.channel[cell]);
    const bool one = sorted.width[c] == 0;
    const double low = one ? cells.least[c] : cells.light[cell] - sorted.below[cell];
    const double high = one ? cells.most[c] : cells.light[cell] + sorted.above[cell];
    cells.low.push_back(std::max(low, cells.least[c]));
    cells.high.push_back(std::min(high, cells.most[c]));
  }
}

// The wave of amplitude 1, and what cells need of it.
void sort_wave(const PhotometryData& data, const PhotometrySums& sums,
               const effects::PatternWave& wave, LightCells& cells) {
  const SortedSamples& sorted = *cells.sorted;
  for (auto* v : {&cells.wave_sum, &cells.wave2, &cells.wave_offset}) v->assign(sorted.count(), 0);
  if (!(wave.amplitude_dn > 0)) {
    cells.with_wave.assign(sorted.mean.size(), 0);
    return;
  }
  const std::vector<double> unit = unit_wave(data, wave);
  cells.wave.resize(unit.size());
  for (size_t i = 0; i < unit.size(); ++i) {
    const double centre = sorted.wave_centre.empty() ? 0 : sorted.wave_centre[sorted.of_sample[i]];
    cells.wave[i] = static_cast<float>(unit[i] - centre);
  }
  for (size_t i = 0; i < cells.wave.size(); ++i) {
    const size_t cell = sorted.of_sample[i];
    const double w = cells.wave[i];
    cells.wave_sum[cell] += w, cells.wave2[cell] += w * w;
    cells.wave_offset[cell] += w * cells.offset[i];
  }
  cells.with_wave = weighted_sums(sums, sorted, cells.wave);
}

PlaceSums sums_in(const SampleGroups& groups, const LightCells& cells) {
  PlaceSums out{std::vector<double>(groups.count(), 0), std::vector<double>(groups.count(), 0)};
  if (groups.mean.empty()) return out;
  for (size_t i = 0; i < cells.offset.size(); ++i) {
    const uint32_t own = groups.of_sample[i];
    out.offset[own] += cells.offset[i];
    if (!cells.wave.empty()) out.wave[own] += cells.wave[i];
  }
  return out;
}

double bytes_of(const SortedSamples& cells) {
  return 8.0 * static_cast<double>(cells.products.size() + 2 * cells.mean.size() +
                                   cells.of_sample.size() / 4 + cells.by_row.mean.size() +
                                   cells.by_column.mean.size() + cells.by_row.of_sample.size());
}

double bytes_of(const LightCells& cells) {
  return 8.0 * static_cast<double>(2 * cells.with_offset.size() + cells.offset.size() / 2 +
                                   cells.wave.size() / 2 + 2 * cells.in_rows.offset.size() +
                                   2 * cells.in_columns.offset.size());
}

// Those that give what is asked for and perhaps more, the plainest first.
template <typename F>
auto first_that_serves(CellNeeds needs, F&& find) {
  auto found = find(needs);
  for (const CellNeeds more :
       {CellNeeds{needs.products, true}, CellNeeds{true, needs.groups}, CellNeeds{true, true}}) {
    if (!found) found = find(more);
  }
  return found;
}

std::string with_needs(const std::string& key, CellNeeds needs) {
  return key + (needs.products ? ";products" : "") + (needs.groups ? ";groups" : "");
}

}  // namespace

std::shared_ptr<const SortedSamples> CellStore::sorted(const PhotometryData& data,
                                                       const PhotometrySums& sums,
                                                       const effects::Model& model, bool by_wave,
                                                       CellNeeds needs) const {
  const effects::PatternWave wave = rounded_wave(data, effects::sensor_of(model).wave);
  const std::string key = light_key(sums, model) + (by_wave ? wave_key(wave) : "");
  if (auto known = first_that_serves(
          needs, [&](CellNeeds more) { return sorted_.find(with_needs(key, more)); }))
    return known;
  SortedSamples own = sort_samples(data, sums, relative_light(data, model, 0),
                                   by_wave ? unit_wave(data, wave) : std::vector<double>(), needs);
  const double bytes = bytes_of(own);
  return sorted_.keep(with_needs(key, needs), std::move(own), bytes);
}

std::shared_ptr<const LightCells> CellStore::cells(const PhotometryData& data,
                                                   const PhotometrySums& sums,
                                                   const effects::Model& model, CellNeeds needs,
                                                   const effects::Model* near) const {
  const effects::SensorChain chain = effects::sensor_of(model);
  const effects::PatternWave& wave = chain.wave;
  const bool by_wave = wave_is_cut_somewhere(data, sums, chain);
  if (by_wave) near = nullptr;
  const std::string key = light_key(sums, model) + wave_key(wave) + (by_wave ? ";cut" : "") +
                          (near ? ";near " + light_key(sums, *near) : "");
  if (auto known = first_that_serves(
          needs, [&](CellNeeds more) { return lit_.find(with_needs(key, more)); }))
    return known;
  const std::vector<double> light = relative_light(data, model, 0);
  LightCells cells;
  const auto is_sorted_by = [&](const effects::Model& other) {
    cells.sorted = sorted(data, sums, other, by_wave, needs);
    compare_light(data, light, cells);
    return stays_narrow(cells);
  };
  // A parameter may be far smaller than what it is rounded to.
  if (!(near && is_sorted_by(*near)) && !is_sorted_by(with_rounded_light(model)))
    is_sorted_by(model);
  place_bounds(cells);
  cells.with_offset = weighted_sums(sums, *cells.sorted, cells.offset);
  sort_wave(data, sums, wave, cells);
  cells.in_rows = sums_in(cells.sorted->by_row, cells);
  cells.in_columns = sums_in(cells.sorted->by_column, cells);
  const double bytes = bytes_of(cells);
  return lit_.keep(with_needs(key, needs), std::move(cells), bytes);
}

}  // namespace seam::measurement
