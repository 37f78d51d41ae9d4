#include "render/cast/ray_table.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "sim_core/base/error.h"

namespace seam::render {
namespace {

using effects::ImagePoint;
using effects::Projection;

struct RayWithSlopes {
  Vec3 ray;
  Vec3 along_u;
  Vec3 along_v;
};

// One image point's ray by Newton's method from where the neighbour's slopes put it, which a step
// refines where the lens bends rays.
// Perspective rays only (z = 1).
class RayFinder {
 public:
  RayFinder(const Projection& projection, int channel, double t_s)
      : projection_(projection), channel_(channel), t_s_(t_s) {}

  // `columns` and `rows`: the way from the neighbour.
  std::optional<RayWithSlopes> find(double u, double v, const RayWithSlopes* neighbour, int columns,
                                    int rows) const {
    std::optional<RayWithSlopes> found;
    if (neighbour && neighbour->ray.z == 1)
      found = refine(neighbour->ray + static_cast<double>(columns) * neighbour->along_u +
                         static_cast<double>(rows) * neighbour->along_v,
                     u, v);
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

  ImagePoint at(double x, double y, double v) const {
    return projection_.project({x, y, 1}, t_s_, v, channel_);
  }

  const Projection& projection_;
  int channel_;
  double t_s_;
};

using RayGrid = std::vector<std::optional<RayWithSlopes>>;

[[noreturn]] void fail_without_ray(const Projection& projection, const std::string& subject,
                                   int channel, double t_s, int u, int v) {
  projection.check_at(u, v, t_s, channel);
  throw InputError(
      fmt::format("{}: no ray leads to pixel ({}, {}) of {}x{}, expected a calibration that can "
                  "be inverted over the whole image (is a distortion too strong?)",
                  subject, u, v, projection.width_px(), projection.height_px()));
}

// From the middle row outwards, so that a ray's neighbour is known. The first pixel of the image
// without a ray ends it: beyond a fold each takes thousands of projections to fail.
RayGrid find_rays(const Projection& projection, const std::string& subject, int border, int channel,
                  double t_s) {
  const int columns = projection.width_px() + 2 * border,
            rows = projection.height_px() + 2 * border;
  const RayFinder finder(projection, channel, t_s);
  RayGrid grid(static_cast<size_t>(columns) * rows);
  const auto cell = [&](int column, int row) -> std::optional<RayWithSlopes>& {
    return grid[static_cast<size_t>(row) * columns + column];
  };
  const auto fill = [&](int column, int row, int from_column, int from_row) {
    const auto& neighbour = cell(from_column, from_row);
    cell(column, row) =
        finder.find(column - border, row - border, neighbour ? &*neighbour : nullptr,
                    column - from_column, row - from_row);
    const int u = column - border, v = row - border;
    const bool inside = u >= 0 && v >= 0 && u < projection.width_px() && v < projection.height_px();
    if (inside && !cell(column, row)) fail_without_ray(projection, subject, channel, t_s, u, v);
  };
  const int middle_row = rows / 2, middle_column = columns / 2;
  const auto fill_row = [&](int row) {
    for (int column = middle_column + 1; column < columns; ++column)
      fill(column, row, column - 1, row);
    for (int column = middle_column - 1; column >= 0; --column) fill(column, row, column + 1, row);
  };
  fill(middle_column, middle_row, middle_column, middle_row);
  fill_row(middle_row);
  for (int row = middle_row + 1; row < rows; ++row)
    fill(middle_column, row, middle_column, row - 1), fill_row(row);
  for (int row = middle_row - 1; row >= 0; --row)
    fill(middle_column, row, middle_column, row + 1), fill_row(row);
  return grid;
}

// The nearest image pixel's ray continued by its slopes.
RayWithSlopes extrapolated(const RayGrid& grid, const Projection& projection, int border,
                           int column, int row) {
  const int columns = projection.width_px() + 2 * border;
  const int u = std::clamp(column - border, 0, projection.width_px() - 1);
  const int v = std::clamp(row - border, 0, projection.height_px() - 1);
  RayWithSlopes ray = *grid[static_cast<size_t>(v + border) * columns + u + border];
  ray.ray += static_cast<double>(column - border - u) * ray.along_u +
             static_cast<double>(row - border - v) * ray.along_v;
  return ray;
}

RayTable make_table(const Projection& projection, const std::string& subject, int border,
                    int channel, double t_s, bool& perspective) {
  const RayGrid grid = find_rays(projection, subject, border, channel, t_s);
  RayTable table;
  for (int k = 0; k < 3; ++k) {
    for (auto* values : {&table.base[k], &table.along_u[k], &table.along_v[k]})
      values->resize(grid.size());
  }
  const int columns = projection.width_px() + 2 * border;
  for (size_t i = 0; i < grid.size(); ++i) {
    const int column = static_cast<int>(i) % columns, row = static_cast<int>(i) / columns;
    const RayWithSlopes ray =
        grid[i] ? *grid[i] : extrapolated(grid, projection, border, column, row);
    if (ray.ray.z != 1) perspective = false;
    for (int k = 0; k < 3; ++k) {
      table.base[k][i] = static_cast<float>(ray.ray[k]);
      table.along_u[k][i] = static_cast<float>(ray.along_u[k]);
      table.along_v[k][i] = static_cast<float>(ray.along_v[k]);
    }
  }
  return table;
}

// The least and greatest x (component 0) or y (1) of the samples of a pixel.
struct Reach {
  float low, high;
};

Reach reach_of(const CameraRays& rays, int component, size_t i) {
  Reach reach{1e30f, -1e30f};
  for (const RayTable& table : rays.tables) {
    const float half =
        0.5f * (std::abs(table.along_u[component][i]) + std::abs(table.along_v[component][i])) +
        1e-6f;
    reach.low = std::min(reach.low, table.base[component][i] - half);
    reach.high = std::max(reach.high, table.base[component][i] + half);
  }
  return reach;
}

void bound_rows(CameraRays& rays) {
  rays.row_y_min.assign(rays.rows(), 1e30f);
  rays.row_y_max.assign(rays.rows(), -1e30f);
  for (int row = 0; row < rays.rows(); ++row) {
    for (size_t i = rays.at(row); i < rays.at(row + 1); ++i) {
      const Reach reach = reach_of(rays, 1, i);
      rays.row_y_min[row] = std::min(rays.row_y_min[row], reach.low);
      rays.row_y_max[row] = std::max(rays.row_y_max[row], reach.high);
    }
  }
  for (int row = 1; row < rays.rows(); ++row) {
    rays.row_y_max[row] = std::max(rays.row_y_max[row], rays.row_y_max[row - 1]);
  }
  for (int row = rays.rows() - 2; row >= 0; --row) {
    rays.row_y_min[row] = std::min(rays.row_y_min[row], rays.row_y_min[row + 1]);
  }
}

void bound_columns(CameraRays& rays) {
  constexpr int kBins = CameraRays::kColumnBins;
  const int columns = rays.columns();
  std::vector<Reach> reaches(rays.at(rays.rows()));
  rays.x_min = 1e30f, rays.x_max = -1e30f;
  for (size_t i = 0; i < reaches.size(); ++i) {
    reaches[i] = reach_of(rays, 0, i);
    rays.x_min = std::min(rays.x_min, reaches[i].low);
    rays.x_max = std::max(rays.x_max, reaches[i].high);
  }
  rays.bins_per_x = kBins / (rays.x_max - rays.x_min);
  rays.first_column.resize(static_cast<size_t>(rays.rows()) * kBins);
  rays.last_column.resize(rays.first_column.size());
  // A bin is taken a little wider than it is, for the rounding of `columns_between`.
  const float slack = 1e-3f / rays.bins_per_x;
  for (int row = 0; row < rays.rows(); ++row) {
    const Reach* reach = &reaches[rays.at(row)];
    const size_t offset = static_cast<size_t>(row) * kBins;
    // Both ends only move one way as the bins ascend.
    for (int bin = 0, first = 0; bin < kBins; ++bin) {
      const float begin = rays.x_min + static_cast<float>(bin) / rays.bins_per_x - slack;
      while (first < columns && reach[first].high < begin) ++first;
      rays.first_column[offset + bin] = static_cast<int16_t>(first);
    }
    for (int bin = kBins - 1, last = columns - 1; bin >= 0; --bin) {
      const float end = rays.x_min + static_cast<float>(bin + 1) / rays.bins_per_x + slack;
      while (last >= 0 && reach[last].low > end) --last;
      rays.last_column[offset + bin] = static_cast<int16_t>(last);
    }
  }
}

double focal_px(const CameraRays& rays) {
  // Pixels per unit of x and y are the inverse of the rays' steps.
  double least = 1e30;
  const RayTable& green = rays.table(1);
  for (size_t i = 0; i < green.base[0].size(); ++i) {
    const auto length2 = [&](const std::vector<float>(&along)[3]) {
      double sum = 0;
      for (const std::vector<float>& component : along)
        sum += static_cast<double>(component[i]) * component[i];
      return sum;
    };
    least = std::min({least, length2(green.along_u), length2(green.along_v)});
  }
  return 1 / std::sqrt(least);
}

}  // namespace

CameraRays make_camera_rays(const Projection& projection, const std::string& subject, int border_px,
                            double t_s) {
  CameraRays rays{.width_px = projection.width_px(),
                  .height_px = projection.height_px(),
                  .border_px = border_px,
                  .tables = {},
                  .row_y_min = {},
                  .row_y_max = {},
                  .first_column = {},
                  .last_column = {}};
  const bool apart = colours_have_own_rays(projection);
  for (int channel = apart ? 0 : 1; channel < (apart ? 3 : 2); ++channel) {
    rays.tables.push_back(
        make_table(projection, subject, border_px, channel, t_s, rays.perspective));
  }
  rays.focal_px = focal_px(rays);
  bound_rows(rays);
  bound_columns(rays);
  return rays;
}

bool colours_have_own_rays(const Projection& projection) {
  for (const Vec3& direction : {Vec3(0.1, 0.07, 1), Vec3(-0.3, 0.2, 1)}) {
    const ImagePoint green = projection.project(direction, 0, 0, 1);
    for (const int channel : {0, 2}) {
      const ImagePoint other = projection.project(direction, 0, 0, channel);
      if (other.u != green.u || other.v != green.v) return true;
    }
  }
  return false;
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
