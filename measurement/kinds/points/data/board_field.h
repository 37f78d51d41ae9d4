// Smooth fields over a view of a target without any model of the camera: polynomials of the
// points' own coordinates.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "measurement/kinds/points/data/points_data.h"

namespace seam::measurement {

// Products of powers of the given coordinates up to a total degree, a column each.
Eigen::MatrixXd monomials(const std::vector<std::vector<double>>& coordinates, int degree);
std::vector<double> standardised(std::vector<double> x);
bool is_constant(const std::vector<double>& x);

// What is smooth in where a point is seen and in how the head moves then, as flexible as half of
// the points allow.
Eigen::MatrixXd smooth_columns(const std::vector<std::vector<double>>& direction,
                               const std::vector<std::vector<double>>& state);

// Monomials of places in an image, of unit length, as many as there are places for.
Eigen::MatrixXd image_columns(std::vector<std::vector<double>> places, int most_degree);

class BoardField {
 public:
  BoardField(const PointsData& data, const std::vector<int>& rows);

  // Coordinates in which the points extend, from -1 to 1: two of a board.
  const std::vector<std::vector<double>>& along() const { return along_; }
  // Polynomials of them up to this degree. What heights a board's points have beside their plane
  // moves their image in proportion, which changes slowly over the board.
  Eigen::MatrixXd columns(int degree) const;

 private:
  std::vector<std::vector<double>> along_;
  std::vector<double> height_;  // Empty: none.
};

}  // namespace seam::measurement
