#include "app/import/pictures/scatter.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "measurement/numerics/linear_algebra.h"

namespace seam::app {
namespace {

// One view's corners by their map.
struct Mapped {
  Eigen::MatrixXd left;  // A row a corner: what the map leaves, u and v.
  double freedom = 0;    // Rows less what the map takes.
};

Eigen::MatrixXd powers(const Eigen::MatrixXd& xy, int degree) {
  std::vector<Eigen::VectorXd> columns;
  for (int a = 0; a <= degree; ++a) {
    for (int b = 0; a + b <= degree; ++b)
      columns.emplace_back(xy.col(0).array().pow(a) * xy.col(1).array().pow(b));
  }
  Eigen::MatrixXd basis(xy.rows(), static_cast<Eigen::Index>(columns.size()));
  for (size_t i = 0; i < columns.size(); ++i) basis.col(static_cast<Eigen::Index>(i)) = columns[i];
  return basis;
}

Mapped mapped(const SeenView& view) {
  const auto rows = static_cast<Eigen::Index>(view.corners.size());
  Eigen::MatrixXd xy(rows, 2), uv(rows, 2);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const SeenCorner& c = view.corners[static_cast<size_t>(i)];
    xy.row(i) << c.p_W.x, c.p_W.y;
    uv.row(i) << c.u_px, c.v_px;
  }
  // Both about their middles, of unit size.
  const Eigen::RowVector2d xy0 = xy.colwise().mean(), uv0 = uv.colwise().mean();
  xy.rowwise() -= xy0, uv.rowwise() -= uv0;
  const double size = xy.cwiseAbs().maxCoeff(), scale = std::max(uv.cwiseAbs().maxCoeff(), 1.0);
  xy /= std::max(size, 1e-12);
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(2 * rows, 9);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const double x = xy(i, 0), y = xy(i, 1), u = uv(i, 0) / scale, v = uv(i, 1) / scale;
    a.row(2 * i) << x, y, 1, 0, 0, 0, -u * x, -u * y, -u;
    a.row(2 * i + 1) << 0, 0, 0, x, y, 1, -v * x, -v * y, -v;
  }
  const Eigen::MatrixXd squares = a.transpose() * a;
  const Eigen::VectorXd h = measurement::symmetric_eigen(squares).vectors.col(0);
  Mapped result{.left = uv};
  bool flat = false;              // The map shows the target's plane as a line.
  Eigen::MatrixXd seen(rows, 2);  // As the perspective has it, of unit size.
  for (Eigen::Index i = 0; i < rows; ++i) {
    const double x = xy(i, 0), y = xy(i, 1), w = h[6] * x + h[7] * y + h[8];
    const double u = (h[0] * x + h[1] * y + h[2]) / w, v = (h[3] * x + h[4] * y + h[5]) / w;
    seen.row(i) << u, v;
    result.left.row(i) -= scale * seen.row(i);
    Eigen::Matrix2d j;
    j << h[0] - u * h[6], h[1] - u * h[7], h[3] - v * h[6], h[4] - v * h[7];
    flat = flat || !(std::abs((scale / (w * size) * j).determinant()) > 1e-9);
  }
  // What a lens bends, as far as the corners constrain it: a polynomial over the picture, since
  // over a tilted target the same bend is none.
  const int degree = rows >= 24 ? 3 : rows >= 14 ? 2 : 1;
  const Eigen::MatrixXd basis = powers(seen, degree);
  result.left -= basis * measurement::solve_any_rank(basis, result.left);
  // A perspective has two more than the straight part of the basis.
  const double taken = static_cast<double>(basis.cols()) + (degree == 1 ? 1 : 0);
  result.freedom = std::max(0.0, static_cast<double>(rows) - taken);
  if (flat || !result.left.allFinite()) result.freedom = 0;
  return result;
}

}  // namespace

Scatter scatter_of(const std::vector<SeenView>& views) {
  std::vector<Mapped> maps;
  for (const SeenView& view : views)
    maps.push_back(view.corners.size() >= 6 ? mapped(view) : Mapped{});
  Scatter scatter;
  std::vector<double> sizes;
  for (const Mapped& map : maps) {
    scatter.view_px.push_back(
        map.freedom > 0 ? std::sqrt(map.left.squaredNorm() / (2 * map.freedom)) : 0);
    if (map.freedom > 0) sizes.push_back(scatter.view_px.back());
  }
  if (sizes.empty()) return scatter;
  std::sort(sizes.begin(), sizes.end());
  scatter.all_px = sizes[sizes.size() / 2];  // A few bad pictures do not count.
  constexpr double kPrior = 20;              // Corners that the sigma of all is worth.
  for (size_t v = 0; v < maps.size(); ++v) {
    const double own = maps[v].freedom, size = scatter.view_px[v];
    scatter.view_px[v] =
        std::sqrt((own * size * size + kPrior * scatter.all_px * scatter.all_px) / (own + kPrior));
  }
  return scatter;
}

}  // namespace seam::app
