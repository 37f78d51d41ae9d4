#include "measurement/kinds/points/board_field.h"

#include <algorithm>

namespace seam::measurement {

Eigen::MatrixXd monomials(const std::vector<std::vector<double>>& coordinates, int degree) {
  const size_t n = coordinates.front().size();
  std::vector<std::vector<double>> columns{std::vector<double>(n, 1)};
  std::vector<std::pair<size_t, int>> last{{0, 0}};  // Last coordinate used, degree.
  for (size_t c = 0; c < columns.size(); ++c) {
    if (last[c].second == degree) continue;
    for (size_t k = last[c].first; k < coordinates.size(); ++k) {
      std::vector<double> column(n);
      for (size_t i = 0; i < n; ++i) column[i] = columns[c][i] * coordinates[k][i];
      columns.push_back(std::move(column));
      last.emplace_back(k, last[c].second + 1);
    }
  }
  Eigen::MatrixXd A(n, columns.size());
  for (size_t c = 0; c < columns.size(); ++c)
    A.col(c) = Eigen::Map<Eigen::VectorXd>(columns[c].data(), n);
  return A;
}

bool is_constant(const std::vector<double>& x) {
  const auto [low, high] = std::minmax_element(x.begin(), x.end());
  return *high - *low < 1e-9;
}

std::vector<double> standardised(std::vector<double> x) {
  const auto [low, high] = std::minmax_element(x.begin(), x.end());
  const double middle = 0.5 * (*low + *high), half = std::max(0.5 * (*high - *low), 1e-300);
  for (double& value : x) value = (value - middle) / half;
  return x;
}

BoardField::BoardField(const PointsData& data, const std::vector<int>& rows) {
  std::vector<std::vector<double>> coordinates(3);
  for (const int row : rows) {
    const Vec3 p = data.target.flat ? (data.p_W[row] - data.target.middle_W) * data.target.axes_W
                                    : data.p_W[row];
    for (int c = 0; c < 3; ++c) coordinates[static_cast<size_t>(c)].push_back(p[c]);
  }
  if (data.target.flat) {
    if (!is_constant(coordinates[2])) height_ = standardised(coordinates[2]);
    coordinates.pop_back();
  }
  std::erase_if(coordinates, is_constant);
  for (auto& x : coordinates) along_.push_back(standardised(x));
}

Eigen::MatrixXd BoardField::columns(int degree) const {
  Eigen::MatrixXd plane = monomials(along_, degree);
  if (height_.empty()) return plane;
  const Eigen::MatrixXd slow = monomials(along_, 1);
  const Eigen::Map<const Eigen::VectorXd> height(height_.data(),
                                                 static_cast<Eigen::Index>(height_.size()));
  Eigen::MatrixXd all(plane.rows(), plane.cols() + slow.cols());
  all << plane, height.asDiagonal() * slow;
  return all;
}

}  // namespace seam::measurement
