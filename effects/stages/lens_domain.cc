#include "effects/stages/lens_domain.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "effects/cameras.h"
#include "effects/questions.h"
#include "sim_core/base/maths.h"

namespace seam::effects {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// The image of rays in one half-plane through the optical axis.
class Way {
 public:
  Way(const Projection& projection, const ImagePoint& axis, double u, double v)
      : projection_(projection), axis_(axis), row_(v) {
    const double x = (u - axis.u) / axis.fx, y = (v - axis.v) / axis.fy;
    const double r = std::hypot(x, y);
    length_px_ = std::hypot(u - axis.u, v - axis.v);
    if (!(r > 0)) return;
    across_x_ = x / r, across_y_ = y / r;
    along_u_ = (u - axis.u) / length_px_, along_v_ = (v - axis.v) / length_px_;
  }

  double length_px() const { return length_px_; }

  ImagePoint image(double angle_rad) const {
    const double s = maths::sin(angle_rad);
    return projection_.project({s * across_x_, s * across_y_, maths::cos(angle_rad)}, 0, row_);
  }
  double radius_px(const ImagePoint& point) const {
    return (point.u - axis_.u) * along_u_ + (point.v - axis_.v) * along_v_;
  }
  // Whether the image goes outwards with the ray here.
  bool grows(double angle_rad) const {
    constexpr double kStep = 1e-6;
    const ImagePoint here = image(angle_rad), there = image(angle_rad + kStep);
    return here.visible && there.visible && radius_px(there) > radius_px(here);
  }
  // How fast, by the tangent of the ray's angle, as a perspective lens without distortion goes at
  // the same rate everywhere.
  double rate_px(double angle_rad) const {
    constexpr double kStep = 1e-5;
    return (radius_px(image(angle_rad)) - radius_px(image(angle_rad - kStep))) /
           (maths::tan(angle_rad) - maths::tan(angle_rad - kStep));
  }

  struct End {
    std::optional<LensFault> fault;
    double least_rate = 1, most_rate_behind = 1;  // Over that at the axis.
    double least_at_rad = 0;
  };
  End walk() const;

 private:
  static constexpr double kTangents_rad = 85 * kDegree;  // Beyond, tangents say little.

  LensFault fault_at(double angle_rad, bool pole) const {
    const ImagePoint point = image(angle_rad);
    return {.u = point.u,
            .v = point.v,
            .angle_rad = angle_rad,
            .radius_px = std::hypot(point.u - axis_.u, point.v - axis_.v),
            .pole = pole};
  }

  const Projection& projection_;
  const ImagePoint& axis_;
  double row_;
  double length_px_ = 0, across_x_ = 0, across_y_ = 0, along_u_ = 0, along_v_ = 0;
};

// The largest angle between these at which `holds` is still true, which it is at the first.
template <class Holds>
double last_place(double inside, double outside, const Holds& holds) {
  constexpr int kHalvings = 24;
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (inside + outside);
    (holds(middle) ? inside : outside) = middle;
  }
  return inside;
}

Way::End Way::walk() const {
  constexpr double kStep_rad = 2 * kDegree, kMost_rad = 178 * kDegree;
  // Lenses of pincushion distortion reach 2 at the corners.
  constexpr double kPole = 5;
  End end;
  const double at_axis_px = rate_px(1e-3);
  double before_rad = 0, before_px = 0;
  for (double angle_rad = kStep_rad; angle_rad < kMost_rad; angle_rad += kStep_rad) {
    const ImagePoint point = image(angle_rad);
    const bool goes_on = point.visible && radius_px(point) > before_px;
    double here_rad = angle_rad, here_px = radius_px(point);
    if (!goes_on) {
      here_rad = last_place(before_rad, angle_rad, [&](double at) { return grows(at); });
      here_px = radius_px(image(here_rad));
    }
    const bool arrives = here_px >= length_px_;
    if (arrives)
      here_rad = last_place(before_rad, here_rad,
                            [&](double at) { return radius_px(image(at)) < length_px_; });
    double rate = 0;
    if (here_rad < kTangents_rad)
      rate = (arrives || !goes_on
                  ? rate_px(here_rad)
                  : (here_px - before_px) / (maths::tan(here_rad) - maths::tan(before_rad))) /
             at_axis_px;
    if (rate > kPole) {
      end.fault = fault_at(here_rad, true);
      return end;
    }
    if (here_rad < kTangents_rad && rate < end.least_rate)
      end.least_rate = end.most_rate_behind = rate, end.least_at_rad = here_rad;
    end.most_rate_behind = std::max(end.most_rate_behind, rate);
    if (arrives) return end;
    if (!goes_on) {
      end.fault = fault_at(here_rad, false);
      return end;
    }
    before_rad = angle_rad, before_px = here_px;
  }
  return end;
}

