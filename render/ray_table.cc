#include "render/ray_table.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "sim_core/error.h"

namespace seam::render {
namespace {

using effects::ImagePoint;
using effects::Projection;

struct RayWithSlopes {
  Vec3 ray;
  Vec3 along_u;
  Vec3 along_v;
};

// One image point's ray by Newton's method from the neighbour's, which one or two steps refine.
// Perspective rays only (z = 1).
class RayFinder {
 public:
  RayFinder(const Projection& projection, int channel, double t_s)
      : projection_(projection), channel_(channel), t_s_(t_s) {}

  std::optional<RayWithSlopes> find(double u, double v, const RayWithSlopes* neighbour) const {
    std::optional<RayWithSlopes> found;
    if (neighbour && neighbour->ray.z == 1) found = refine(neighbour->ray, u, v);
    if (found) return found;
    const std::optional<Vec3> ray = projection_.unproject(u, v, t_s_, channel_);
    if (!ray) return std::nullopt;
    if (ray->z == 1) return refine(*ray, u, v);
    // A fisheye's rays have no common plane; its slopes are differences between rays.
    constexpr double kHalf = 0.25;
    const auto left = projection_.unproject(u - kHalf, v, t_s_, channel_);
    const auto right = projection_.unproject(u + kHalf, v, t_s_, channel_);
    const auto above = projection_.unproject(u, v - kHalf, t_s_, channel_);
    const auto below = projection_.unproject(u, v + kHalf, t_s_, channel_);
    if (!left || !right || !above || !below) return std::nullopt;
    const auto unit = [](const Vec3& d) { return d / std::sqrt(glm::dot(d, d)); };
    return RayWithSlopes{unit(*ray), (unit(*right) - unit(*left)) / (2 * kHalf),
                         (unit(*below) - unit(*above)) / (2 * kHalf)};
  }

 private:
  std::optional<RayWithSlopes> refine(Vec3 ray, double u, double v) const {
    for (int step = 0; step < 8; ++step) {
      const ImagePoint here = at(ray.x, ray.y, v);
      if (!here.visible) return std::nullopt;
      constexpr double kStep = 1e-6;
      const ImagePoint px = at(ray.x + kStep, ray.y, v), py = at(ray.x, ray.y + kStep, v);
      if (!px.visible || !py.visible) return std::nullopt;
      const double a = (px.u - here.u) / kStep, b = (py.u - here.u) / kStep;
      const double c = (px.v - here.v) / kStep, d = (py.v - here.v) / kStep;
      const double determinant = a * d - b * c;
      if (!(determinant > 0)) return std::nullopt;
      const double error_u = u - here.u, error_v = v - here.v;
      if (std::abs(error_u) < 1e-7 && std::abs(error_v) < 1e-7) {
        return RayWithSlopes{ray, Vec3(d, -c, 0) / determinant, Vec3(-b, a, 0) / determinant};
      }
      ray.x += (d * error_u - b * error_v) / determinant;
      ray.y += (a * error_v - c * error_u) / determinant;
    }
    return std::nullopt;
  }

  ImagePoint at(double x, double y, double v) const { return projection_.project({x, y, 1}, t_s_, v, channel_); }

