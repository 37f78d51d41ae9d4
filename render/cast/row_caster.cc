#include "render/cast/row_caster.h"

#include <algorithm>
#include <cmath>

namespace seam::render {
namespace {

// Neighbouring pixels: a rank-1 lattice with the fractions of the generalised golden ratio.
constexpr double kColumnU = 0.8566748838545029, kColumnV = 0.6287067210378087;
constexpr double kRowU = 0.7338918566271260, kRowV = 0.5385972572236101;
// Shades that differ by more than this meet at an edge.
constexpr float kShadeStep = 0.03f;
// Samples of one pixel: the same in two dimensions.
constexpr double kSampleU = 0.7548776662466927, kSampleV = 0.5698402909980532;

float fraction(double value) {
  const auto part = static_cast<float>(value - std::floor(value));
  return part < 1.0f ? part : 0.0f;
}

// x where the edge crosses the strip [y_min, y_max], added to [low, high].
void widen(const OutlineEdge& edge, float y_min, float y_max, float& low, float& high) {
  if (edge.y1 < y_min || edge.y0 > y_max) return;
  const float first = edge.y0 < y_min ? edge.x0 + (y_min - edge.y0) * edge.slope : edge.x0;
  const float last = edge.y1 > y_max ? edge.x0 + (y_max - edge.y0) * edge.slope : edge.x1;
  low = std::min(low, std::min(first, last));
  high = std::max(high, std::max(first, last));
}

// x where the sweep crosses the strip [y_min, y_max]; false where it does not.
bool crossing(const Sweep& sweep, float y_min, float y_max, float& low, float& high) {
  constexpr float kSlack = 1e-4f;
  float first = 0.0f, last = 1.0f;  // The part of the way on which the rectangle meets the strip.
  const auto keep_below = [&](float from, float to, float limit) {
    const float way = to - from;
    if (std::abs(way) < 1e-7f) {
      if (std::min(from, to) > limit + kSlack) last = -1.0f;
    } else if (way > 0) {
      last = std::min(last, (limit - from) / way);
    } else {
      first = std::max(first, (limit - from) / way);
    }
  };
  keep_below(sweep.y_min[0], sweep.y_min[1], y_max + kSlack);
  keep_below(-sweep.y_max[0], -sweep.y_max[1], kSlack - y_min);
  if (first > last) return false;
  const auto at = [](const float(&ends)[2], float part) {
    return ends[0] + part * (ends[1] - ends[0]);
  };
  low = std::min(at(sweep.x_min, first), at(sweep.x_min, last));
  high = std::max(at(sweep.x_max, first), at(sweep.x_max, last));
  return true;
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
  const int whole = (rays + kRayBlock - 1) / kRayBlock * kRayBlock;
  for (auto* values : {&x, &y, &depth}) values->resize(whole);
  // The third component stays 1 for perspective rays.
  z.resize(whole, 1.0f);
  factor.resize(whole);
  id.resize(whole);
}

RowCaster::RowCaster(const CameraRays& rays, const SamplePattern& pattern, bool lambert,
                     int edge_samples)
    : kernels_(cast_kernels()),
      rays_(rays),
      pattern_(pattern),
      lambert_(lambert),
      columns_(rays.columns()),
      edge_samples_(edge_samples),
      channels_(rays.colours_apart() ? 3 : 1),
      components_(rays.perspective ? 2 : 3),
      slopes_(channels_ * components_),
      varying_(columns_),
      near_varying_(columns_),
      edge_columns_(columns_ + 1),
      phase_u_(edge_samples + kPhaseBlock),
      phase_v_(edge_samples + kPhaseBlock) {
  row_.resize(columns_);
  row_.place.resize(columns_ + 1);
  for (int column = 0; column <= columns_; ++column) row_.place[column] = column;
  edges_.place.resize(columns_ + 1);
}

void RowCaster::collect_slopes(int row) {
  const size_t offset = rays_.at(row);
  for (int channel = 0; channel < channels_; ++channel) {
    const RayTable& table = rays_.table(channel);
    for (int k = 0; k < components_; ++k) {
      slopes_[channel * components_ + k] = {&table.base[k][offset], &table.along_u[k][offset],
                                            &table.along_v[k][offset]};
    }
  }
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
    } else if (footprint.sweep >= 0) {
      if (!crossing(scene.sweeps[footprint.sweep], y_min, y_max, low, high)) continue;
      low = std::max(low - 1e-4f, footprint.x_min), high = std::min(high + 1e-4f, footprint.x_max);
    }
    int first, last;
    rays_.columns_between(row, low, high, first, last);
    if (first <= last) {
      spans_.push_back(
          {static_cast<int32_t>(i), static_cast<int16_t>(first), static_cast<int16_t>(last)});
    }
  }
}

void RowCaster::cast(const PreparedInstant& scene, std::span<const Span> spans, const Batch& batch,
                     HitRow hits, float* factor) const {
  kernels_.clear(batch.count, hits);
  for (const Span& span : spans) {
    const int begin = batch.place[span.first], end = batch.place[span.last + 1];
    if (begin < end)
      kernels_.cast[scene.kinds[span.shape]](scene.shapes[span.shape], batch.rays(), begin, end,
                                             hits);
  }
  if (!lambert_) return;
  for (int begin = 0, end = 0; begin < batch.count; begin = end) {
    const int32_t id = hits.id[begin];
    for (end = begin + 1; end < batch.count && hits.id[end] == id;) ++end;
    if (id < 0) {
      std::fill(factor + begin, factor + end, 1.0f);
    } else {
      kernels_.shade[scene.kinds[id]](scene.shapes[id], batch.rays(), hits.depth, begin, end,
                                      factor);
    }
  }
}

