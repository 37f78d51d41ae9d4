#include "measurement/kinds/photometry/means/image_cells.h"

#include <algorithm>
#include <cmath>

namespace seam::measurement {

CellGrid grid_of(const PhotometryData& data, double cells) {
  const double side = std::sqrt(cells * data.sensor_width() / data.sensor_height());
  const auto most = [](double count, int kept) {
    return std::clamp(static_cast<int>(std::lround(count)), 1, kept);
  };
  return {most(side, data.width_px), most(cells / side, data.height_px)};
}

ImageCells::ImageCells(const PhotometryData& data, CellGrid grid)
    : grid_(grid),
      channels_(data.channels),
      width_(static_cast<size_t>(grid.columns), 0),
      height_(static_cast<size_t>(grid.rows), 0) {
  const auto column = [&](int u) {
    return static_cast<size_t>(static_cast<int64_t>(data.column(u)) * grid_.columns /
                               data.sensor_width());
  };
  const auto row = [&](int v) {
    return static_cast<size_t>(static_cast<int64_t>(data.row(v)) * grid_.rows /
                               data.sensor_height());
  };
  for (int u = 0; u < data.width_px; ++u) ++width_[column(u)];
  for (int v = 0; v < data.height_px; ++v) ++height_[row(v)];
  of_sample_.reserve(data.samples());
  for (int v = 0; v < data.height_px; ++v) {
    for (int u = 0; u < data.width_px; ++u) {
      const size_t cell = row(v) * static_cast<size_t>(grid_.columns) + column(u);
      for (int c = 0; c < channels_; ++c)
        of_sample_.push_back(static_cast<Eigen::Index>(cell) * channels_ + c);
    }
  }
}

}  // namespace seam::measurement
