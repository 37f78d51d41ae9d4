#include "render/row_caster.h"

#include <algorithm>
#include <cmath>

namespace seam::render {
namespace {

// Neighbouring pixels: a rank-1 lattice with the fractions of the generalised golden ratio.
constexpr double kColumnU = 0.8566748838545029, kColumnV = 0.6287067210378087;
constexpr double kRowU = 0.7338918566271260, kRowV = 0.5385972572236101;
// Shades that differ by more than this meet at an edge.
constexpr float kShadeStep = 0.03f;
// A sliver of something in a pixel is often met by the rays of a pixel so near in the row alone.
constexpr int kSliver = 1;
// Samples of one pixel: the same in two dimensions.
constexpr double kSampleU = 0.7548776662466927, kSampleV = 0.5698402909980532;

float fraction(double value) {
  const auto part = static_cast<float>(value - std::floor(value));
  return part < 1.0f ? part : 0.0f;
}

// x where the edge crosses the strip [y_min, y_max], added to [low, high].
void widen(const OutlineEdge& edge, float y_min, float y_max, float& low, float& high) {
  if (edge.y1 < y_min || edge.y0 > y_max) return;
  const float dy = edge.y1 - edge.y0;
  const float slope = dy > 1e-12f ? (edge.x1 - edge.x0) / dy : 0.0f;
  const float first =
      edge.y0 < y_min && dy > 1e-12f ? edge.x0 + (y_min - edge.y0) * slope : edge.x0;
  const float last = edge.y1 > y_max && dy > 1e-12f ? edge.x0 + (y_max - edge.y0) * slope : edge.x1;
  low = std::min(low, std::min(first, last));
  high = std::max(high, std::max(first, last));
}

}  // namespace

SamplePattern::SamplePattern(int columns) : tile_u_(columns), tile_v_(columns) {
  for (int column = 0; column < columns; ++column) {
    tile_u_[column] = fraction(column * kColumnU);
    tile_v_[column] = fraction(column * kColumnV);
  }
}

float SamplePattern::phase_u(int row, int sample) {
  return fraction(row * kRowU + sample * kSampleU);
}
float SamplePattern::phase_v(int row, int sample) {
  return fraction(row * kRowV + sample * kSampleV);
}

std::vector<int> SamplePattern::scattered_order(int count) {
  std::vector<int> by_mirror(count), place(count);
  for (int k = 0; k < count; ++k) by_mirror[k] = k;
  const auto mirrored = [](int k) {
    uint32_t bits = 0;
    for (int bit = 0; bit < 32; ++bit)
      bits |= ((static_cast<uint32_t>(k) >> bit) & 1u) << (31 - bit);
    return bits;
  };
  std::sort(by_mirror.begin(), by_mirror.end(),
            [&](int a, int b) { return mirrored(a) < mirrored(b); });
  for (int rank = 0; rank < count; ++rank) place[by_mirror[rank]] = rank;
  return place;
}

void RowCaster::Batch::resize(int rays) {
  count = rays;
  if (static_cast<int>(x.size()) >= rays) return;
  for (auto* values : {&x, &y, &depth}) values->resize(rays);
  // The third component stays 1 for perspective rays, the factor stays 1 without Lambert's law.
  z.resize(rays, 1.0f);
  factor.resize(rays, 1.0f);
  id.resize(rays);
}

RowCaster::RowCaster(const CameraRays& rays, const SamplePattern& pattern, bool lambert,
                     int edge_samples)
    : kernels_(cast_kernels()),
      rays_(rays),
      pattern_(pattern),
      lambert_(lambert),
      columns_(rays.columns()),
      edge_samples_(edge_samples),
      sums_(columns_),
      varying_(columns_),
      near_varying_(columns_),
      phase_u_(edge_samples),
      phase_v_(edge_samples) {
  row_.resize(columns_);
  row_.place.resize(columns_ + 1);
  for (int column = 0; column <= columns_; ++column) row_.place[column] = column;
  edges_.place.resize(columns_ + 1);
}

RaySlopes RowCaster::slopes(int channel, int component, int row) const {
  const RayTable& table = rays_.table(channel);
  const size_t offset = rays_.at(row);
  return {&table.base[component][offset], &table.along_u[component][offset],
          &table.along_v[component][offset]};
}

void RowCaster::find_spans(int row, const PreparedInstant& scene) {
  const float y_min = rays_.row_y_min[row], y_max = rays_.row_y_max[row];
  for (size_t i = 0; i < scene.footprints.size(); ++i) {
    const Footprint& footprint = scene.footprints[i];
    if (row < footprint.first_row || row > footprint.last_row) continue;
    float low = footprint.x_min, high = footprint.x_max;
    if (footprint.edges > 0) {
      low = 1e30f, high = -1e30f;
      for (int k = 0; k < footprint.edges; ++k) {
        widen(scene.outline_edges[footprint.first_edge + k], y_min, y_max, low, high);
      }
      low = std::max(low - 1e-4f, footprint.x_min), high = std::min(high + 1e-4f, footprint.x_max);
      if (low > high) continue;
    }
    int first, last;
    rays_.columns_between(row, low, high, first, last);
    if (first <= last) {
      spans_.push_back(
          {static_cast<int32_t>(i), static_cast<int16_t>(first), static_cast<int16_t>(last)});
    }
  }
}

void RowCaster::cast(const PreparedInstant& scene, std::span<const Span> spans, RayRow batch_rays,
                     Batch& batch) {
  std::fill_n(batch.depth.begin(), batch.count, kFar);
  std::fill_n(batch.id.begin(), batch.count, -1);
  const HitRow hits{batch.depth.data(), batch.id.data()};
  for (const Span& span : spans) {
    const int begin = batch.place[span.first], end = batch.place[span.last + 1];
    if (begin < end)
      kernels_.cast[scene.kinds[span.shape]](scene.shapes[span.shape], batch_rays, begin, end,
                                             hits);
  }
  if (!lambert_) return;
  for (int begin = 0, end = 0; begin < batch.count; begin = end) {
    const int32_t id = batch.id[begin];
    for (end = begin + 1; end < batch.count && batch.id[end] == id;) ++end;
    if (id < 0) {
      std::fill(batch.factor.begin() + begin, batch.factor.begin() + end, 1.0f);
    } else {
      kernels_.shade[scene.kinds[id]](scene.shapes[id], batch_rays, batch.depth.data(), begin, end,
                                      batch.factor.data());
    }
  }
}

void RowCaster::first_look(int row, std::span<const RowSample> samples) {
  const size_t count = samples.size() * static_cast<size_t>(columns_);
  if (ids_.size() < count)
    ids_.resize(count), signatures_.resize(count),
        factors_.resize(lambert_ ? count : columns_, 1.0f);
  spans_.clear();
  spans_begin_.assign(1, 0);
  for (size_t s = 0; s < samples.size(); ++s) {
    const RowSample& sample = samples[s];
    const float u = SamplePattern::phase_u(row, sample.place),
                v = SamplePattern::phase_v(row, sample.place);
    // Where colours have rays of their own, the samples take them in turn: a pixel whose samples
    // all look the same is the same in all colours.
    const int channel = static_cast<int>(s % 3);
    float* const targets[3] = {row_.x.data(), row_.y.data(), row_.z.data()};
    for (int k = 0; k < (rays_.perspective ? 2 : 3); ++k) {
      kernels_.offset_rays(slopes(channel, k, row), pattern_.tile_u(), pattern_.tile_v(), u, v,
                           columns_, targets[k]);
    }
    find_spans(row, *sample.scene);
    spans_begin_.push_back(spans_.size());
    cast(*sample.scene, std::span(spans_).subspan(spans_begin_[s]), row_.rays(), row_);
    const size_t place = s * columns_;
    kernels_.add_row(sample.scene->colours.data(), sample.scene->signatures.data(), row_.id.data(),
                     row_.factor.data(), sample.weight, columns_, sums_.data(),
                     &signatures_[place]);
    std::copy_n(row_.id.begin(), columns_, &ids_[place]);
    if (lambert_) std::copy_n(row_.factor.begin(), columns_, &factors_[place]);
  }
}

void RowCaster::find_varying(int samples) {
  std::fill(varying_.begin(), varying_.end(), 0u);
  for (int s = 1; s < samples; ++s) {
    const uint32_t* here = &signatures_[static_cast<size_t>(s) * columns_];
    for (int column = 0; column < columns_; ++column)
      varying_[column] |= here[column] ^ signatures_[column];
  }
  if (!lambert_) return;
  // The faces of a box are one primitive, but differ in shade, in the pixel or from its neighbour.
  for (int s = 0; s < samples; ++s) {
    const float* here = &factors_[static_cast<size_t>(s) * columns_];
    for (int column = 0; column < columns_; ++column) {
      const float right = here[column + 1 < columns_ ? column + 1 : column];
      const bool differs = std::abs(here[column] - factors_[column]) > kShadeStep ||
                           std::abs(here[column] - right) > kShadeStep;
      varying_[column] |= differs ? 1u : 0u;
    }
  }
}

void RowCaster::widen_varying() {
  for (int column = 0; column < columns_; ++column) {
    uint32_t near = 0;
    for (int other = std::max(0, column - kSliver);
         other <= std::min(columns_ - 1, column + kSliver); ++other) {
      near |= varying_[other];
    }
    near_varying_[column] = near;
  }
}

void RowCaster::find_edges(int sample) {
  const uint32_t* here = &signatures_[static_cast<size_t>(sample) * columns_];
  edge_columns_.clear();
  for (int column = 0; column < columns_; ++column) {
    edges_.place[column] = static_cast<int>(edge_columns_.size()) * edge_samples_;
    const uint32_t own = here[column];
    const uint32_t left = here[column > 0 ? column - 1 : 0];
    const uint32_t right = here[column + 1 < columns_ ? column + 1 : column];
    if (((own ^ left) | (own ^ right) | near_varying_[column]) != 0)
      edge_columns_.push_back(column);
  }
  edges_.place[columns_] = static_cast<int>(edge_columns_.size()) * edge_samples_;
}

void RowCaster::refine(int row, const RowSample& sample, int sample_index, int channel) {
  const int count = static_cast<int>(edge_columns_.size());
  edges_.resize(count * edge_samples_);
  for (int j = 0; j < edge_samples_; ++j) {
    phase_u_[j] = SamplePattern::phase_u(row, sample.place * edge_samples_ + j);
    phase_v_[j] = SamplePattern::phase_v(row, sample.place * edge_samples_ + j);
  }
  float* const targets[3] = {edges_.x.data(), edges_.y.data(), edges_.z.data()};
  for (int k = 0; k < (rays_.perspective ? 2 : 3); ++k) {
    kernels_.edge_rays(slopes(channel, k, row), pattern_.tile_u(), pattern_.tile_v(),
                       edge_columns_.data(), count, phase_u_.data(), phase_v_.data(), edge_samples_,
                       targets[k]);
  }
  const size_t begin = spans_begin_[sample_index], end = spans_begin_[sample_index + 1];
  cast(*sample.scene, std::span(spans_).subspan(begin, end - begin), edges_.rays(), edges_);
  const size_t place = static_cast<size_t>(sample_index) * columns_;
  kernels_.replace(sample.scene->colours.data(), edges_.id.data(), edges_.factor.data(),
                   edge_columns_.data(), count, edge_samples_, &ids_[place],
                   &factors_[lambert_ ? place : 0], sample.weight,
                   rays_.colours_apart() ? replaced_.data() : sums_.data());
}

const std::vector<Colour>& RowCaster::cast_row(int row, std::span<const RowSample> samples) {
  std::fill(sums_.begin(), sums_.end(), Colour{});
  first_look(row, samples);
  if (edge_samples_ < 2) return sums_;
  find_varying(static_cast<int>(samples.size()));
  widen_varying();
  for (size_t s = 0; s < samples.size(); ++s) {
    find_edges(static_cast<int>(s));
    if (edge_columns_.empty()) continue;
    if (!rays_.colours_apart()) {
      refine(row, samples[s], static_cast<int>(s), 1);
      continue;
    }
    for (int channel = 0; channel < 3; ++channel) {
      replaced_ = sums_;
      refine(row, samples[s], static_cast<int>(s), channel);
      for (const int32_t column : edge_columns_)
        sums_[column].rgb[channel] = replaced_[column].rgb[channel];
    }
  }
  return sums_;
}

RowCaster::Seen RowCaster::see_centres(int row, const PreparedInstant& scene) {
  spans_.clear();
  find_spans(row, scene);
  const RayTable& green = rays_.table(1);
  const size_t offset = rays_.at(row);
  cast(scene, spans_, {&green.base[0][offset], &green.base[1][offset], &green.base[2][offset]},
       row_);
  return {row_.depth.data(), row_.id.data()};
}

}  // namespace seam::render
