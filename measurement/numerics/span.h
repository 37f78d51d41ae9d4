// What columns span, one after another (Gram and Schmidt): what of a further column is its own.
#pragma once

#include <vector>

namespace seam::measurement {

class Span {
 public:
  // Takes out of the column what earlier ones span; returns its length before. `parts`: how far it
  // went along each direction.
  double take_out_of(std::vector<double>& column, std::vector<double>* parts = nullptr) const;
  // Adds the direction of a column that has nothing of earlier ones left in it; `parts` of it are
  // asked for by steps_to() alone.
  void add(const std::vector<double>& column, std::vector<double> parts = {});
  // Least squares: how much of each added column, as it was before anything was taken out of it,
  // comes nearest to the target.
  std::vector<double> steps_to(const std::vector<double>& target) const;

 private:
  std::vector<std::vector<double>> directions_;  // Orthonormal.
  std::vector<std::vector<double>> parts_;       // Of each column, its own length last.
};

double dot(const std::vector<double>& a, const std::vector<double>& b);
double length(const std::vector<double>& column);

}  // namespace seam::measurement
