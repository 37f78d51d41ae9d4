#include "render/gl/film_strip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "render/cast/parallel.h"
#include "render/gl/gather_kernels.h"
#include "sim_core/base/error.h"

namespace seam::render::gl {
namespace {

using Vec3f = std::array<float, 3>;

// The side of the cube around the camera that a direction meets: 0 ahead, then right, left, down,
// up, behind.
int side_of(const Vec3f& d) {
  const float x = std::abs(d[0]), y = std::abs(d[1]), z = std::abs(d[2]);
  if (d[2] >= x && d[2] >= y) return 0;
  if (x >= y && x >= z) return d[0] > 0 ? 1 : 2;
  if (y >= z) return d[1] > 0 ? 3 : 4;
  return 5;
}

Mat3 side_axes(int side) {
  constexpr int kAlong[6][3] = {{0, 0, 1}, {1, 0, 0},  {-1, 0, 0},
                                {0, 1, 0}, {0, -1, 0}, {0, 0, -1}};
  const Vec3 z(kAlong[side][0], kAlong[side][1], kAlong[side][2]);
  const Vec3 x = side == 1 ? Vec3(0, 0, -1) : side == 2 ? Vec3(0, 0, 1) : Vec3(1, 0, 0);
  return Mat3(x, glm::cross(z, x), z);
}

// A direction on the plane z = 1 of a view.
struct OnView {
  float x, y;
};
OnView on_view(const Mat3& R_CV, const Vec3f& d) {
  const auto along = [&](int axis) {
    return static_cast<float>(R_CV[axis].x) * d[0] + static_cast<float>(R_CV[axis].y) * d[1] +
           static_cast<float>(R_CV[axis].z) * d[2];
  };
  const float z = along(2);
  return {along(0) / z, along(1) / z};
}

Vec3f ray_at(const RayTable& table, size_t i, float du, float dv) {
  Vec3f d;
  for (int k = 0; k < 3; ++k)
    d[k] = table.base[k][i] + du * table.along_u[k][i] + dv * table.along_v[k][i];
  return d;
}

void bound(const CameraRays& rays, StripView& view) {
  view.x_min = 1e30f, view.x_max = -1e30f;
  view.row_y_min.assign(rays.rows(), 1e30f);
  view.row_y_max.assign(rays.rows(), -1e30f);
  for (int row = 0; row < rays.rows(); ++row) {
    for (size_t i = rays.at(row); i < rays.at(row + 1); ++i) {
      for (const RayTable& table : rays.tables) {
        for (int corner = 0; corner < 9; ++corner) {
          const Vec3f d = ray_at(table, i, 0.5f * static_cast<float>(corner % 3 - 1),
                                 0.5f * static_cast<float>(corner / 3 - 1));
          if (side_of(d) != view.side) continue;
          const OnView at = on_view(view.R_CV, d);
          view.x_min = std::min(view.x_min, at.x), view.x_max = std::max(view.x_max, at.x);
          view.row_y_min[row] = std::min(view.row_y_min[row], at.y);
          view.row_y_max[row] = std::max(view.row_y_max[row], at.y);
        }
      }
    }
  }
}

int floor_of(float value) {
  return static_cast<int>(std::floor(value));
}

// Looks up rows' samples on a page.
class Gather {
 public:
  Gather(const Page& page, const StripScale& scale, const float* texels,
         const std::vector<Colour>* palette, const StripView& view, const CameraRays& rays)
      : page_(page),
        scale_(scale),
        texels_(texels),
        palette_(palette ? palette->data() : nullptr),
        view_(view),
        rays_(rays),
        found_(rays.columns()),
        sums_(4 * static_cast<size_t>(rays.columns())) {}

