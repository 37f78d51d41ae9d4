// Cells of the image over which the values of flat fields are averaged: smooth functions of the
// place lose nothing in them, and a set's millions of values become thousands of means.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "measurement/kinds/photometry/stack/photometry_data.h"

namespace seam::measurement {

// How many cells lie beside and above each other.
struct CellGrid {
  int columns = 1, rows = 1;
};
// About so many cells, as near to squares as the image allows, none smaller than a kept pixel.
CellGrid grid_of(const PhotometryData& data, double cells);

class ImageCells {
 public:
  // The grid is laid over the sensor, whose kept columns and rows `data` has.
  ImageCells(const PhotometryData& data, CellGrid grid);

  // Of cells and channels: a mean for each.
  Eigen::Index count() const {
    return static_cast<Eigen::Index>(grid_.columns) * grid_.rows * channels_;
  }
  int channels() const { return channels_; }
  CellGrid grid() const { return grid_; }
  int column_of(Eigen::Index mean) const {
    return static_cast<int>(mean / channels_) % grid_.columns;
  }
  int row_of(Eigen::Index mean) const { return static_cast<int>(mean / channels_) / grid_.columns; }
  int channel_of(Eigen::Index mean) const { return static_cast<int>(mean % channels_); }
  Eigen::Index of(size_t sample) const { return of_sample_[sample]; }
  // Kept columns in a cell's column, and kept rows in its row.
  double width_of(Eigen::Index mean) const { return width_[static_cast<size_t>(column_of(mean))]; }
  double height_of(Eigen::Index mean) const { return height_[static_cast<size_t>(row_of(mean))]; }

  // Sums of a value over the samples of each cell; `left_out` samples take no part (empty: all do).
  template <typename Value>
  Eigen::VectorXd sums(const std::vector<char>& left_out, const Value& value) const {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(count());
    for (size_t i = 0; i < of_sample_.size(); ++i) {
      if (left_out.empty() || !left_out[i]) sum[of_sample_[i]] += value(i);
    }
    return sum;
  }

 private:
  CellGrid grid_;
  int channels_;
  std::vector<Eigen::Index> of_sample_;
  std::vector<double> width_, height_;
};

}  // namespace seam::measurement
