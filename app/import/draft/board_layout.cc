#include "app/import/draft/board_layout.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

// Of a full grid, counted row by row.
struct Layout {
  size_t columns = 0, rows = 0;
  double spacing_x_m = 0, spacing_y_m = 0;
};

Layout layout_of(const std::vector<SeenView>& views) {
  std::set<double> x, y;
  for (const SeenView& view : views) {
    for (const SeenCorner& corner : view.corners) x.insert(corner.p_W.x), y.insert(corner.p_W.y);
  }
  if (x.size() < 2 || y.size() < 2) return {};
  const auto step = [](const std::set<double>& all) {
    return (*all.rbegin() - *all.begin()) / static_cast<double>(all.size() - 1);
  };
  return {x.size(), y.size(), step(x), step(y)};
}

bool is_counted_by_rows(const SeenCorner& corner, const Layout& layout) {
  constexpr double kNear = 0.01;  // Of a spacing.
  const double column = static_cast<double>(corner.point % layout.columns),
               row = static_cast<double>(corner.point / layout.columns);
  return std::abs(corner.p_W.x / layout.spacing_x_m - column) < kNear &&
         std::abs(corner.p_W.y / layout.spacing_y_m - row) < kNear;
}

// Over the corners' own spread, so that near and far views count alike.
double misfit_of(const std::vector<SeenCorner>& corners) {
  double u = 0, v = 0, size = 0;
  for (const SeenCorner& c : corners) u += c.u_px, v += c.v_px;
  u /= static_cast<double>(corners.size()), v /= static_cast<double>(corners.size());
  for (const SeenCorner& c : corners)
    size = std::max({size, std::abs(c.u_px - u), std::abs(c.v_px - v)});
  return size > 0 ? plane_map(corners, u, v, size).misfit : 0;
}

}  // namespace

bool is_flat(const SeenView& view) {
  return std::all_of(view.corners.begin(), view.corners.end(),
                     [](const SeenCorner& c) { return c.p_W.z == 0; });
}

PlaneMap plane_map(const std::vector<SeenCorner>& corners, double centre_u_px, double centre_v_px,
                   double scale_px) {
  double x0 = 0, y0 = 0, size = 0;
  for (const SeenCorner& c : corners) x0 += c.p_W.x, y0 += c.p_W.y;
  x0 /= static_cast<double>(corners.size()), y0 /= static_cast<double>(corners.size());
  for (const SeenCorner& c : corners)
    size = std::max({size, std::abs(c.p_W.x - x0), std::abs(c.p_W.y - y0)});
  Eigen::MatrixXd a(2 * corners.size(), 9);
  for (size_t i = 0; i < corners.size(); ++i) {
    const SeenCorner& c = corners[i];
    const double x = (c.p_W.x - x0) / size, y = (c.p_W.y - y0) / size;
    const double u = (c.u_px - centre_u_px) / scale_px, v = (c.v_px - centre_v_px) / scale_px;
    const auto row = static_cast<Eigen::Index>(2 * i);
    a.row(row) << x, y, 1, 0, 0, 0, -u * x, -u * y, -u;
    a.row(row + 1) << 0, 0, 0, x, y, 1, -v * x, -v * y, -v;
  }
  const Eigen::MatrixXd squares = a.transpose() * a;
  const auto eigen = measurement::symmetric_eigen(squares);
  const Eigen::VectorXd h = eigen.vectors.col(0);
  PlaneMap found;
  found.map << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8];
  const double equations = static_cast<double>(a.rows());
  found.misfit = std::sqrt(std::max(0.0, eigen.values[0]) / equations) / std::abs(h[8]);
  return found;
}

void check_layout(const std::vector<SeenView>& views, const std::string& file) {
  constexpr double kPlainlyBetter = 4, kFewest = 8;  // Times; corners of a view.
  const Layout layout = layout_of(views);
  if (layout.columns == layout.rows || layout.columns < 2) return;
  std::vector<double> as_stated, exchanged;
  for (const SeenView& view : views) {
    if (view.corners.size() < kFewest || !is_flat(view)) continue;
    std::vector<SeenCorner> corners = view.corners;
    for (SeenCorner& corner : corners) {
      if (!is_counted_by_rows(corner, layout)) return;
      corner.p_W = {static_cast<double>(corner.point % layout.rows) * layout.spacing_x_m,
                    static_cast<double>(corner.point / layout.rows) * layout.spacing_y_m, 0};
    }
    as_stated.push_back(misfit_of(view.corners));
    exchanged.push_back(misfit_of(corners));
  }
  if (as_stated.empty()) return;
  const double stated = measurement::median_of(as_stated),
               other = measurement::median_of(exchanged);
  if (stated < kPlainlyBetter * other) return;
  throw InputError(fmt::format(
      "{}: the corners do not lie on a board of {}x{} corners but fit one of {}x{}: exchange its "
      "columns and rows (--board {}x{}, or the target's YAML)",
      file, layout.columns, layout.rows, layout.rows, layout.columns, layout.rows, layout.columns));
}

}  // namespace seam::app
