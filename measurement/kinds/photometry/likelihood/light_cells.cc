// Sorting the samples of a photometry set into cells of light.
#include <fmt/format.h>

#include <algorithm>

#include "effects/exact_key.h"
#include "effects/stages/optics.h"
#include "measurement/kinds/photometry/likelihood/photometry_cells.h"

namespace seam::measurement {
namespace {

constexpr size_t kKept = 24;
constexpr double kMostBytes = 150e6;  // Of those that are kept.
// With more levels than this products of all pairs are kept for uniform light alone, and cells are
// wide: within a cell the mean is linear in the light.
constexpr size_t kFewLevels = 24;
constexpr double kCellsOfMany = 64;

// Cells a sixteenth of a DN wide in an image of 256 DN: as fine as the tables of the sensor's
// response.
size_t cells_for(double least, double most, size_t levels) {
  if (!(most > least)) return 1;
  const double finest = levels > kFewLevels ? kCellsOfMany : 1024;
  return static_cast<size_t>(std::clamp(4096 * (most - least) / most, 32.0, finest));
}

// What the field of light and the wave depend on.
std::string light_key(const PhotometrySums& sums, const effects::Model& model) {
  std::string key = std::to_string(sums.id);
  const effects::PatternWave wave = effects::sensor_of(model).wave;
  if (wave.amplitude_dn > 0)
    key += fmt::format(";{:a},{:a},{:a};", wave.period_px, wave.angle_rad, wave.phase_rad);
  for (const effects::ModelEffect& effect : model.effects()) {
    if (effect.definition->gain || effect.definition->optics) key += effects::exact_key(effect);
  }
  return key;
}

// Provisional cells of each channel: steps of equal width in the light.
struct LightSteps {
  std::vector<size_t> first;  // By channel, and one more.
  std::vector<double> width;  // By channel.
};

LightSteps steps_of_light(const std::vector<double>& light, size_t channels, LightCells& cells) {
  cells.least.assign(channels, 1e300), cells.most.assign(channels, -1e300);
  for (size_t i = 0; i < light.size(); ++i) {
    const size_t c = i % channels;
    cells.least[c] = std::min(cells.least[c], light[i]),
    cells.most[c] = std::max(cells.most[c], light[i]);
  }
  LightSteps steps{std::vector<size_t>(channels + 1, 0), std::vector<double>(channels, 1)};
  for (size_t c = 0; c < channels; ++c) {
    const size_t count = cells_for(cells.least[c], cells.most[c], cells.present.size());
    steps.first[c + 1] = steps.first[c] + count;
    steps.width[c] = count > 1 ? (cells.most[c] - cells.least[c]) / static_cast<double>(count) : 1;
  }
  return steps;
}

// The cells of the steps that have samples, and the cell of each sample.
void number_cells(const std::vector<double>& light, size_t channels, LightCells& cells) {
  const auto [first, width] = steps_of_light(light, channels, cells);
  // Provisional numbers: channel by channel, by light.
  std::vector<uint16_t> place(light.size());
  std::vector<double> number(first.back(), 0), sum(first.back(), 0);
  for (size_t i = 0; i < light.size(); ++i) {
    const size_t c = i % channels;
    const auto step = static_cast<size_t>((light[i] - cells.least[c]) / width[c]);
    place[i] = static_cast<uint16_t>(first[c] + std::min(step, first[c + 1] - first[c] - 1));
    number[place[i]] += 1, sum[place[i]] += light[i];
  }
  std::vector<uint16_t> kept(first.back(), 0);
  for (size_t c = 0; c < channels; ++c) {
    cells.first.push_back(cells.count());
    for (size_t p = first[c]; p < first[c + 1]; ++p) {
      if (number[p] == 0) continue;
      kept[p] = static_cast<uint16_t>(cells.count());
      cells.channel.push_back(static_cast<int>(c));
      cells.samples.push_back(number[p]);
      cells.light.push_back(sum[p] / number[p]);
      const bool one = first[c + 1] - first[c] == 1;
      cells.low.push_back(one ? cells.least[c]
                              : cells.least[c] + width[c] * static_cast<double>(p - first[c]));
      cells.high.push_back(one ? cells.most[c] : cells.low.back() + width[c]);
    }
  }
  cells.first.push_back(cells.count());
  cells.of_sample.resize(light.size());
  for (size_t i = 0; i < light.size(); ++i) cells.of_sample[i] = kept[place[i]];
}

// How far each sample's light is from its cell's, and the mean light of the rows.
void compare_light(const PhotometryData& data, const std::vector<double>& light,
                   LightCells& cells) {
  const auto channels = static_cast<size_t>(data.channels);
  cells.row_light.assign(data.rows(), 0);
  const size_t row_samples = data.width_px * channels;
  for (size_t i = 0; i < light.size(); ++i)
    cells.row_light[i / row_samples * channels + i % channels] += light[i] / data.width_px;
  cells.offset.resize(light.size());
  cells.offset2.assign(cells.count(), 0);
  for (size_t i = 0; i < light.size(); ++i) {
    const uint16_t cell = cells.of_sample[i];
    const double offset = light[i] - cells.light[cell];
    cells.offset[i] = static_cast<float>(offset);
    cells.offset2[cell] += offset * offset;
  }
}

// The wave of amplitude 1, and what cells need of it.
void sort_wave(const PhotometryData& data, const effects::PatternWave& wave, LightCells& cells) {
  for (auto* v : {&cells.wave_sum, &cells.wave2, &cells.wave_offset}) v->assign(cells.count(), 0);
  if (!(wave.amplitude_dn > 0)) return;
  cells.wave.reserve(data.samples());
  for (int v = 0; v < data.height_px; ++v) {
    for (int u = 0; u < data.width_px; ++u) {
      const double here = wave.unit_at(data.column(u), data.row(v));
      cells.wave.insert(cells.wave.end(), static_cast<size_t>(data.channels),
                        static_cast<float>(here));
    }
  }
  for (size_t i = 0; i < cells.wave.size(); ++i) {
    const size_t cell = cells.of_sample[i];
    const double w = cells.wave[i];
    cells.wave_sum[cell] += w, cells.wave2[cell] += w * w;
    cells.wave_offset[cell] += w * cells.offset[i];
  }
}

// What is summed over the samples of one cell at one level, side by side in memory.
struct CellSums {
  double mean = 0, with_offset = 0, scatter = 0, with_wave = 0, square = 0;
};

// Sums over the samples of each cell, by level: level by level, since each has its own array.
void sum_samples(const PhotometrySums& sums, LightCells& cells) {
  const size_t samples = cells.of_sample.size(), count = cells.count(),
               levels = cells.present.size();
  for (auto* v : {&cells.mean, &cells.with_offset, &cells.with_wave, &cells.scatter})
    v->assign(count * levels, 0);
  cells.products.assign(count * levels * (cells.all_products ? levels : 1), 0);
  for (size_t k = 0; k < levels; ++k) {
    const LevelSums& level = sums.levels[cells.present[k]];
    double total = 0;
    for (const double mean : level.mean) total += mean;
    const double reference = total / static_cast<double>(samples);
    cells.reference.push_back(reference);
    std::vector<CellSums> own(count);
    for (size_t i = 0; i < samples; ++i) {
      CellSums& cell = own[cells.of_sample[i]];
      const double r = level.mean[i] - reference;
      cell.mean += r;
      cell.with_offset += r * cells.offset[i];
      cell.scatter += level.scatter[i];
      if (!cells.wave.empty()) cell.with_wave += r * cells.wave[i];
      cell.square += r * r;
    }
    for (size_t c = 0; c < count; ++c) {
      const size_t at = c * levels + k;
      cells.mean[at] = own[c].mean, cells.with_offset[at] = own[c].with_offset;
      cells.scatter[at] = own[c].scatter, cells.with_wave[at] = own[c].with_wave;
      cells.products[cells.all_products ? at * levels + k : at] = own[c].square;
    }
  }
}

// Of means at different levels.
void sum_products(const PhotometrySums& sums, LightCells& cells) {
  const size_t levels = cells.present.size();
  std::vector<double> own(cells.count());
  for (size_t k = 0; k < levels; ++k) {
    const std::vector<double>& one = sums.levels[cells.present[k]].mean;
    for (size_t l = 0; l < k; ++l) {
      const std::vector<double>& other = sums.levels[cells.present[l]].mean;
      std::fill(own.begin(), own.end(), 0);
      for (size_t i = 0; i < cells.of_sample.size(); ++i)
        own[cells.of_sample[i]] += (one[i] - cells.reference[k]) * (other[i] - cells.reference[l]);
      for (size_t c = 0; c < own.size(); ++c)
        cells.products[(c * levels + k) * levels + l] = own[c];
    }
  }
}

// Groups of samples by `place_of` (a row or a column) and cell.
template <typename F>
void group_samples(const LightCells& cells, size_t places, F&& place_of, SampleGroups& groups) {
  constexpr uint32_t kNone = ~0u;
  std::vector<uint32_t> number(places * cells.count(), kNone);
  groups.of_sample.resize(cells.of_sample.size());
  for (size_t i = 0; i < cells.of_sample.size(); ++i) {
    uint32_t& own = number[place_of(i) * cells.count() + cells.of_sample[i]];
    if (own == kNone) {
      own = static_cast<uint32_t>(groups.count());
      groups.place.push_back(static_cast<uint32_t>(place_of(i)));
      groups.cell.push_back(cells.of_sample[i]);
    }
    groups.of_sample[i] = own;
  }
  for (auto* v : {&groups.samples, &groups.offset, &groups.wave}) v->assign(groups.count(), 0);
  for (size_t i = 0; i < cells.of_sample.size(); ++i) {
    const uint32_t own = groups.of_sample[i];
    groups.samples[own] += 1, groups.offset[own] += cells.offset[i];
    if (!cells.wave.empty()) groups.wave[own] += cells.wave[i];
  }
}

void sum_groups(const PhotometrySums& sums, const LightCells& cells, SampleGroups& groups) {
  const size_t levels = cells.present.size();
  groups.mean.assign(groups.count() * levels, 0);
  for (size_t k = 0; k < levels; ++k) {
    const auto& mean = sums.levels[cells.present[k]].mean;
    for (size_t i = 0; i < mean.size(); ++i)
      groups.mean[groups.of_sample[i] * levels + k] += mean[i];
  }
}

LightCells sort_samples(const PhotometryData& data, const PhotometrySums& sums,
                        const effects::Model& model, CellNeeds needs) {
  LightCells cells;
  for (size_t l = 0; l < sums.levels.size(); ++l) {
    if (!sums.levels[l].frames.empty()) cells.present.push_back(l);
  }
  const std::vector<double> light = relative_light(data, model, 0);
  const auto channels = static_cast<size_t>(data.channels);
  number_cells(light, channels, cells);
  compare_light(data, light, cells);
  sort_wave(data, effects::sensor_of(model).wave, cells);
  cells.all_products =
      needs.products && (cells.present.size() <= kFewLevels || cells.count() == channels);
  sum_samples(sums, cells);
  if (cells.all_products) sum_products(sums, cells);
  const auto width = static_cast<size_t>(data.width_px);
  group_samples(
      cells, static_cast<size_t>(data.height_px), [&](size_t i) { return i / channels / width; },
      cells.by_row);
  if (needs.groups) {
    group_samples(
        cells, width, [&](size_t i) { return i / channels % width; }, cells.by_column);
    sum_groups(sums, cells, cells.by_row);
    sum_groups(sums, cells, cells.by_column);
  }
  return cells;
}

double bytes_of(const LightCells& cells) {
  return 8.0 * static_cast<double>(cells.products.size() + 4 * cells.mean.size() +
                                   cells.of_sample.size() + cells.wave.size() / 2 +
                                   cells.by_row.mean.size() + cells.by_column.mean.size() +
                                   cells.by_row.of_sample.size());
}

}  // namespace

std::shared_ptr<const LightCells> CellStore::cells(const PhotometryData& data,
                                                   const PhotometrySums& sums,
                                                   const effects::Model& model,
                                                   CellNeeds needs) const {
  const std::string key = light_key(sums, model);
  {
    const std::scoped_lock lock(mutex_);
    const auto known = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
      return entry.key == key && (entry.needs.products || !needs.products) &&
             (entry.needs.groups || !needs.groups);
    });
    if (known != entries_.end()) {
      entries_.splice(entries_.begin(), entries_, known);
      return entries_.front().cells;
    }
  }
  auto cells = std::make_shared<const LightCells>(sort_samples(data, sums, model, needs));
  const std::scoped_lock lock(mutex_);
  entries_.push_front({key, needs, cells});
  double bytes = 0;
  size_t kept = 0;
  for (const Entry& entry : entries_) {
    bytes += bytes_of(*entry.cells);
    if (kept > 1 && (bytes > kMostBytes || kept >= kKept)) break;
    ++kept;
  }
  entries_.resize(kept);
  return cells;
}

}  // namespace seam::measurement
