// The inner loops of the ray caster: one analytic primitive against a run of rays of one row.
//
// Plain loops without branches, which compilers turn into vector instructions. They use IEEE
// additions, multiplications, divisions, square roots and comparisons alone, element by element,
// so every vector width gives the same bits. Files that include `cast_kernels.inc` are compiled for
// one width each; `cast_kernels()` picks the widest that this machine has.
#pragma once

#include <cstdint>

namespace seam::render {

// A primitive prepared for one instant. The object's frame O is that of `Primitive::X_WO`.
struct CastShape {
  float R_OC[9];      // Row-major: maps a direction in the camera's frame into the object's.
  float origin_O[3];  // The camera in the object's frame, metres.
  float centre_C[3];  // The object's origin in the camera's frame, metres.
  float size[3];      // Rectangle, box: half edges. Others: radius in [0], height in [2]. Metres.
  float light_O[3];   // Direction towards the light in the object's frame, times `diffuse`.
  float ambient;
  int32_t id;  // What a hit writes; the primitive's place in its instant.
};

// Directions of the rays of one row in the camera's frame.
struct RayRow {
  const float* x;
  const float* y;
  const float* z;
};

// What the rays have met so far: the multiple of the direction at which, and the primitive.
struct HitRow {
  float* depth;
  int32_t* id;
};

// Red, green, blue, and one unused.
struct alignas(16) Colour {
  float rgb[4];
};

// One component of a row's rays and its derivatives along u and v.
struct RaySlopes {
  const float* base;
  const float* along_u;
  const float* along_v;
};

// Rays are cast in blocks of so many; arrays of rays and hits are whole blocks long.
inline constexpr int kRayBlock = 16;

struct CastKernels {
  // Rays of whole blocks around [begin, end), of which none beside the range can hit.
  using Cast = void (*)(const CastShape&, RayRow, int begin, int end, HitRow);
  // The factor on the primitive's rgb at hits of columns [begin, end) under Lambert's law.
  using Shade = void (*)(const CastShape&, RayRow, const float* depth, int begin, int end,
                         float* factor);
  Cast cast[5];    // By Shape.
  Shade shade[5];  // By Shape.
  // Nothing met yet.
  void (*clear)(int count, HitRow hits);
  // Rays of one row (`components` of x, y, z), at offsets from the pixels' centres:
  // base + du * along_u + dv * along_v, with du = frac(tile_u[i] + phase_u) - 1/2 and dv alike.
  void (*offset_rays)(const RaySlopes* slopes, int components, const float* tile_u,
                      const float* tile_v, float phase_u, float phase_v, int count,
                      float* const* out);
  // The same for some columns alone: for each column and channel `each` rays, ray j with phase j.
  // `slopes` are those of the first channel's components, then the next's. Phases fill whole blocks
  // of kPhaseBlock.
  void (*edge_rays)(const RaySlopes* slopes, int channels, int components, const float* tile_u,
                    const float* tile_v, const int32_t* columns, int count, const float* phase_u,
                    const float* phase_v, int each, float* const* out);
  // sum[c][i] += weight * factor[i] * colours[id[i] + 1].rgb[c] for each colour c;
  // signature[i] = signatures[id[i] + 1]. There are so many `places`. Without factors they are 1.
  void (*add_row)(const Colour* colours, const uint32_t* signatures, int places, const int32_t* id,
                  const float* factor, float weight, int count, float* const* sum,
                  uint32_t* signature);
  // Adds `weight` times the mean colour of every column's `each` rays, less that of the one ray
  // that the column had in `first_id`, `first_factor` (by column). With three channels each has
  // rays of its own, as edge_rays orders them. Without factors they are 1.
  void (*replace)(const Colour* colours, const int32_t* id, const float* factor,
                  const int32_t* columns, int count, int each, int channels,
                  const int32_t* first_id, const float* first_factor, float weight,
                  float* const* sum);
  // differs[i]: not 0 where one of the rows of signatures has another at i than the first row.
  void (*find_varying)(const uint32_t* signatures, int rows, int count, uint32_t* differs);
  // near[i]: not 0 where differs[i] or its neighbour in the row is not.
  void (*widen)(const uint32_t* differs, int count, uint32_t* near);
  // Columns where a signature is not its neighbours' or `differs` is not 0: returns how many.
  // place[i] = `each` times those before column i, up to i = count.
  int (*find_edges)(const uint32_t* signature, const uint32_t* differs, int count, int each,
                    int32_t* columns, int* place);
  const char* name;
};

inline constexpr int kPhaseBlock = 8;

// A hit nearer than this is not seen (the lens is in front of it), metres along the ray.
inline constexpr float kNear = 1e-3f;
inline constexpr float kFar = 1e30f;
// Of surfaces this close in depth, the later primitive is seen: lines are painted on the carpet.
inline constexpr float kCoplanar = 1.00001f;

const CastKernels& cast_kernels();

}  // namespace seam::render