  void add_row(const Band& band, int row, float weight, LinearImage& image) {
    const float step_u = 1.0f / static_cast<float>(scale_.across);
    const float step_v = 1.0f / static_cast<float>(scale_.down);
    for (size_t channel = 0; channel < rays_.tables.size(); ++channel) {
      std::fill(sums_.begin(), sums_.end(), 0.0f);
      for (int b = 0; b < scale_.down; ++b) {
        const float dv = (static_cast<float>(b) + 0.5f) * step_v - 0.5f;
        for (int a = 0; a < scale_.across; ++a) {
          const float du = (static_cast<float>(a) + 0.5f) * step_u - 0.5f;
          if (rays_.perspective)
            add_flat(band, row, channel, du, dv);
          else
            add_side(band, row, channel, du, dv);
        }
      }
      put(row, channel, weight * step_u * step_v, image);
    }
  }

 private:
  bool colours_apart() const { return rays_.tables.size() > 1; }
  TexelGrid grid_of(const Band& band) const {
    return {scale_.u_per_unit,
            scale_.shear * scale_.v_per_unit,
            scale_.v_per_unit,
            band.shift_u - static_cast<float>(band.first_x),
            band.shift_v - static_cast<float>(band.first_y),
            page_.width,
            band.height};
  }
  const float* texels_of(const Band& band) const {
    return texels_ + (palette_ ? 1 : 4) * static_cast<size_t>(band.page_y) * page_.width;
  }

  void add_flat(const Band& band, int row, size_t channel, float du, float dv) {
    const RayTable& table = rays_.tables[channel];
    const size_t first = rays_.at(row);
    const auto slopes = [&](int k) {
      return RaySlopes{&table.base[k][first], &table.along_u[k][first], &table.along_v[k][first]};
    };
    kernels_.find(slopes(0), slopes(1), du, dv, grid_of(band), rays_.columns(), found_.data());
    const float* const texels = texels_of(band);
    const int columns = rays_.columns();
    if (palette_ && colours_apart())
      kernels_.add_indexed_one(texels, found_.data(), &palette_->rgb[channel], columns,
                               sums_.data());
    else if (palette_)
      kernels_.add_indexed(texels, found_.data(), palette_, columns, sums_.data());
    else if (colours_apart())
      kernels_.add_one(texels + channel, found_.data(), columns, sums_.data());
    else
      kernels_.add(texels, found_.data(), columns, sums_.data());
  }

  // Of the samples that this side of the cube shows.
  void add_side(const Band& band, int row, size_t channel, float du, float dv) {
    const TexelGrid grid = grid_of(band);
    const float* const texels = texels_of(band);
    for (int column = 0; column < rays_.columns(); ++column) {
      const Vec3f d = ray_at(rays_.tables[channel], rays_.at(row) + column, du, dv);
      if (side_of(d) != view_.side) continue;
      const OnView at = on_view(view_.R_CV, d);
      const auto u = static_cast<int>(at.x * grid.u_per_x + at.y * grid.u_per_y + grid.offset_u);
      const auto v = static_cast<int>(at.y * grid.v_per_y + grid.offset_v);
      const size_t texel = static_cast<size_t>(std::clamp(v, 0, grid.height - 1)) * grid.width +
                           std::clamp(u, 0, grid.width - 1);
      const float* const seen =
          palette_ ? palette_[static_cast<int>(texels[texel])].rgb : texels + 4 * texel;
      if (colours_apart())
        sums_[column] += seen[channel];
      else
        for (int c = 0; c < 3; ++c) sums_[4 * column + c] += seen[c];
    }
  }

  void put(int row, size_t channel, float share, LinearImage& image) const {
    const size_t first = rays_.at(row);
    const auto columns = static_cast<size_t>(rays_.columns());
    if (colours_apart()) {
      float* const plane = &image.planes[channel][first];
      for (size_t i = 0; i < columns; ++i) plane[i] += share * sums_[i];
      return;
    }
    for (size_t c = 0; c < 3; ++c) {
      float* const plane = &image.planes[c][first];
      for (size_t i = 0; i < columns; ++i) plane[i] += share * sums_[4 * i + c];
    }
  }

