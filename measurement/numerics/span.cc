#include "measurement/numerics/span.h"

#include <Eigen/Core>
#include <cmath>

namespace seam::measurement {

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  return Eigen::Map<const Eigen::VectorXd>(a.data(), static_cast<Eigen::Index>(a.size()))
      .dot(Eigen::Map<const Eigen::VectorXd>(b.data(), static_cast<Eigen::Index>(b.size())));
}

double length(const std::vector<double>& column) {
  return std::sqrt(dot(column, column));
}

double Span::take_out_of(std::vector<double>& column) const {
  const double before = length(column);
  for (int twice = 0; twice < 2; ++twice) {  // Once leaves rounding of the size of what it took.
    for (const auto& direction : directions_) {
      const double along = dot(direction, column);
      for (size_t i = 0; i < column.size(); ++i) column[i] -= along * direction[i];
    }
  }
  return before;
}

void Span::add(const std::vector<double>& column) {
  const double size = length(column);
  directions_.push_back(column);
  for (double& value : directions_.back()) value /= size;
}

}  // namespace seam::measurement
