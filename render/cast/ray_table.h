// The directions from which a camera's pixels collect light: the inverse of the model's true
// geometry (distortion included), computed once for a model and image size.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "effects/stages/geometry.h"

namespace seam::render {

// Rays of the pixel centres of an image with a border around it, in the camera's frame, with their
// derivatives along u and v, which serve the samples inside the pixel (the lens's curvature over
// half a pixel is below 1e-4 px). Perspective rays have z = 1 and unit-free x, y.
struct RayTable {
  // Row-major over (height + 2 border) x (width + 2 border); component 0 x, 1 y, 2 z.
  std::vector<float> base[3];
  std::vector<float> along_u[3];
  std::vector<float> along_v[3];
};

// The rays of a camera: one table, or, where colours have rays of their own, one each for red,
// green and blue; with bounds that hold for all of them.
struct CameraRays {
  int width_px = 0;  // Of the image alone.
  int height_px = 0;
  int border_px = 0;        // Columns and rows beyond each edge.
  bool perspective = true;  // All rays have z = 1.
  double focal_px = 0;      // The most pixels that a unit of x or y covers.
  std::vector<RayTable> tables;
  // Separates them, and copies of them, from all others for as long as somebody holds it.
  std::shared_ptr<const bool> identity = std::make_shared<const bool>(true);

  // Bounds of the samples inside the pixels, for culling. row_y_max[r] is the greatest y of rows up
  // to r, row_y_min[r] the least of rows from r on, so both ascend with r.
  std::vector<float> row_y_min;
  std::vector<float> row_y_max;
  float x_min = 0, x_max = 0;

  // For each row and each of kColumnBins even bins of [x_min, x_max]: the first column with a
  // sample at the bin's begin or beyond, and the last one with a sample at its end or before.
  static constexpr int kColumnBins = 512;
  std::vector<int16_t> first_column;
  std::vector<int16_t> last_column;
  float bins_per_x = 0;

  const RayTable& table(int channel) const { return tables[tables.size() == 1 ? 0 : channel]; }
  bool colours_apart() const { return tables.size() > 1; }
  int columns() const { return width_px + 2 * border_px; }
  int rows() const { return height_px + 2 * border_px; }
  size_t at(int row) const { return static_cast<size_t>(row) * columns(); }
  // Columns [first, last] of this row whose samples can have x in [begin, end]; may be empty.
  void columns_between(int row, float begin, float end, int& first, int& last) const {
    const auto bin = [&](float x) {
      const float place = (x - x_min) * bins_per_x;
      return place <= 0 ? 0 : place >= kColumnBins - 1 ? kColumnBins - 1 : static_cast<int>(place);
    };
    const size_t offset = static_cast<size_t>(row) * kColumnBins;
    first = first_column[offset + bin(begin)];
    last = last_column[offset + bin(end)];
  }
};

// `t_s` is the time since the set's reference, for models whose geometry changes with time.
// Throws InputError, naming the model, when the lens maps no ray to a pixel of the image: the
// calibration is outside the invertible range of its distortion. Rays of the border that do not
// exist are those of the nearest pixel that has one.
CameraRays make_camera_rays(const effects::Projection& projection, const std::string& model_name,
                            int border_px, double t_s);

// Whether red and blue are seen elsewhere than green.
bool colours_have_own_rays(const effects::Projection& projection);

// Whether the image of a direction depends on the time or the row given to `project` (an
// expression effect), so that each frame needs a table of its own.
bool geometry_varies_with_time(const effects::Projection& projection);

}  // namespace seam::render
