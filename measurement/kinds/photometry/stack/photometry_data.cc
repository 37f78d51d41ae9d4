#include "measurement/kinds/photometry/stack/photometry_data.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim_core/base/hash.h"

namespace seam::measurement {
namespace {

// One place out of each of `count` equal parts of a line of `size` places, all of them where there
// are no more.
std::vector<int> spread_places(int size, int count, uint64_t salt) {
  std::vector<int> places;
  if (count >= size) count = size;
  for (int i = 0; i < count; ++i) {
    const auto first = static_cast<int>(static_cast<int64_t>(size) * i / count);
    const auto next = static_cast<int>(static_cast<int64_t>(size) * (i + 1) / count);
    Hasher hasher;
    hasher.add(salt);
    hasher.add(static_cast<uint64_t>(i));
    places.push_back(first +
                     static_cast<int>(hasher.digest() % static_cast<uint64_t>(next - first)));
  }
  return places;
}

void sum_level(const PhotometryData& data, LevelSums& sum) {
  const size_t samples = data.samples();
  sum.mean.assign(samples, 0);
  sum.row_mean.assign(data.rows(), 0);
  sum.scatter.assign(samples, 0);
  for (const int frame : sum.frames) {
    const auto f = static_cast<size_t>(frame);
    for (size_t i = 0; i < samples; ++i) sum.mean[i] += data.value(f, i);
    for (size_t row = 0; row < data.rows(); ++row) sum.row_mean[row] += data.row_mean[frame][row];
  }
  const double scale = 1.0 / static_cast<double>(sum.frames.size());
  for (double& mean : sum.mean) mean *= scale;
  for (double& mean : sum.row_mean) mean *= scale;
  const int channels = data.channels;
  for (const int frame : sum.frames) {
    const auto f = static_cast<size_t>(frame);
    size_t i = 0;
    for (int v = 0; v < data.height_px; ++v) {
      double shift[3];
      for (int c = 0; c < channels; ++c) {
        const size_t row = static_cast<size_t>(v) * channels + c;
        shift[c] = data.row_mean[frame][row] - sum.row_mean[row];
      }
      for (int u = 0; u < data.width_px; ++u) {
        for (int c = 0; c < channels; ++c, ++i) {
          const double rest = data.value(f, i) - sum.mean[i] - shift[c];
          sum.scatter[i] += rest * rest;
        }
      }
    }
  }
}

}  // namespace

void sum_rows(PhotometryData& data) {
  const int width = data.width_px, channels = data.channels;
  data.row_mean.clear();
  for (size_t f = 0; f < data.frame_count(); ++f) {
    std::vector<double> means(data.rows(), 0);
    size_t i = 0;
    for (int v = 0; v < data.height_px; ++v) {
      for (int u = 0; u < width; ++u) {
        for (int c = 0; c < channels; ++c)
          means[static_cast<size_t>(v) * channels + c] += data.value(f, i++);
      }
    }
    for (double& mean : means) mean /= width;
    data.row_mean.push_back(std::move(means));
  }
}

Thinning thinning_of(int width_px, int height_px, int channels, double most_samples) {
  const double whole = static_cast<double>(width_px) * height_px * channels;
  const double share = std::sqrt(std::min(1.0, most_samples / whole));
  const auto count = [&](int size) {
    return std::clamp(static_cast<int>(std::lround(share * size)), std::min(size, 16), size);
  };
  return {spread_places(width_px, count(width_px), 1),
          spread_places(height_px, count(height_px), 2)};
}

PhotometryData thinned(const PhotometryData& data, const Thinning& kept) {
  PhotometryData out = data;
  out.images.clear(), out.unmixed_images.clear();
  out.column_px.clear(), out.row_px.clear();
  out.sensor_width_px = data.sensor_width(), out.sensor_height_px = data.sensor_height();
  out.width_px = static_cast<int>(kept.column_px.size());
  out.height_px = static_cast<int>(kept.row_px.size());
  for (const int u : kept.column_px) out.column_px.push_back(data.column(u));
  for (const int v : kept.row_px) out.row_px.push_back(data.row(v));
  const auto channels = static_cast<size_t>(data.channels);
  const auto part_of = [&](const auto& image) {
    std::decay_t<decltype(image)> part;
    part.reserve(out.samples());
    for (const int v : kept.row_px) {
      for (const int u : kept.column_px) {
        const size_t at = (static_cast<size_t>(v) * data.width_px + u) * channels;
        part.insert(part.end(), &image[at], &image[at] + channels);
      }
    }
    return part;
  };
  for (const auto& image : data.images) out.images.push_back(part_of(image));
  for (const auto& image : data.unmixed_images) out.unmixed_images.push_back(part_of(image));
  sum_rows(out);
  return out;
}

PhotometryData unmixed(const PhotometryData& data, const effects::Mixing& mixing) {
  PhotometryData out = data;
  out.images.clear();
  out.mixing = mixing;
  for (const auto& image : data.images) {
    std::vector<float>& values = out.unmixed_images.emplace_back(image.begin(), image.end());
    effects::unmix(mixing, {data.width_px, data.height_px, data.channels}, values);
  }
  sum_rows(out);
  return out;
}

double least_at_top(const PhotometryData& data, const PhotometrySums& all) {
  // Values of which one in five is not clipped have as much.
  constexpr double kPart = 0.1;
  double most = 0;
  for (const LevelSums& level : all.levels) {
    if (level.frames.size() < 2) continue;
    double scatter = 0;
    for (const double own : level.scatter) scatter += own;
    const double freedom = static_cast<double>(level.frames.size() - 1) * (data.width_px - 1) *
                           static_cast<double>(data.rows());
    most = std::max(most, scatter / freedom);
  }
  return kPart * most;
}

double least_at_bottom(const PhotometryData& data, const PhotometrySums& all) {
  constexpr double kPart = 0.1, kBrightest = 0.1;
  double most = 0;
  for (size_t l = 0; l < all.levels.size(); ++l) {
    const LevelSums& level = all.levels[l];
    if (data.levels[l].light() != 0 || level.frames.size() < 2) continue;
    std::vector<size_t> order(level.mean.size());
    std::iota(order.begin(), order.end(), size_t{0});
    const auto middle = order.begin() + static_cast<std::ptrdiff_t>(
                                            (1 - kBrightest) * static_cast<double>(order.size()));
    std::nth_element(order.begin(), middle, order.end(),
                     [&](size_t a, size_t b) { return level.mean[a] < level.mean[b]; });
    double scatter = 0;
    for (auto i = middle; i != order.end(); ++i) scatter += level.scatter[*i];
    most = std::max(most, scatter / static_cast<double>(order.end() - middle) /
                              static_cast<double>(level.frames.size() - 1));
  }
  return kPart * most;
}

void set_side_by_side(PhotometrySums& sums) {
  sums.present.clear(), sums.reference.clear();
  for (size_t l = 0; l < sums.levels.size(); ++l) {
    if (!sums.levels[l].frames.empty()) sums.present.push_back(l);
  }
  const size_t levels = sums.present.size();
  const size_t samples = levels > 0 ? sums.levels[sums.present.front()].mean.size() : 0;
  sums.by_sample.resize(samples * levels);
  for (size_t k = 0; k < levels; ++k) {
    const std::vector<double>& mean = sums.levels[sums.present[k]].mean;
    const double reference =
        std::accumulate(mean.begin(), mean.end(), 0.0) / static_cast<double>(samples);
    sums.reference.push_back(reference);
    for (size_t i = 0; i < samples; ++i) sums.by_sample[i * levels + k] = mean[i] - reference;
  }
}

PhotometrySums sum_frames(const PhotometryData& data, const Groups& groups,
                          const std::vector<int>& group_of_frame) {
  Hasher chosen;
  chosen.add(std::string_view(groups.data(), groups.size()));
  if (data.mixing.acts()) chosen.add(data.mixing.along_rows), chosen.add(data.mixing.along_columns);
  PhotometrySums sums{.id = chosen.digest()};
  for (const PhotometryLevel& level : data.levels) {
    LevelSums sum;
    for (const int frame : level.frames) {
      if (groups[group_of_frame[frame]]) sum.frames.push_back(frame);
    }
    if (!sum.frames.empty()) sum_level(data, sum);
    sums.values += static_cast<int64_t>(sum.frames.size() * data.samples());
    sums.levels.push_back(std::move(sum));
  }
  set_side_by_side(sums);
  return sums;
}

}  // namespace seam::measurement