  const GatherKernels& kernels_ = gather_kernels();
  const Page& page_;
  const StripScale& scale_;
  const float* texels_;
  const Colour* palette_;  // Where texels are places in one.
  const StripView& view_;
  const CameraRays& rays_;
  std::vector<int32_t> found_;
  std::vector<float> sums_;
};

// By what part of a column to stagger rows, of which a pixel has so many: near the golden ratio's,
// and so that each row stands at another place.
float stagger(int rows) {
  int best = 1;
  for (int k = 1; k < rows; ++k) {
    const double golden = 0.381966 * rows;
    if (std::gcd(k, rows) == 1 && std::abs(k - golden) < std::abs(best - golden)) best = k;
  }
  return static_cast<float>(best) / static_cast<float>(rows);
}

// As fine as asked, or as targets can be.
StripScale scale_of(const CameraRays& rays, const StripView& view, StripScale samples,
                    int most_texels) {
  const auto focal = static_cast<float>(rays.focal_px);
  const float low = *std::min_element(view.row_y_min.begin(), view.row_y_min.end());
  const float high = *std::max_element(view.row_y_max.begin(), view.row_y_max.end());
  const auto room = static_cast<float>(most_texels - 8);
  for (;;) {
    StripScale scale{samples.across, samples.down};
    scale.u_per_unit = focal * static_cast<float>(scale.across);
    scale.v_per_unit = focal * static_cast<float>(scale.down);
    scale.shear = stagger(scale.down);
    const float wide = (view.x_max - view.x_min) * scale.u_per_unit +
                       (high - low) * scale.v_per_unit * scale.shear;
    const bool too_wide = wide > room, too_high = (high - low) * scale.v_per_unit > room;
    if (!too_wide && !too_high) return scale;
    if ((too_wide && samples.across == 1) || (too_high && samples.down == 1)) break;
    if (too_wide) --samples.across;
    if (too_high) --samples.down;
  }
  throw InputError(
      fmt::format("renderer 'opengl': an image of {}x{} pixels behind this lens is larger than "
                  "OpenGL's targets of {} texels; take --renderer analytic or a smaller image",
                  rays.width_px, rays.height_px, most_texels));
}

// Where a band stands on the grid; false if the view sees nothing of it. Returns its width.
bool place_band(const StripView& view, const StripScale& scale, Band& band, int& width) {
  float low = 1e30f, high = -1e30f;
  for (int row = band.rows.first; row <= band.rows.last; ++row) {
    low = std::min(low, view.row_y_min[row]), high = std::max(high, view.row_y_max[row]);
  }
  if (high < low) return false;
  low *= scale.v_per_unit, high *= scale.v_per_unit;
  band.first_y = floor_of(low) - 1;
  band.height = floor_of(high) + 3 - band.first_y;
  band.first_x = floor_of(view.x_min * scale.u_per_unit + scale.shear * low) - 1;
  width = floor_of(view.x_max * scale.u_per_unit + scale.shear * high) + 3 - band.first_x;
  return true;
}

}  // namespace

std::vector<StripView> views_of(const CameraRays& rays) {
  std::vector<StripView> views;
  if (rays.perspective) {
    views.push_back({.x_min = rays.x_min,
                     .x_max = rays.x_max,
                     .row_y_min = rays.row_y_min,
                     .row_y_max = rays.row_y_max});
    return views;
  }
  for (int side = 0; side < 6; ++side) {
    StripView view{.side = side, .R_CV = side_axes(side), .row_y_min = {}, .row_y_max = {}};
    bound(rays, view);
    if (!view.empty()) views.push_back(std::move(view));
  }
  return views;
}

StripPlan plan_strip(const SampledInstants& instants, const CameraRays& rays, const StripView& view,
                     StripScale samples, const PageLimits& limits) {
  StripPlan plan{.scale = scale_of(rays, view, samples, limits.side_texels), .pages = {}};
  const int period = std::max(instants.fewest_a_row(), 1);
  const std::vector<int> order = SamplePattern::scattered_order(period);
  std::vector<Band> bands;
  int width = 0;
  for (int k = 0; k < instants.count(); ++k) {
    Band band{.instant = k, .rows = instants.rows_of(k)};
    // The instants of a row see the texels' grid at places spread evenly between the columns of its
    // lattice, and over a row: a rank-1 lattice with the golden ratio's fraction, in scattered
    // order, for an edge that moves in step with the grid would always be seen from the same side.
    const int place = order[k % period];
    const float part = 1.0f / static_cast<float>(period);
    band.shift_u = (static_cast<float>(place) + 0.5f) * part / static_cast<float>(plan.scale.down);
    const float golden = static_cast<float>(place) * 0.618034f + 0.5f * part;
    band.shift_v = golden - std::floor(golden);
    int needed = 0;
    if (!place_band(view, plan.scale, band, needed)) continue;
    width = std::max(width, needed);
    bands.push_back(band);
  }
  Page page{.width = width, .bands = {}};
  const auto finish = [&] {
    if (!page.bands.empty()) plan.pages.push_back(page);
    page.bands.clear(), page.height = 0;
  };
  for (Band& band : bands) {
    const int height = page.height + band.height;
    if (page.height > 0 && (height > limits.side_texels || height * width > limits.page_texels))
      finish();
    band.page_y = page.height;
    page.height += band.height;
    page.bands.push_back(band);
  }
  finish();
  return plan;
}

double weight_of(const Band& band, int row, const RowSchedule& schedule, const CameraRays& rays) {
  const int image_row = std::clamp(row - rays.border_px, 0, rays.height_px - 1);
  const int place = band.instant - schedule.first_instant[image_row];
  const std::vector<double>& weights = schedule.weights[image_row];
  return place < 0 || place >= static_cast<int>(weights.size()) ? 0 : weights[place];
}

void gather_light(const Page& page, const StripScale& scale, const std::vector<float>& texels,
                  const std::vector<Colour>* palette, const StripView& view,
                  const RowSchedule& schedule, const CameraRays& rays, int threads,
                  LinearImage& image) {
  split_over_threads(threads, rays.rows(), [&](int begin, int end) {
    Gather gather(page, scale, texels.data(), palette, view, rays);
    for (const Band& band : page.bands) {
      for (int row = std::max(begin, band.rows.first); row < std::min(end, band.rows.last + 1);
           ++row) {
        const double weight = weight_of(band, row, schedule, rays);
        if (weight != 0) gather.add_row(band, row, static_cast<float>(weight), image);
      }
    }
  });
}

void find_centres(const Page& page, const StripScale& scale, const std::vector<float>& texels,
                  const StripView& view, const RowSchedule& schedule, const CameraRays& rays,
                  std::vector<int32_t>& sources, std::vector<float>& depths) {
  const RayTable& green = rays.table(1);
  for (const Band& band : page.bands) {
    for (int row = 0; row < rays.height_px; ++row) {
      if (schedule.first_instant[row] != band.instant) continue;
      for (int column = 0; column < rays.width_px; ++column) {
        const size_t ray = rays.at(row + rays.border_px) + column + rays.border_px;
        const Vec3f d = ray_at(green, ray, 0, 0);
        if (!rays.perspective && side_of(d) != view.side) continue;
        const OnView at = on_view(view.R_CV, d);
        const float along_v = at.y * scale.v_per_unit;
        const int u =
            floor_of(at.x * scale.u_per_unit + scale.shear * along_v + band.shift_u) - band.first_x;
        const int v = floor_of(along_v + band.shift_v) - band.first_y;
        const size_t texel =
            static_cast<size_t>(band.page_y + std::clamp(v, 0, band.height - 1)) * page.width +
            std::clamp(u, 0, page.width - 1);
        const size_t i = static_cast<size_t>(row) * rays.width_px + column;
        sources[i] = static_cast<int32_t>(texels[4 * texel]) - 1;
        const float along = static_cast<float>(view.R_CV[2].x) * d[0] +
                            static_cast<float>(view.R_CV[2].y) * d[1] +
                            static_cast<float>(view.R_CV[2].z) * d[2];
        depths[i] = texels[4 * texel + 1] / along;
      }
    }
  }
}

}  // namespace seam::render::gl
