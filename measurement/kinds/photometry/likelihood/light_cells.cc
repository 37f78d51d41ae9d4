// Sorting the samples of a photometry set into cells of light.
#include <fmt/format.h>

#include <algorithm>

#include "effects/stages/optics.h"
#include "measurement/kinds/photometry/likelihood/photometry_cells.h"

namespace seam::measurement {
namespace {

constexpr size_t kKept = 24;

// Cells a sixteenth of a DN wide in an image of 256 DN: as fine as the tables of the sensor's
// response.
size_t cells_for(double least, double most) {
  if (!(most > least)) return 1;
  return static_cast<size_t>(std::clamp(4096 * (most - least) / most, 32.0, 1024.0));
}

// What the field of light depends on.
std::string light_key(const PhotometrySums& sums, const effects::Model& model) {
  std::string key = std::to_string(sums.id);
  for (const effects::ModelEffect& effect : model.effects()) {
    if (!effect.definition->gain && !effect.definition->optics) continue;
    key += effect.definition->name;
    for (const double value : effect.values()) key += fmt::format(",{:a}", value);
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
    const size_t count = cells_for(cells.least[c], cells.most[c]);
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

// Sums over the samples of each cell, by level.
void sum_samples(const PhotometrySums& sums, bool all_products, LightCells& cells) {
  const size_t samples = cells.of_sample.size(), count = cells.count(),
               levels = cells.present.size();
  for (auto* v : {&cells.mean, &cells.with_offset, &cells.scatter}) v->assign(count * levels, 0);
  cells.products.assign(count * levels * levels, 0);
  std::vector<const double*> means, scatters;
  for (const size_t l : cells.present) {
    double mean = 0;
    for (const double m : sums.levels[l].mean) mean += m;
    cells.reference.push_back(mean / static_cast<double>(samples));
    means.push_back(sums.levels[l].mean.data()), scatters.push_back(sums.levels[l].scatter.data());
  }
  std::vector<double> m(levels);
  for (size_t i = 0; i < samples; ++i) {
    const size_t cell = cells.of_sample[i];
    const double offset = cells.offset[i];
    double* mean = &cells.mean[cell * levels];
    double* with_offset = &cells.with_offset[cell * levels];
    double* scatter = &cells.scatter[cell * levels];
    double* product = &cells.products[cell * levels * levels];
    for (size_t k = 0; k < levels; ++k) {
      m[k] = means[k][i] - cells.reference[k];
      mean[k] += m[k];
      with_offset[k] += m[k] * offset;
      scatter[k] += scatters[k][i];
      for (size_t l = all_products ? 0 : k; l <= k; ++l) product[k * levels + l] += m[k] * m[l];
    }
  }
}

LightCells sort_samples(const PhotometryData& data, const PhotometrySums& sums,
                        const std::vector<double>& light, bool all_products) {
  LightCells cells;
  for (size_t l = 0; l < sums.levels.size(); ++l) {
    if (!sums.levels[l].frames.empty()) cells.present.push_back(l);
  }
  number_cells(light, static_cast<size_t>(data.channels), cells);
  compare_light(data, light, cells);
  sum_samples(sums, all_products, cells);
  return cells;
}

}  // namespace

std::shared_ptr<const LightCells> CellStore::cells(const PhotometryData& data,
                                                   const PhotometrySums& sums,
                                                   const effects::Model& model,
                                                   bool all_products) const {
  const std::string key = light_key(sums, model);
  {
    const std::scoped_lock lock(mutex_);
    const auto known = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
      return entry.key == key && (entry.all_products || !all_products);
    });
    if (known != entries_.end()) {
      entries_.splice(entries_.begin(), entries_, known);
      return entries_.front().cells;
    }
  }
  auto cells = std::make_shared<const LightCells>(
      sort_samples(data, sums, relative_light(data, model, 0), all_products));
  const std::scoped_lock lock(mutex_);
  entries_.push_front({key, all_products, cells});
  if (entries_.size() > kKept) entries_.pop_back();
  return cells;
}

}  // namespace seam::measurement
