#include "measurement/report/target_told.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "measurement/report/finite_or_null.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

// A shift in units of its own error, by the axis that stands out most.
double clarity(const PlacedPoint& point) {
  double most = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (point.sigma_m[axis] > 0)
      most = std::max(most, std::abs(point.shift_m[axis]) / point.sigma_m[axis]);
  }
  return most;
}

}  // namespace

namespace {

// Root mean squares along x, y and out of the plane, mm.
struct Millimetres {
  double x, y, z;
};

Millimetres rms_mm(const std::vector<PlacedPoint>& points, Vec3 PlacedPoint::*of) {
  Vec3 square(0.0);
  for (const PlacedPoint& point : points)
    square += point.*of * point.*of / static_cast<double>(points.size());
  const auto root = [](double sum) { return 1000 * std::sqrt(sum); };
  return {root(square.x), root(square.y), root(square.z)};
}

std::string with_error(double value_m, double sigma_m) {
  return fmt::format("{:.2g} +- {:.2g}", 1000 * value_m, 1000 * sigma_m);
}

}  // namespace

std::string target_text(const Problem& problem, const Model& model) {
  const std::vector<PlacedPoint> points = problem.placed_points(model);
  if (points.empty()) return "";
  const Millimetres off = rms_mm(points, &PlacedPoint::shift_m);
  const Millimetres error = rms_mm(points, &PlacedPoint::sigma_m);
  // What a computation's last digits leave in the plane is nothing.
  constexpr double kNothing = 1e-6;
  const double in_plane = std::hypot(off.x, off.y);
  std::string text;
  if (in_plane < kNothing * off.z) {
    text = fmt::format("The board is bent: {:.2g} mm rms out of its plane", off.z);
  } else {
    text = fmt::format("The board's {} points are displaced: {:.2g} mm rms along x, {:.2g} along y",
                       points.size(), off.x, off.y);
    if (off.z > kNothing * in_plane) text += fmt::format(", {:.2g} out of its plane", off.z);
  }
  if (!(error.x > 0)) return text + ".\n";
  text += fmt::format("; standard errors {:.2g}, {:.2g}, {:.2g} mm.\n", error.x, error.y, error.z);
  const auto farthest = std::max_element(
      points.begin(), points.end(),
      [](const PlacedPoint& a, const PlacedPoint& b) { return clarity(a) < clarity(b); });
  return text + fmt::format("  most significant: point {}, by {}, {}, {} mm\n", farthest->name,
                            with_error(farthest->shift_m.x, farthest->sigma_m.x),
                            with_error(farthest->shift_m.y, farthest->sigma_m.y),
                            with_error(farthest->shift_m.z, farthest->sigma_m.z));
}

void add_target(ordered_json& into, const Problem& problem, const Model& model) {
  const std::vector<PlacedPoint> points = problem.placed_points(model);
  if (points.empty()) return;
  ordered_json list = ordered_json::array();
  for (const PlacedPoint& point : points) {
    ordered_json entry = {{"point", point.name}};
    for (const auto& [key, values] :
         {std::pair{"{}_m", &point.plan_m}, std::pair{"d{}_m", &point.shift_m},
          std::pair{"sigma_d{}_m", &point.sigma_m}}) {
      for (int axis = 0; axis < 3; ++axis)
        entry[fmt::format(fmt::runtime(key), "xyz"[axis])] =
            finite_or_null<ordered_json>((*values)[axis]);
    }
    list.push_back(std::move(entry));
  }
  into["target"] = {{"points", std::move(list)}};
}

std::string target_table(const Problem& problem, const Model& model) {
  const std::vector<PlacedPoint> points = problem.placed_points(model);
  if (points.empty())
    throw InputError(
        "the model leaves the target at its plan, so that there are no places to write, expected "
        "an effect of the target in it (seam effects lists them)");
  std::string text = "point,x_m,y_m,z_m,sigma_x_m,sigma_y_m,sigma_z_m\n";
  for (const PlacedPoint& point : points) {
    text += fmt::format("{},{:.9f},{:.9f},{:.9f},{:.3g},{:.3g},{:.3g}\n", point.name,
                        point.place_m.x, point.place_m.y, point.place_m.z, point.sigma_m.x,
                        point.sigma_m.y, point.sigma_m.z);
  }
  return text;
}

json target_arrows(const Problem& problem, const Model& model) {
  json items = json::array();
  for (const PlacedPoint& point : problem.placed_points(model)) {
    items.push_back({point.plan_m.x, point.plan_m.y, point.shift_m.x, point.shift_m.y,
                     point.shift_m.z, point.sigma_m.x, point.sigma_m.z});
  }
  return items;
}

}  // namespace seam::measurement
