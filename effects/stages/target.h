// Stage `target`: where the points of a calibration target truly are, beside where its plan has
// them.
#pragma once

#include <functional>
#include <vector>

#include "effects/model.h"
#include "sim_core/base/pose.h"

namespace seam::effects {

// What effects of the target add up to. The target's own axes: x and y along the board from its
// middle, z out of its plane; a and b are x and y scaled to -1..1 over the board.
struct TargetShape {
  double x_scale = 0, y_scale = 0, shear = 0;
  double warp_x_m = 0, warp_y_m = 0;
  double scatter_sigma_m = 0;  // Of each coordinate of each point, the same in all views.
  double flex_sigma_m = 0;     // Of the bending of a view, along the warp's shape.
  // Of a view's focal length, as a share: not the target's, but drawn and estimated as its bending.
  double focus_sigma = 0;
  // Of how far the cameras turn while an image is read, about each axis.
  double motion_sigma_rad = 0;
  // Of how the target stands before a camera beyond the first, each coordinate in each frame.
  double sway_shift_sigma_m = 0, sway_turn_sigma_rad = 0;
  std::vector<std::function<void(Vec3&)>> maps;  // Formulas, in order, after all else.

  bool is_plan() const {
    return x_scale == 0 && y_scale == 0 && shear == 0 && warp_x_m == 0 && warp_y_m == 0 &&
           maps.empty();
  }
  bool has_draws() const {
    return scatter_sigma_m > 0 || flex_sigma_m > 0 || focus_sigma > 0 || motion_sigma_rad > 0 ||
           has_sway();
  }
  bool has_sway() const { return sway_shift_sigma_m > 0 || sway_turn_sigma_rad > 0; }
  // How far a bending of 1 m moves a point along z: the warp's own shape, of unit size, or that of
  // a board that bends alike both ways.
  double bending(double a, double b) const;
  // The point in a view whose bending is `flex_m`.
  Vec3 placed(const Vec3& p_B, double a, double b, double flex_m = 0) const;
};

// What a small shift and turn (a vector along its axis) move a point by, all in the same axes.
Vec3 swayed_by(const Vec3& p_B, const Vec3& shift_m, const Vec3& turn_rad);

TargetShape target_of(const Model& model);

}  // namespace seam::effects