void RowCaster::first_look(int row, std::span<const RowSample> samples, float* const* light) {
  const size_t count = samples.size() * static_cast<size_t>(columns_);
  if (signatures_.size() < count) {
    // Rays are cast in whole blocks, beyond the last sample's end.
    ids_.resize(count + kRayBlock);
    signatures_.resize(count), factors_.resize(lambert_ ? count : 0);
  }
  spans_.clear();
  spans_begin_.assign(1, 0);
  for (size_t s = 0; s < samples.size(); ++s) {
    const RowSample& sample = samples[s];
    const float u = SamplePattern::phase_u(row, sample.place),
                v = SamplePattern::phase_v(row, sample.place);
    // Where colours have rays of their own, the samples take them in turn: a pixel whose samples
    // all look the same is the same in all colours.
    const size_t channel = channels_ == 3 ? s % 3 : 0;
    float* const targets[3] = {row_.x.data(), row_.y.data(), row_.z.data()};
    kernels_.offset_rays(&slopes_[channel * components_], components_, pattern_.tile_u(),
                         pattern_.tile_v(), u, v, columns_, targets);
    find_spans(row, *sample.scene);
    spans_begin_.push_back(spans_.size());
    const size_t place = s * columns_;
    float* const factor = lambert_ ? &factors_[place] : nullptr;
    cast(*sample.scene, std::span(spans_).subspan(spans_begin_[s]), row_,
         {row_.depth.data(), &ids_[place]}, factor);
    kernels_.add_row(sample.scene->colours.data(), sample.scene->signatures.data(),
                     static_cast<int>(sample.scene->colours.size()), &ids_[place], factor,
                     sample.weight, columns_, light, &signatures_[place]);
  }
}

void RowCaster::find_varying(int samples) {
  kernels_.find_varying(signatures_.data(), samples, columns_, varying_.data());
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

// The same columns at each sample: where nothing near varies, all samples differ from their
// neighbours as the first one does.
int RowCaster::find_edges() {
  // A sliver of something in a pixel is often met by the rays of its neighbours in the row alone.
  kernels_.widen(varying_.data(), columns_, near_varying_.data());
  const int rays = edge_samples_ * channels_;
  const int count = kernels_.find_edges(signatures_.data(), near_varying_.data(), columns_, rays,
                                        edge_columns_.data(), edges_.place.data());
  edges_.resize(count * rays);
  return count;
}

void RowCaster::refine(int row, const RowSample& sample, int sample_index, int count,
                       float* const* light) {
  const size_t place = static_cast<size_t>(sample_index) * columns_;
  const int each = edge_samples_;
  for (int j = 0; j < each; ++j) {
    phase_u_[j] = SamplePattern::phase_u(row, sample.place * each + j);
    phase_v_[j] = SamplePattern::phase_v(row, sample.place * each + j);
  }
  float* const targets[3] = {edges_.x.data(), edges_.y.data(), edges_.z.data()};
  kernels_.edge_rays(slopes_.data(), channels_, components_, pattern_.tile_u(), pattern_.tile_v(),
                     edge_columns_.data(), count, phase_u_.data(), phase_v_.data(), each, targets);
  const size_t begin = spans_begin_[sample_index], end = spans_begin_[sample_index + 1];
  cast(*sample.scene, std::span(spans_).subspan(begin, end - begin), edges_,
       {edges_.depth.data(), edges_.id.data()}, edges_.factor.data());
  kernels_.replace(sample.scene->colours.data(), edges_.id.data(),
                   lambert_ ? edges_.factor.data() : nullptr, edge_columns_.data(), count, each,
                   channels_, &ids_[place], lambert_ ? &factors_[place] : nullptr, sample.weight,
                   light);
}

void RowCaster::cast_row(int row, std::span<const RowSample> samples, float* const* light) {
  for (int c = 0; c < 3; ++c) std::fill_n(light[c], columns_, 0.0f);
  collect_slopes(row);
  first_look(row, samples, light);
  if (edge_samples_ < 2) return;
  find_varying(static_cast<int>(samples.size()));
  const int edges = find_edges();
  if (edges == 0) return;
  for (size_t s = 0; s < samples.size(); ++s)
    refine(row, samples[s], static_cast<int>(s), edges, light);
}

RowCaster::Seen RowCaster::see_centres(int row, const PreparedInstant& scene) {
  spans_.clear();
  find_spans(row, scene);
  const RayTable& green = rays_.table(1);
  std::vector<float>* const targets[3] = {&row_.x, &row_.y, &row_.z};
  for (int k = 0; k < components_; ++k)
    std::copy_n(green.base[k].begin() + static_cast<ptrdiff_t>(rays_.at(row)), columns_,
                targets[k]->begin());
  cast(scene, spans_, row_, {row_.depth.data(), row_.id.data()}, row_.factor.data());
  return {row_.depth.data(), row_.id.data()};
}

}  // namespace seam::render