  const Projection& projection_;
  int channel_;
  double t_s_;
};

using RayGrid = std::vector<std::optional<RayWithSlopes>>;

// From the middle row outwards, so that a ray's neighbour is known.
RayGrid find_rays(const Projection& projection, int border, int channel, double t_s) {
  const int columns = projection.width_px() + 2 * border, rows = projection.height_px() + 2 * border;
  const RayFinder finder(projection, channel, t_s);
  RayGrid grid(static_cast<size_t>(columns) * rows);
  const auto cell = [&](int column, int row) -> std::optional<RayWithSlopes>& {
    return grid[static_cast<size_t>(row) * columns + column];
  };
  const auto fill = [&](int column, int row, int from_column, int from_row) {
    const auto& neighbour = cell(from_column, from_row);
    cell(column, row) = finder.find(column - border, row - border, neighbour ? &*neighbour : nullptr);
  };
  const int middle_row = rows / 2, middle_column = columns / 2;
  const auto fill_row = [&](int row) {
    for (int column = middle_column + 1; column < columns; ++column) fill(column, row, column - 1, row);
    for (int column = middle_column - 1; column >= 0; --column) fill(column, row, column + 1, row);
  };
  fill(middle_column, middle_row, middle_column, middle_row);
  fill_row(middle_row);
  for (int row = middle_row + 1; row < rows; ++row) fill(middle_column, row, middle_column, row - 1), fill_row(row);
  for (int row = middle_row - 1; row >= 0; --row) fill(middle_column, row, middle_column, row + 1), fill_row(row);
  return grid;
}

// The nearest image pixel's ray continued by its slopes.
RayWithSlopes extrapolated(const RayGrid& grid, const Projection& projection, int border, int column, int row) {
  const int columns = projection.width_px() + 2 * border;
  const int u = std::clamp(column - border, 0, projection.width_px() - 1);
  const int v = std::clamp(row - border, 0, projection.height_px() - 1);
  RayWithSlopes ray = *grid[static_cast<size_t>(v + border) * columns + u + border];
  ray.ray += static_cast<double>(column - border - u) * ray.along_u + static_cast<double>(row - border - v) * ray.along_v;
  return ray;
}

void check_image_has_rays(const RayGrid& grid, const Projection& projection, int border, const std::string& model) {
  const int columns = projection.width_px() + 2 * border;
  for (int v = 0; v < projection.height_px(); ++v) {
    for (int u = 0; u < projection.width_px(); ++u) {
      if (grid[static_cast<size_t>(v + border) * columns + u + border]) continue;
      throw InputError(fmt::format(
          "model '{}': effects of stage geometry: no ray leads to pixel ({}, {}) of {}x{}, expected a calibration "
          "that can be inverted over the whole image (is a distortion too strong?)",
          model, u, v, projection.width_px(), projection.height_px()));
    }
  }
}

// How far a pixel's samples lie from its centre, in x (component 0) or y (1).
float reach_of(const RayTable& table, int component, size_t i) {
  return 0.5f * (std::abs(table.along_u[component][i]) + std::abs(table.along_v[component][i])) + 1e-6f;
}

void bound_rows(RayTable& table) {
  table.row_y_min.assign(table.rows(), 1e30f);
  table.row_y_max.assign(table.rows(), -1e30f);
  for (int row = 0; row < table.rows(); ++row) {
    for (size_t i = table.at(row); i < table.at(row + 1); ++i) {
      table.row_y_min[row] = std::min(table.row_y_min[row], table.base[1][i] - reach_of(table, 1, i));
      table.row_y_max[row] = std::max(table.row_y_max[row], table.base[1][i] + reach_of(table, 1, i));
    }
  }
  for (int row = 1; row < table.rows(); ++row) {
    table.row_y_max[row] = std::max(table.row_y_max[row], table.row_y_max[row - 1]);
  }
  for (int row = table.rows() - 2; row >= 0; --row) {
    table.row_y_min[row] = std::min(table.row_y_min[row], table.row_y_min[row + 1]);
  }
}

void bound_columns(RayTable& table) {
  constexpr int kBins = RayTable::kColumnBins;
  table.x_min = 1e30f, table.x_max = -1e30f;
  for (size_t i = 0; i < table.base[0].size(); ++i) {
    table.x_min = std::min(table.x_min, table.base[0][i] - reach_of(table, 0, i));
    table.x_max = std::max(table.x_max, table.base[0][i] + reach_of(table, 0, i));
  }
  table.bins_per_x = kBins / (table.x_max - table.x_min);
  table.first_column.resize(static_cast<size_t>(table.rows()) * kBins);
  table.last_column.resize(table.first_column.size());
  // A bin is taken a little wider than it is, for the rounding of `columns_between`.
  const float slack = 1e-3f / table.bins_per_x;
  for (int row = 0; row < table.rows(); ++row) {
    for (int bin = 0; bin < kBins; ++bin) {
      const float begin = table.x_min + static_cast<float>(bin) / table.bins_per_x - slack;
      const float end = table.x_min + static_cast<float>(bin + 1) / table.bins_per_x + slack;
      const size_t offset = table.at(row);
      int first = 0, last = table.columns() - 1;
      while (first < table.columns() && table.base[0][offset + first] + reach_of(table, 0, offset + first) < begin) ++first;
      while (last >= 0 && table.base[0][offset + last] - reach_of(table, 0, offset + last) > end) --last;
      table.first_column[static_cast<size_t>(row) * kBins + bin] = static_cast<int16_t>(first);
      table.last_column[static_cast<size_t>(row) * kBins + bin] = static_cast<int16_t>(last);
    }
  }
}

}  // namespace

RayTable make_ray_table(const Projection& projection, const std::string& model_name, int border_px, int channel,
                        double t_s) {
  const RayGrid grid = find_rays(projection, border_px, channel, t_s);
  check_image_has_rays(grid, projection, border_px, model_name);
  RayTable table{.width_px = projection.width_px(), .height_px = projection.height_px(), .border_px = border_px};
  for (int k = 0; k < 3; ++k) {
    for (auto* values : {&table.base[k], &table.along_u[k], &table.along_v[k]}) values->resize(grid.size());
  }
  for (int row = 0; row < table.rows(); ++row) {
    for (int column = 0; column < table.columns(); ++column) {
      const size_t i = table.at(row) + column;
      const RayWithSlopes ray = grid[i] ? *grid[i] : extrapolated(grid, projection, border_px, column, row);
      if (ray.ray.z != 1) table.perspective = false;
      for (int k = 0; k < 3; ++k) {
        table.base[k][i] = static_cast<float>(ray.ray[k]);
        table.along_u[k][i] = static_cast<float>(ray.along_u[k]);
        table.along_v[k][i] = static_cast<float>(ray.along_v[k]);
      }
    }
  }
  bound_rows(table);
  bound_columns(table);
  return table;
}

bool geometry_varies_with_time(const Projection& projection) {
  for (const Vec3& direction : {Vec3(0.1, 0.07, 1), Vec3(-0.3, 0.2, 1), Vec3(0.25, -0.21, 1)}) {
    const ImagePoint first = projection.project(direction, 0);
    for (const double t_s : {0.37, 11.3}) {
      const ImagePoint later = projection.project(direction, t_s);
      if (later.u != first.u || later.v != first.v) return true;
    }
  }
  return false;
}

}  // namespace seam::render
