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

double Span::take_out_of(std::vector<double>& column, std::vector<double>* parts) const {
  const double before = length(column);
  if (parts != nullptr) parts->assign(directions_.size(), 0);
  for (int twice = 0; twice < 2; ++twice) {  // Once leaves rounding of the size of what it took.
    for (size_t k = 0; k < directions_.size(); ++k) {
      const double along = dot(directions_[k], column);
      for (size_t i = 0; i < column.size(); ++i) column[i] -= along * directions_[k][i];
      if (parts != nullptr) (*parts)[k] += along;
    }
  }
  return before;
}

void Span::add(const std::vector<double>& column, std::vector<double> parts) {
  const double size = length(column);
  directions_.push_back(column);
  for (double& value : directions_.back()) value /= size;
  parts.push_back(size);
  parts_.push_back(std::move(parts));
}

std::vector<double> Span::steps_to(const std::vector<double>& target) const {
  std::vector<double> steps(directions_.size());
  for (size_t k = steps.size(); k-- > 0;) {
    double left = dot(directions_[k], target);
    for (size_t later = k + 1; later < steps.size(); ++later)
      left -= parts_[later][k] * steps[later];
    steps[k] = left / parts_[k].back();
  }
  return steps;
}

}  // namespace seam::measurement