// Places around the border of the image, the corners among them.
std::vector<std::array<double, 2>> border_of(const Projection& projection, int count) {
  const double width = projection.width_px() - 1.0, height = projection.height_px() - 1.0;
  std::vector<std::array<double, 2>> border;
  const int a_side = std::max(1, count / 4);
  for (int k = 0; k < a_side; ++k) {
    const double part = static_cast<double>(k) / a_side;
    border.push_back({part * width, 0});
    border.push_back({width, part * height});
    border.push_back({(1 - part) * width, height});
    border.push_back({0, (1 - part) * height});
  }
  return border;
}

constexpr int kDirectionsOfDoubts = 48;

std::string words_of(const LensFault& fault) {
  return fmt::format(
      "{} at ({:.0f}, {:.0f}) px, inside the image, {:.0f} px from the principal point and {:.1f} "
      "degrees from the optical axis: pixels farther out have no ray of their own; expected a lens "
      "that is one-to-one over the image: calibrate with points up to the corners, or with fewer "
      "coefficients",
      fault.pole ? "has a pole" : "folds the image over, as before a pole,", fault.u, fault.v,
      fault.radius_px, fault.angle_rad / kDegree);
}

void doubts_of_one(const Projection& projection, const std::string& name,
                   std::vector<std::string>& doubts) {
  const std::string lens = name.empty() ? "the lens" : "the lens of camera '" + name + "'";
  const ImagePoint axis = projection.project({0, 0, 1});
  if (!axis.visible) {
    doubts.push_back(lens + " maps its own optical axis to no pixel");
    return;
  }
  if (axis.u < -0.5 || axis.v < -0.5 || axis.u > projection.width_px() - 0.5 ||
      axis.v > projection.height_px() - 0.5)
    doubts.push_back(fmt::format(
        "{} has its principal point at ({:.1f}, {:.1f}) px, outside the image of {} x {} px: "
        "expected it near the middle, unless the image is a part cut from a larger one",
        lens, axis.u, axis.v, projection.width_px(), projection.height_px()));
  if (const auto fault = lens_fault(projection, kDirectionsOfDoubts)) {
    doubts.push_back(lens + " " + words_of(*fault));
    return;
  }
  // Less than this share of the rate at the axis, and then so many times as much again.
  constexpr double kNearFold = 0.6, kRisesAgain = 1.8;
  for (const auto& [u, v] : border_of(projection, kDirectionsOfDoubts)) {
    const Way::End end = Way(projection, axis, u, v).walk();
    if (!(end.least_rate < kNearFold) || end.most_rate_behind < kRisesAgain * end.least_rate)
      continue;
    doubts.push_back(fmt::format(
        "{} nearly folds the image over: {:.1f} degrees from the optical axis, on the way to pixel "
        "({:.0f}, {:.0f}), the image grows at {:.0f} % of its rate at the axis, and farther out at "
        "{:.0f} %; lenses change one way: calibrate with points up to the corners, or with fewer "
        "coefficients",
        lens, end.least_at_rad / kDegree, u, v, 100 * end.least_rate, 100 * end.most_rate_behind));
    return;
  }
}

}  // namespace

std::optional<LensFault> lens_fault(const Projection& projection, int directions) {
  const ImagePoint axis = projection.project({0, 0, 1});
  if (!axis.visible) return std::nullopt;
  std::optional<LensFault> nearest;
  for (const auto& [u, v] : border_of(projection, directions)) {
    const Way way(projection, axis, u, v);
    if (!(way.length_px() > 0)) continue;
    const auto fault = way.walk().fault;
    if (fault && (!nearest || fault->radius_px < nearest->radius_px)) nearest = fault;
  }
  return nearest;
}

std::string lens_pole(const Model& camera, int width_px, int height_px) {
  const auto fault = lens_fault(Projection(camera, width_px, height_px), kDirectionsOfDoubts);
  return fault && fault->pole ? "the lens " + words_of(*fault) : "";
}

std::vector<std::string> lens_doubts(const Model& model, int width_px, int height_px) {
  std::vector<std::string> doubts;
  for (const std::string& name : cameras_with_lenses(model)) {
    const Model own = model_of(model, name);
    if (!has_base(own, Base::projection) || replacement_in(own) != nullptr) continue;
    doubts_of_one(Projection(own, width_px, height_px), name, doubts);
  }
  return doubts;
}

}  // namespace seam::effects
