#include "measurement/kinds/points/data/board_field.h"

#include <algorithm>

namespace seam::measurement {
namespace {

// Degrees of the polynomials: of the direction alone, of the state alone, and of both in their
// products.
struct Degrees {
  int field, state, field_of_products, state_of_products;
};
constexpr Degrees kDegrees[] = {{7, 3, 3, 2}, {7, 3, 3, 1}, {5, 2, 2, 1}, {4, 1, 1, 1},
                                {3, 1, 0, 0}, {2, 0, 0, 0}, {1, 0, 0, 0}};

// What is smooth in where a point is seen and how the head moves then.
Eigen::MatrixXd columns_of_degrees(const std::vector<std::vector<double>>& direction,
                                   const std::vector<std::vector<double>>& state,
                                   const Degrees& degrees) {
  const auto but_constant = [](const Eigen::MatrixXd& all) {
    return Eigen::MatrixXd(all.rightCols(all.cols() - 1));
  };
  const Eigen::MatrixXd field = monomials(direction, degrees.field);
  if (state.empty()) return field;
  const Eigen::MatrixXd alone = but_constant(monomials(state, degrees.state));
  const Eigen::MatrixXd a = but_constant(monomials(direction, degrees.field_of_products));
  const Eigen::MatrixXd b = but_constant(monomials(state, degrees.state_of_products));
  Eigen::MatrixXd all(field.rows(), field.cols() + alone.cols() + a.cols() * b.cols());
  all << field, alone, Eigen::MatrixXd(field.rows(), a.cols() * b.cols());
  Eigen::Index at = field.cols() + alone.cols();
  for (Eigen::Index m = 0; m < b.cols(); ++m) {
    for (Eigen::Index k = 0; k < a.cols(); ++k) all.col(at++) = b.col(m).cwiseProduct(a.col(k));
  }
  return all;
}

}  // namespace

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

Eigen::MatrixXd smooth_columns(const std::vector<std::vector<double>>& direction,
                               const std::vector<std::vector<double>>& state) {
  Eigen::MatrixXd A;
  for (const Degrees& degrees : kDegrees) {
    A = columns_of_degrees(direction, state, degrees);
    if (2 * A.cols() <= A.rows()) break;
  }
  return A;
}

Eigen::MatrixXd image_columns(std::vector<std::vector<double>> places, int most_degree) {
  for (auto& x : places) x = standardised(x);
  constexpr size_t kRowsAColumn = 10;
  const auto columns = [](int d) { return static_cast<size_t>((d + 1) * (d + 2) / 2); };
  int degree = most_degree;
  while (degree > 0 && columns(degree) * kRowsAColumn > places[0].size()) --degree;
  Eigen::MatrixXd all = monomials(places, degree);
  all.colwise().normalize();
  return all;
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
