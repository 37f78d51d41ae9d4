// A camera told from the views alone, good to a few per cent: enough to say how the image of a
// point moves when the point does.
#pragma once

#include <optional>
#include <vector>

#include "measurement/kinds/points/target/pose_solver.h"

namespace seam::measurement {

struct RoughCamera {
  effects::Model model;
  effects::Projection projection;
  std::vector<std::optional<Pose>> X_CW;  // By view; nothing where none was found.

  // Derivatives of the image of a point by its shift along the axes (columns of `axes_W`).
  std::optional<Eigen::Matrix<double, 2, 3>> slopes(size_t view, const Vec3& p_W,
                                                    const Mat3& axes_W) const;
};

// A lens of this focal length whose image is centred: perspective, or equidistant where `wide`.
effects::Model plain_lens(double focal_px, bool wide, int width_px, int height_px);

// The best of a few lenses (perspective and equidistant, of several focal lengths, centred), by the
// residuals that poses of their own leave of some views. Nothing where no lens finds any pose.
std::optional<RoughCamera> rough_camera(const std::vector<std::vector<Sighting>>& views,
                                        int width_px, int height_px);

}  // namespace seam::measurement
