#include "measurement/problem/views.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "measurement/problem/problem.h"
#include "sim_core/base/error.h"

namespace seam::measurement {

std::string attitudes_table(const Problem& problem, const effects::Model& model) {
  const auto* const has_views = dynamic_cast<const HasViews*>(&problem);
  if (!has_views)
    throw InputError(
        fmt::format("a set of kind {} has no poses of a camera to write, expected one "
                    "of kind points with rig: {{pose: unknown}}",
                    problem.facts().kind()));
  const std::vector<PlacedView> views = has_views->placed_views(model);
  const bool knows_exposure = std::any_of(
      views.begin(), views.end(), [](const PlacedView& view) { return view.exposure_s > 0; });
  std::string text = fmt::format("time_s,qw,qx,qy,qz,sigma_x_rad,sigma_y_rad,sigma_z_rad{},frame\n",
                                 knows_exposure ? ",exposure_s" : "");
  for (size_t i = 0; i < views.size(); ++i) {
    const PlacedView& view = views[i];
    if (i > 0 && view.time_ns == views[i - 1].time_ns)
      throw InputError(
          fmt::format("{}: frames {} and {} have one time, expected views with times of their own",
                      problem.facts().file, views[i - 1].name, view.name));
    Eigen::Matrix3d R;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) R(row, column) = view.X_WC.R[column][row];
    const Eigen::Quaterniond q = Eigen::Quaterniond(R).normalized();
    text += fmt::format("{:.9f},{:.12f},{:.12f},{:.12f},{:.12f},{:.4g},{:.4g},{:.4g}",
                        1e-9 * static_cast<double>(view.time_ns), q.w(), q.x(), q.y(), q.z(),
                        view.sigma_rad.x, view.sigma_rad.y, view.sigma_rad.z);
    if (knows_exposure) text += fmt::format(",{:.9g}", view.exposure_s);
    text += fmt::format(",{}\n", view.name);
  }
  return text;
}

}  // namespace seam::measurement
