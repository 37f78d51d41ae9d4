#include "render/row_caster.h"

#include <algorithm>
#include <cmath>

namespace seam::render {
namespace {

// Powers of the roots of x^3 = x + 1 and x^5 = x + 1: successive samples of one pixel fill its
// square evenly, and so do those of neighbouring pixels.
constexpr double kSampleU = 0.7548776662466927, kSampleV = 0.5698402909980532;
constexpr double kColumnU = 0.8566748838545029, kColumnV = 0.6287067210378087;
constexpr double kRowU = 0.7338918566271260, kRowV = 0.5385972572236101;

float fraction(double value) {
  const auto part = static_cast<float>(value - std::floor(value));
  return part < 1.0f ? part : 0.0f;
}

// x where the edge crosses the strip [y_min, y_max], added to [low, high].
void widen(const OutlineEdge& edge, float y_min, float y_max, float& low, float& high) {
  if (edge.y1 < y_min || edge.y0 > y_max) return;
  const float dy = edge.y1 - edge.y0;
  const float slope = dy > 1e-12f ? (edge.x1 - edge.x0) / dy : 0.0f;
  const float first = edge.y0 < y_min && dy > 1e-12f ? edge.x0 + (y_min - edge.y0) * slope : edge.x0;
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

float SamplePattern::phase_u(int row, int sample) { return fraction(row * kRowU + sample * kSampleU); }
float SamplePattern::phase_v(int row, int sample) { return fraction(row * kRowV + sample * kSampleV); }

void RowCaster::Batch::resize(int rays) {
  count = rays;
  if (static_cast<int>(x.size()) >= rays) return;
  for (auto* values : {&x, &y, &z, &depth, &factor}) values->resize(rays);
  id.resize(rays);
}

RowCaster::RowCaster(const SamplePattern& pattern, const Rgb& background, bool lambert, int columns,
                     int edge_samples)
    : kernels_(cast_kernels()),
      pattern_(pattern),
      background_{static_cast<float>(background[0]), static_cast<float>(background[1]),
                  static_cast<float>(background[2])},
      lambert_(lambert),
      columns_(columns),
      edge_samples_(edge_samples),
      ones_(columns, 1.0f),
      varying_(columns) {
  row_.resize(columns);
  row_.place.resize(columns + 1);
  for (int column = 0; column <= columns; ++column) row_.place[column] = column;
  edges_.place.resize(columns + 1);
}

void RowCaster::cast(const RayTable& rays, int row, const PreparedInstant& scene, RayRow batch_rays, Batch& batch) {
  std::fill_n(batch.depth.begin(), batch.count, kFar);
  std::fill_n(batch.id.begin(), batch.count, -1);
  const HitRow hits{batch.depth.data(), batch.id.data()};
  const float y_min = rays.row_y_min[row], y_max = rays.row_y_max[row];
  for (size_t i = 0; i < scene.shapes.size(); ++i) {
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
    rays.columns_between(row, low, high, first, last);
    if (first > last) continue;
    const int begin = batch.place[first], end = batch.place[last + 1];
    if (begin < end) kernels_.cast[scene.kinds[i]](scene.shapes[i], batch_rays, begin, end, hits);
  }
}

void RowCaster::shade(const PreparedInstant& scene, RayRow batch_rays, int begin, int end, Batch& batch) {
  const int32_t id = batch.id[begin];
  kernels_.shade[scene.kinds[id]](scene.shapes[id], batch_rays, batch.depth.data(), begin, end, batch.factor.data());
}

std::array<float, 3> RowCaster::colour(const PreparedInstant& scene, int32_t id, float factor) const {
  if (id < 0) return background_;
  const std::array<float, 3>& rgb = scene.colours[id];
  return lambert_ ? std::array<float, 3>{rgb[0] * factor, rgb[1] * factor, rgb[2] * factor} : rgb;
}

void RowCaster::add_runs(const PreparedInstant& scene, float weight, RayRow batch_rays, float* const sums[3],
                         uint32_t* signature) {
  for (int begin = 0; begin < columns_;) {
    const int32_t id = row_.id[begin];
    int end = begin + 1;
    while (end < columns_ && row_.id[end] == id) ++end;
    const bool shaded = lambert_ && id >= 0;
    if (shaded) shade(scene, batch_rays, begin, end, row_);
    const std::array<float, 3>& rgb = id < 0 ? background_ : scene.colours[id];
    for (int c = first_channel_; c <= last_channel_; ++c) {
      if (shaded) {
        kernels_.add_shaded(weight * rgb[c], row_.factor.data(), begin, end, sums[c]);
      } else {
        kernels_.add_constant(weight * rgb[c], begin, end, sums[c]);
      }
    }
    std::fill(signature + begin, signature + end, id < 0 ? 0u : scene.signatures[id]);
    begin = end;
  }
}

void RowCaster::first_look(const RayTable& rays, int row, std::span<const RowSample> samples, float* const sums[3]) {
  const size_t offset = rays.at(row);
  const size_t count = samples.size() * static_cast<size_t>(columns_);
  if (ids_.size() < count) ids_.resize(count), signatures_.resize(count), factors_.resize(lambert_ ? count : 0);
  for (size_t s = 0; s < samples.size(); ++s) {
    const RowSample& sample = samples[s];
    const float u = SamplePattern::phase_u(row, sample.place), v = SamplePattern::phase_v(row, sample.place);
    float* const targets[3] = {row_.x.data(), row_.y.data(), row_.z.data()};
    for (int k = 0; k < (rays.perspective ? 2 : 3); ++k) {
      const float* const base_u_v[3] = {&rays.base[k][offset], &rays.along_u[k][offset], &rays.along_v[k][offset]};
      kernels_.offset_rays(base_u_v, pattern_.tile_u(), pattern_.tile_v(), u, v, columns_, targets[k]);
    }
    const RayRow batch_rays{row_.x.data(), row_.y.data(), rays.perspective ? ones_.data() : row_.z.data()};
    cast(rays, row, *sample.scene, batch_rays, row_);
    const size_t place = s * columns_;
    add_runs(*sample.scene, sample.weight, batch_rays, sums, &signatures_[place]);
    std::copy_n(row_.id.begin(), columns_, &ids_[place]);
    if (lambert_) std::copy_n(row_.factor.begin(), columns_, &factors_[place]);
  }
}

void RowCaster::find_varying(int samples) {
  std::fill(varying_.begin(), varying_.end(), 0u);
  for (int s = 1; s < samples; ++s) {
    const uint32_t* here = &signatures_[static_cast<size_t>(s) * columns_];
    for (int column = 0; column < columns_; ++column) varying_[column] |= here[column] ^ signatures_[column];
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
    if (((own ^ left) | (own ^ right) | varying_[column]) != 0) edge_columns_.push_back(column);
  }
  edges_.place[columns_] = static_cast<int>(edge_columns_.size()) * edge_samples_;
}

void RowCaster::refine(const RayTable& rays, int row, const RowSample& sample, int sample_index,
                       float* const sums[3]) {
  const int count = static_cast<int>(edge_columns_.size()) * edge_samples_;
  edges_.resize(count);
  const int components = rays.perspective ? 2 : 3;
  if (static_cast<int>(edge_tile_u_.size()) < count) {
    edge_tile_u_.resize(count), edge_tile_v_.resize(count);
    for (int k = 0; k < 3; ++k) edge_base_[k].resize(count), edge_along_u_[k].resize(count), edge_along_v_[k].resize(count);
    std::fill(edges_.z.begin(), edges_.z.end(), 1.0f);
  }
  // Gather the edge pixels' rays, each so many times.
  const size_t offset = rays.at(row);
  int ray = 0;
  for (const int column : edge_columns_) {
    for (int j = 0; j < edge_samples_; ++j, ++ray) {
      const int place = sample.place * edge_samples_ + j;
      const float u = pattern_.tile_u()[column] + SamplePattern::phase_u(row, place);
      const float v = pattern_.tile_v()[column] + SamplePattern::phase_v(row, place);
      edge_tile_u_[ray] = u >= 1.0f ? u - 1.0f : u;
      edge_tile_v_[ray] = v >= 1.0f ? v - 1.0f : v;
      for (int k = 0; k < components; ++k) {
        edge_base_[k][ray] = rays.base[k][offset + column];
        edge_along_u_[k][ray] = rays.along_u[k][offset + column];
        edge_along_v_[k][ray] = rays.along_v[k][offset + column];
      }
    }
  }
  float* const targets[3] = {edges_.x.data(), edges_.y.data(), edges_.z.data()};
  for (int k = 0; k < components; ++k) {
    const float* const base_u_v[3] = {edge_base_[k].data(), edge_along_u_[k].data(), edge_along_v_[k].data()};
    kernels_.offset_rays(base_u_v, edge_tile_u_.data(), edge_tile_v_.data(), 0, 0, count, targets[k]);
  }
  cast(rays, row, *sample.scene, edges_.rays(), edges_);
  if (lambert_) {
    for (int begin = 0, end = 0; begin < count; begin = end) {
      for (end = begin + 1; end < count && edges_.id[end] == edges_.id[begin];) ++end;
      if (edges_.id[begin] >= 0) shade(*sample.scene, edges_.rays(), begin, end, edges_);
    }
  }

  // Put their mean in the place of the one ray of the first look.
  const float weight = sample.weight / static_cast<float>(edge_samples_);
  const int32_t* ids = &ids_[static_cast<size_t>(sample_index) * columns_];
  ray = 0;
  for (const int column : edge_columns_) {
    std::array<float, 3> sum{};
    for (int j = 0; j < edge_samples_; ++j, ++ray) {
      const std::array<float, 3> rgb = colour(*sample.scene, edges_.id[ray], edges_.factor[ray]);
      for (int c = 0; c < 3; ++c) sum[c] += rgb[c];
    }
    const float factor = lambert_ ? factors_[static_cast<size_t>(sample_index) * columns_ + column] : 1.0f;
    const std::array<float, 3> first = colour(*sample.scene, ids[column], factor);
    for (int c = first_channel_; c <= last_channel_; ++c) {
      sums[c][column] += weight * sum[c] - sample.weight * first[c];
    }
  }
}

void RowCaster::add_row(const RayTable& rays, int row, std::span<const RowSample> samples, float* const sums[3],
                        int channel) {
  first_channel_ = channel < 0 ? 0 : channel;
  last_channel_ = channel < 0 ? 2 : channel;
  first_look(rays, row, samples, sums);
  if (edge_samples_ < 2) return;
  find_varying(static_cast<int>(samples.size()));
  for (size_t s = 0; s < samples.size(); ++s) {
    find_edges(static_cast<int>(s));
    if (!edge_columns_.empty()) refine(rays, row, samples[s], static_cast<int>(s), sums);
  }
}

RowCaster::Seen RowCaster::see_centres(const RayTable& rays, int row, const PreparedInstant& scene) {
  const size_t offset = rays.at(row);
  cast(rays, row, scene, {&rays.base[0][offset], &rays.base[1][offset], &rays.base[2][offset]}, row_);
  return {row_.depth.data(), row_.id.data()};
}

}  // namespace seam::render
