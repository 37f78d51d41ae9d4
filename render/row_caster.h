// Light that arrives at one row of pixels: rays of the row's instants against the prepared scenes.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "render/cast_kernels.h"
#include "render/prepared_scene.h"
#include "render/ray_table.h"
#include "sim_core/scene.h"

namespace seam::render {

// Places inside a pixel's square, spread evenly over neighbouring pixels and successive samples: a
// rank-1 lattice over (column, row, sample) with the fractions of the generalised golden ratio.
class SamplePattern {
 public:
  explicit SamplePattern(int columns);
  const float* tile_u() const { return tile_u_.data(); }
  const float* tile_v() const { return tile_v_.data(); }
  // What to add (modulo 1) to the tiles for this row and sample.
  static float phase_u(int row, int sample);
  static float phase_v(int row, int sample);

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
  RowCaster(const SamplePattern& pattern, const Rgb& background, bool lambert, int columns, int edge_samples);

  // Adds the row's light, red, green and blue, to `sums` (columns() values each). With `channel` 0
  // to 2 only that one is added (its rays are those of `rays`).
  void add_row(const RayTable& rays, int row, std::span<const RowSample> samples, float* const sums[3],
               int channel = -1);

  // What rays through the pixels' centres meet; valid until the next call.
  struct Seen {
    const float* depth;  // Multiples of the direction; kFar where nothing is met.
    const int32_t* id;   // Place in the prepared scene, -1 where nothing is met.
  };
  Seen see_centres(const RayTable& rays, int row, const PreparedInstant& scene);

 private:
  // Rays in ascending columns, and what they meet. `place[c]` is the first ray of column c or later.
  struct Batch {
    std::vector<float> x, y, z, depth, factor;
    std::vector<int32_t> id;
    std::vector<int> place;
    int count = 0;
    void resize(int rays);
    RayRow rays() const { return {x.data(), y.data(), z.data()}; }
  };

  void cast(const RayTable& rays, int row, const PreparedInstant& scene, RayRow batch_rays, Batch& batch);
  void shade(const PreparedInstant& scene, RayRow batch_rays, int begin, int end, Batch& batch);
  void first_look(const RayTable& rays, int row, std::span<const RowSample> samples, float* const sums[3]);
  void add_runs(const PreparedInstant& scene, float weight, RayRow batch_rays, float* const sums[3], uint32_t* signature);
  void find_varying(int samples);
  void find_edges(int sample);
  void refine(const RayTable& rays, int row, const RowSample& sample, int sample_index, float* const sums[3]);
  std::array<float, 3> colour(const PreparedInstant& scene, int32_t id, float factor) const;

  const CastKernels& kernels_;
  const SamplePattern& pattern_;
  std::array<float, 3> background_;
  bool lambert_;
  int columns_;
  int edge_samples_;
  int first_channel_ = 0, last_channel_ = 2;
  Batch row_, edges_;
  std::vector<float> ones_;
  // Of every sample of the row: what was met, its shading, and a number that stands for its colour.
  std::vector<int32_t> ids_;
  std::vector<float> factors_;
  std::vector<uint32_t> signatures_;
  std::vector<uint32_t> varying_;  // Not 0 where a pixel's samples differ.
  std::vector<int> edge_columns_;
  std::vector<float> edge_base_[3], edge_along_u_[3], edge_along_v_[3], edge_tile_u_, edge_tile_v_;
};

}  // namespace seam::render
