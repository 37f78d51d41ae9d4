// What columns span, one after another (Gram and Schmidt): what of a further column is its own.
#pragma once

#include <vector>

namespace seam::measurement {

class Span {
 public:
  // Takes out of the column what earlier ones span; returns its length before.
  double take_out_of(std::vector<double>& column) const;
  // Adds the direction of a column that has nothing of earlier ones left in it.
  void add(const std::vector<double>& column);

 private:
  std::vector<std::vector<double>> directions_;  // Orthonormal.
};

double dot(const std::vector<double>& a, const std::vector<double>& b);
double length(const std::vector<double>& column);

}  // namespace seam::measurement
