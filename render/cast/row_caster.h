// Light that arrives at one row of pixels: rays of the row's instants against the prepared scenes.
#pragma once

#include <span>
#include <vector>

#include "render/cast/cast_kernels.h"
#include "render/cast/prepared_scene.h"
#include "render/cast/ray_table.h"

namespace seam::render {

// Places inside a pixel's square, spread evenly over neighbouring pixels and over the samples of
// one pixel: rank-1 lattices.
class SamplePattern {
 public:
  explicit SamplePattern(int columns);
  const float* tile_u() const { return tile_u_.data(); }
  const float* tile_v() const { return tile_v_.data(); }
  // What to add (modulo 1) to the tiles for this row and sample.
  static float phase_u(int row, int sample);
  static float phase_v(int row, int sample);
  // The places in the pattern of samples that follow each other in time: scattered (ranked by their
  // mirrored bits), for an edge that moves in step with the pattern would always be seen from the
  // same side.
  static std::vector<int> scattered_order(int count);

 private:
  std::vector<float> tile_u_, tile_v_;
};

// One sample of a row: which scene, and how much it counts.
struct RowSample {
  const PreparedInstant* scene;
  float weight;
  int place;  // The sample's place in the pattern.
};

// Casts in two steps. First one ray a pixel and sample; then, where a pixel's colour differs from
// its neighbours' in the row or at the samples before and after, `edge_samples` rays in place of
// that one: edges get their area right, and flat parts cost no more than they need.
class RowCaster {
 public:
  RowCaster(const CameraRays& rays, const SamplePattern& pattern, bool lambert, int edge_samples);

  // The row's light: rays.columns() values of each colour.
  void cast_row(int row, std::span<const RowSample> samples, float* const* light);

  // What rays through the pixels' centres meet (green's, where colours have their own); valid until
  // the next call.
  struct Seen {
    const float* depth;  // Multiples of the direction; kFar where nothing is met.
    const int32_t* id;   // Place in the prepared scene, -1 where nothing is met.
  };
  Seen see_centres(int row, const PreparedInstant& scene);

 private:
  // Columns [first, last] of a row in which a primitive can be seen.
  struct Span {
    int32_t shape;
    int16_t first, last;
  };
  // Rays in ascending columns, and what they meet. `place[c]` is the first ray of column c or
  // later.
  struct Batch {
    std::vector<float> x, y, z, depth, factor;
    std::vector<int32_t> id;
    std::vector<int> place;
    int count = 0;
    void resize(int rays);
    RayRow rays() const { return {x.data(), y.data(), z.data()}; }
  };

  void find_spans(int row, const PreparedInstant& scene);
  // What the batch's rays meet, and its shading.
  void cast(const PreparedInstant& scene, std::span<const Span> spans, const Batch& batch,
            HitRow hits, float* factor) const;
  void first_look(int row, std::span<const RowSample> samples, float* const* light);
  void find_varying(int samples);
  // Returns how many there are.
  int find_edges();
  // Casts edge rays in so many columns.
  void refine(int row, const RowSample& sample, int sample_index, int count, float* const* light);
  void collect_slopes(int row);

  const CastKernels& kernels_;
  const CameraRays& rays_;
  const SamplePattern& pattern_;
  bool lambert_;
  int columns_;
  int edge_samples_;
  int channels_;                   // 3 where colours have rays of their own, or 1 for all.
  int components_;                 // Of a ray: x and y, and z where it is not 1.
  std::vector<RaySlopes> slopes_;  // Of the row: each channel's components.
  Batch row_, edges_;
  // Of every sample of the row: what was met, its shading, a number that stands for its look, and
  // where primitives can be seen.
  std::vector<int32_t> ids_;
  std::vector<float> factors_;
  std::vector<uint32_t> signatures_;
  std::vector<Span> spans_;
  std::vector<size_t> spans_begin_;
  std::vector<uint32_t> varying_;  // Not 0 where a pixel's samples differ; or a near pixel's.
  std::vector<uint32_t> near_varying_;
  std::vector<int32_t> edge_columns_;
  std::vector<float> phase_u_, phase_v_;
};

}  // namespace seam::render
