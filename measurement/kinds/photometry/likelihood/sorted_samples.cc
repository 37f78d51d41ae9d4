// Sorting the samples of a photometry set into cells of light.
#include <algorithm>

#include "measurement/kinds/photometry/likelihood/cell_sums.h"
#include "measurement/kinds/photometry/likelihood/photometry_cells.h"

namespace seam::measurement {
namespace {

// With more levels than this products of all pairs are kept for uniform light alone, and cells are
// wide: within a cell the mean is linear in the light.
constexpr size_t kFewLevels = 24;
constexpr double kCellsOfMany = 64;

// Cells a sixteenth of a DN wide in an image of 256 DN: as fine as the tables of the sensor's
// response.
size_t cells_for(double least, double most, size_t levels, bool by_wave) {
  if (!(most > least)) return 1;
  const double finest = levels > kFewLevels || by_wave ? kCellsOfMany : 1024;
  return static_cast<size_t>(std::clamp(4096 * (most - least) / most, 32.0, finest));
}

// Steps of the wave within each step of the light, where it is cut off.
constexpr size_t kWaveSteps = 64;

// Provisional cells of each channel: steps of equal width in the light, and of the wave in each.
struct LightSteps {
  std::vector<size_t> first;  // By channel, and one more.
  std::vector<double> width;  // By channel; 0 where there is one.
  std::vector<double> least;  // By channel.
};

LightSteps steps_of_light(const std::vector<double>& light, size_t channels, size_t levels,
                          bool by_wave) {
  LightSteps steps{.first = std::vector<size_t>(channels + 1, 0),
                   .width = std::vector<double>(channels, 0),
                   .least = std::vector<double>(channels, 1e300)};
  std::vector<double> most(channels, -1e300);
  for (size_t i = 0; i < light.size(); ++i) {
    const size_t c = i % channels;
    steps.least[c] = std::min(steps.least[c], light[i]), most[c] = std::max(most[c], light[i]);
  }
  for (size_t c = 0; c < channels; ++c) {
    const size_t count = cells_for(steps.least[c], most[c], levels, by_wave);
    steps.first[c + 1] = steps.first[c] + count * (by_wave ? kWaveSteps : 1);
    if (count > 1) steps.width[c] = (most[c] - steps.least[c]) / static_cast<double>(count);
  }
  return steps;
}

// The cells of the steps that have samples, and the cell of each sample.
void number_cells(const std::vector<double>& light, const std::vector<double>& wave,
                  size_t channels, size_t levels, SortedSamples& cells) {
  const size_t waves = wave.empty() ? 1 : kWaveSteps;
  auto [first, width, least] = steps_of_light(light, channels, levels, waves > 1);
  // Provisional numbers: channel by channel, by light.
  std::vector<uint16_t> place(light.size());
  std::vector<double> number(first.back(), 0), sum(first.back(), 0);
  for (size_t i = 0; i < light.size(); ++i) {
    const size_t c = i % channels;
    const auto step = width[c] > 0 ? static_cast<size_t>((light[i] - least[c]) / width[c]) : 0;
    const size_t own = std::min(step, (first[c + 1] - first[c]) / waves - 1);
    const size_t height =
        waves == 1 ? 0 : std::min(static_cast<size_t>(0.5 * (wave[i] + 1) * kWaveSteps), waves - 1);
    place[i] = static_cast<uint16_t>(first[c] + own * waves + height);
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
      const double mean = sum[p] / number[p];
      const double low = least[c] + width[c] * static_cast<double>((p - first[c]) / waves);
      if (waves > 1)
        cells.wave_centre.push_back(
            2 * (static_cast<double>((p - first[c]) % waves) + 0.5) / kWaveSteps - 1);
      cells.below.push_back(mean - low), cells.above.push_back(low + width[c] - mean);
    }
  }
  cells.first.push_back(cells.count());
  cells.width = std::move(width);
  cells.of_sample.resize(light.size());
  for (size_t i = 0; i < light.size(); ++i) cells.of_sample[i] = kept[place[i]];
}

// Sums over the samples of each cell, by level.
void sum_samples(const PhotometrySums& sums, SortedSamples& cells) {
  const size_t samples = cells.of_sample.size(), count = cells.count(),
               levels = sums.present.size();
  for (auto* v : {&cells.mean, &cells.scatter}) v->assign(count * levels, 0);
  for (size_t i = 0; i < samples; ++i)
    side_by_side(&cells.mean[cells.of_sample[i] * levels], levels) += means_of(sums, i);
  for (size_t k = 0; k < levels; ++k) {
    const std::vector<double>& scatter = sums.levels[sums.present[k]].scatter;
    std::vector<double> own(count, 0);
    for (size_t i = 0; i < samples; ++i) own[cells.of_sample[i]] += scatter[i];
    for (size_t cell = 0; cell < count; ++cell) cells.scatter[cell * levels + k] = own[cell];
  }
}

// Of products of a sample's means: at one level, or at all pairs of them.
void sum_products(const PhotometrySums& sums, SortedSamples& cells) {
  const size_t samples = cells.of_sample.size(), levels = sums.present.size();
  const size_t each = levels * (cells.all_products ? levels : 1);
  cells.products.assign(cells.count() * each, 0);
  for (size_t i = 0; i < samples; ++i) {
    const auto mean = means_of(sums, i);
    double* own = &cells.products[cells.of_sample[i] * each];
    if (!cells.all_products) {
      side_by_side(own, levels) += mean.cwiseAbs2();
      continue;
    }
    for (size_t k = 0; k < levels; ++k) {
      const auto first = static_cast<Eigen::Index>(k + 1);
      side_by_side(own + k * levels, k + 1) += mean[first - 1] * mean.head(first);
    }
  }
}

// Groups of samples by `place_of` (a row or a column) and cell.
template <typename F>
void group_samples(const SortedSamples& cells, size_t places, F&& place_of, SampleGroups& groups) {
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
  groups.samples.assign(groups.count(), 0);
  for (const uint32_t own : groups.of_sample) groups.samples[own] += 1;
}

void sum_groups(const PhotometrySums& sums, SampleGroups& groups) {
  const size_t levels = sums.present.size();
  groups.mean.assign(groups.count() * levels, 0);
  for (size_t i = 0; i < groups.of_sample.size(); ++i)
    side_by_side(&groups.mean[groups.of_sample[i] * levels], levels) += means_of(sums, i);
  for (size_t g = 0; g < groups.count(); ++g)
    side_by_side(&groups.mean[g * levels], levels) +=
        groups.samples[g] * side_by_side(sums.reference.data(), levels);
}

}  // namespace

SortedSamples sort_samples(const PhotometryData& data, const PhotometrySums& sums,
                           const std::vector<double>& light, const std::vector<double>& wave,
                           CellNeeds needs) {
  SortedSamples cells;
  const size_t levels = sums.present.size();
  const auto channels = static_cast<size_t>(data.channels);
  number_cells(light, wave, channels, levels, cells);
  cells.all_products = needs.products && (levels <= kFewLevels || cells.count() == channels);
  sum_samples(sums, cells);
  sum_products(sums, cells);
  const auto width = static_cast<size_t>(data.width_px);
  group_samples(
      cells, static_cast<size_t>(data.height_px), [&](size_t i) { return i / channels / width; },
      cells.by_row);
  if (needs.groups) {
    group_samples(
        cells, width, [&](size_t i) { return i / channels % width; }, cells.by_column);
    sum_groups(sums, cells.by_row);
    sum_groups(sums, cells.by_column);
  }
  return cells;
}

}  // namespace seam::measurement
