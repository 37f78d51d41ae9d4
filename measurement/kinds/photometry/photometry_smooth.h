// Smooth fields over the image: polynomials of row and column of up to the third order.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "measurement/kinds/photometry/stack/photometry_data.h"

namespace seam::measurement {

class SmoothField {
 public:
  explicit SmoothField(const PhotometryData& data);
  // The smooth part of a value by sample, each channel for itself.
  std::vector<double> of(const std::vector<double>& value) const;

 private:
  int channels_;
  Eigen::MatrixXd basis_;    // By pixel and function.
  Eigen::MatrixXd inverse_;  // Of their products.
};

}  // namespace seam::measurement
