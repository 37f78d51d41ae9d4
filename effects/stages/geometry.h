// Stages `mount` and `geometry`: from a point in the camera's frame to a point in the image.
#pragma once

#include <optional>

#include "effects/model.h"
#include "effects/row_columns.h"
#include "sim_core/base/pose.h"

namespace seam::effects {

// What geometry effects read and change, in this order: projection (pinhole sets the intrinsics;
// fisheye replaces x, y), radial terms, tangential terms, focal length and principal point;
// then u = fx xd + cx, v = fy yd + cy; then `image_map` hooks (expression effects) act on u, v.
// Where a detector of corners reports the point, `corner_detector` hooks act last.
struct ImagePoint {
  Vec3 p_C{0.0};  // The point (or a direction) in the camera's frame: x right, y down, z forward.
  double x = 0, y = 0;    // Normalised pinhole coordinates p.x / p.z, p.y / p.z, before distortion.
  double xd = 0, yd = 0;  // After distortion.
  double fx = 0, fy = 0, cx = 0, cy = 0;  // Pixels.
  double u = 0, v = 0;                    // Pixels; (0, 0) is the centre of the top-left pixel.
  // v where the light falls, before what a detector of corners makes of it: which row sees it.
  double light_v = 0;
  double t_s = 0;   // Time of the observation since the set's reference.
  double row = 0;   // The (distorted) row at which it is seen.
  int channel = 1;  // 0 red, 1 green, 2 blue; grey is green.
  int width_px = 0, height_px = 0;
  RowColumns columns;
  bool visible = true;   // False when no image point exists (behind the camera, outside the
                         // range in which the distortion is defined).
  bool at_edge = false;  // Not visible, since the lens folds the image over there: u and v are
                         // those of the fold, to which a fit can bring the point back.

  // Whether u and v mean anything.
  bool has_place() const { return visible || at_edge; }
  // Moves what is farther from the axis than the fold to the fold.
  void put_at_edge(double share_of_radius) {
    at_edge = visible, visible = false;
    xd *= share_of_radius, yd *= share_of_radius;
  }
};

// Where a lens first folds the image over on the way from the axis to `beyond`, where it does: the
// first place at which `grows` is no longer positive.
template <class Grows>
double fold_before(double beyond, const Grows& grows) {
  constexpr int kPlaces = 32, kHalvings = 40;
  double inside = 0, outside = beyond;
  for (int k = 1; k < kPlaces; ++k) {
    const double place = beyond * k / kPlaces;
    if (!(grows(place) > 0)) {
      outside = place;
      break;
    }
    inside = place;
  }
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (inside + outside);
    (grows(middle) > 0 ? inside : outside) = middle;
  }
  return inside;
}

// What a projection leads to: where light falls on the sensor (images, files of other programs), or
// where a detector of corners reports a point (measured points).
enum class Reaches { light, detector };

inline constexpr double kFocalAt_c = 20;  // Where a focal length has no other temperature.

inline constexpr int kGreen = 1;  // The channel of what has no colour.

// The geometry of one model, ready to project many points.
class Projection {
 public:
  Projection(const Model& model, int width_px, int height_px, Reaches end = Reaches::light);

  // The image point of a point in the camera's frame; invisible ones have `visible` false.
  ImagePoint project(const Vec3& p_C, double t_s = 0, double row = 0, int channel = kGreen,
                     const RowColumns& columns = {}) const;

  // The direction (z = 1, or a unit vector for fisheye) whose image is (u, v); nothing where the
  // lens maps no ray to that point. Newton's method on `project`.
  std::optional<Vec3> unproject(double u, double v, double t_s = 0, int channel = 1) const;

  // Throws InputError with the effect's name where a formula gives no number for the ray that leads
  // to about (u, v); returns where that is not why there is no ray.
  void check_at(double u, double v, double t_s, int channel) const;

  // Projections of the same key, within a search, map every point alike: what acts, with its exact
  // values, and the image's size.
  std::string key() const;

  int width_px() const { return width_px_; }
  int height_px() const { return height_px_; }

 private:
  ImagePoint before_formulas(const Vec3& p_C, double t_s, double row, int channel,
                             const RowColumns& columns) const;

  std::vector<ModelEffect> effects_;  // Those that act on the way, in order.
  int width_px_;
  int height_px_;
  Reaches end_;
};

// X_LC: the camera in its last link after mount effects (includes the camera's axes).
Pose mount_of(const Model& model);

// rho of the catalogue: distance from the image centre over half the diagonal.
double rho(double u, double v, int width_px, int height_px);

}  // namespace seam::effects
