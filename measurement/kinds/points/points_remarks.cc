// What can be said of a target's views beside numbers: those that no pose explains, how far the
// data reach, and what too few or too similar views cannot tell.
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "effects/stages/lens_domain.h"
#include "measurement/kinds/points/points_predictor.h"
#include "measurement/kinds/points/points_problem.h"
#include "measurement/kinds/points/target/spacing.h"
#include "measurement/noise/unlike_groups.h"
#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {
namespace {

// Boards tilted less than this in every view hardly show perspective.
constexpr double kFacing_rad = 5 * std::numbers::pi / 180;
// Views below this number cannot be told from a target of their own.
constexpr size_t kFewViews = 3;
// The image in so many cells, of which the points reach some.
constexpr int kCellColumns = 8, kCellRows = 6;

}  // namespace

void PointsProblem::remark_on_views(const Evaluation& evaluation,
                                    std::vector<std::string>& remarks) const {
  std::vector<std::string> missed;
  double most_tilted = 0;
  size_t views = 0;
  for (size_t frame = 0; frame < data_.rows_of_frame.size(); ++frame) {
    const auto& rows = data_.rows_of_frame[frame];
    Pose X_CW;
    if (std::none_of(rows.begin(), rows.end(), [&](int row) { return takes_part(row); })) continue;
    ++views;
    if (!stored_pose(evaluation.nuisance_values, frame, X_CW)) {
      missed.push_back(data_.frames[frame]);
      continue;
    }
    const Vec3 normal_C = X_CW.R * data_.target.axes_W[2];
    most_tilted = std::max(most_tilted, std::acos(std::min(1.0, std::abs(normal_C.z))));
  }
  if (!missed.empty())
    remarks.push_back(fmt::format(
        "no pose explains frame {} with this model: {} of {} views count as missed by their whole "
        "extent",
        fmt::join(missed, ", "), missed.size(), views));
  if (data_.target.flat && missed.size() < views && most_tilted < kFacing_rad)
    remarks.push_back(
        fmt::format("the board faces the camera in every view (tilted by {:.1f} degrees at most): "
                    "focal length and distance are not separable; tilt it by 30 degrees both ways",
                    most_tilted * 180 / std::numbers::pi));
  if (views < kFewViews)
    remarks.push_back(fmt::format(
        "{} of the target: a bent, stretched or displaced target cannot be told from the lens, nor "
        "displaced points from noise; ten views of different tilt can",
        views == 1 ? "one view" : "two views"));
}

// A noise that the set states is one for all views, or has the sigmas of its rows: where views
// differ by more, no effect says so.
void PointsProblem::remark_on_scatter(const Evaluation& evaluation,
                                      std::vector<std::string>& remarks) const {
  // What a model misses far differs from view to view by itself.
  constexpr double kExplained = 1.5;
  if (facts_.channels[0].estimated || facts_.channels[1].estimated) return;
  const Score score = score_of(*this, evaluation);
  if (!score.valid || score.error() > kExplained) return;
  const double taken = static_cast<double>(evaluation.nuisances) + evaluation.absorbed;
  const double free = std::max(0.0, 1 - taken / static_cast<double>(std::max<int64_t>(1, score.n)));
  std::vector<ResidualGroup> groups;
  for (const std::vector<int>& rows : data_.rows_of_view) {
    ResidualGroup& group = groups.emplace_back();
    for (const int row : rows) {
      if (!takes_part(row)) continue;
      for (const size_t scalar : {2 * static_cast<size_t>(row), 2 * static_cast<size_t>(row) + 1})
        group.values.push_back(evaluation.whitened[scalar]);
    }
    group.freedom = free * static_cast<double>(group.values.size());
  }
  const std::vector<double> spreads = spreads_of_groups(groups);
  if (spreads.empty()) return;
  remarks.push_back(fmt::format(
      "views scatter unlike, other than the set states: {}, where the typical view is 1; in a set "
      "without noise and sigma_px each view's own is estimated",
      least_and_most(spreads)));
}

void PointsProblem::remark_on_reach(const Model& model, std::vector<std::string>& remarks) const {
  const Cameras cameras(model, data_.cameras);
  for (size_t k = 0; k < data_.cameras.size(); ++k) {
    const CameraView& view = data_.cameras[k];
    const auto camera = static_cast<int>(k);
    double farthest = 0;
    std::vector<char> reached(kCellColumns * kCellRows, 0);
    for (size_t row = 0; row < data_.p_W.size(); ++row) {
      if (!takes_part(row) || data_.camera_of_row[row] != camera) continue;
      const auto ray =
          cameras.lens(camera).unproject(data_.u_px[row], data_.v_px[row], data_.stamp_s[row]);
      if (ray) farthest = std::max(farthest, std::atan2(std::hypot(ray->x, ray->y), ray->z));
      const int c = static_cast<int>((data_.u_px[row] + 0.5) / view.width_px * kCellColumns);
      const int r = static_cast<int>((data_.v_px[row] + 0.5) / view.height_px * kCellRows);
      if (c >= 0 && c < kCellColumns && r >= 0 && r < kCellRows)
        reached[static_cast<size_t>(r * kCellColumns + c)] = 1;
    }
    const auto cells = std::count(reached.begin(), reached.end(), 1);
    remarks.push_back(fmt::format(
        "the points{} reach {:.1f} degrees from the optical axis and {:.0f} % of the image; beyond "
        "them the lens is extrapolated",
        data_.cameras.size() > 1 ? " that " + view.name + " sees" : "",
        farthest * 180 / std::numbers::pi,
        100.0 * static_cast<double>(cells) / (kCellColumns * kCellRows)));
  }
}

// By the model that the user gave: what was added since may have bent to the fault.
void PointsProblem::remark_on_spacing(const Model& model, std::vector<std::string>& remarks) const {
  std::vector<size_t> rows;
  std::vector<Vec3> places;
  std::vector<ImagePlace> seen;
  for (size_t row = 0; row < data_.p_W.size(); ++row) {
    if (data_.p_W[row] != data_.target.plan_W[static_cast<size_t>(data_.point_of_row[row])])
      return;  // Points that move are no target.
    rows.push_back(row);
    places.push_back(data_.p_W[row]);
    seen.push_back({data_.u_px[row], data_.v_px[row]});
  }
  const PointsPredictor predictor(data_, given().effects().empty() ? model : given());
  const auto told = wrong_spacing(places, seen, [&](size_t i, const Vec3& p_W) {
    const effects::ImagePoint point = predictor.image_at(rows[i], p_W);
    return point.visible ? std::optional(ImagePlace{point.u, point.v}) : std::nullopt;
  });
  if (!told) return;
  remarks.push_back(fmt::format(
      "warning: the points fit {:.3g} times as well where they lie {:.4g} times as far apart as "
      "points.csv says ({:.3g} px in place of {:.3g}): is the spacing of the target {:.4g} m, not "
      "{:.4g} m?",
      told->before_px / told->after_px, told->factor, told->after_px, told->before_px,
      told->neighbour_m * told->factor, told->neighbour_m));
}

std::vector<std::string> PointsProblem::remarks(const Model& model) const {
  std::vector<std::string> remarks;
  if (data_.rig.type() != Rig::Type::unknown) {
    remark_on_spacing(model, remarks);
    return remarks;
  }
  if (!moves())
    remarks.push_back(
        "effects of time (rows read out one after the other, exposure, clocks) are not testable "
        "with this set: its views stand still, each with a pose of its own; take a video of the "
        "target with the camera moved by hand, all frames with their times, and say rig: {pose: "
        "unknown, motion: spline}; if the camera moved while the rows of each view were read, "
        "state the read-out time (rolling_shutter) and say motion: constant_velocity");
  if (moves()) remark_on_path(remarks);
  const Evaluation evaluation = evaluate(model, all_groups(), nullptr);
  remark_on_views(evaluation, remarks);
  if (!moves()) remark_on_agreement(model, evaluation, remarks);
  remark_on_scatter(evaluation, remarks);
  remark_on_reach(model, remarks);
  for (const std::string& doubt :
       effects::lens_doubts(model, data_.camera.width_px, data_.camera.height_px))
    remarks.push_back("warning: " + doubt);
  return remarks;
}

std::string PointsProblem::no_result_because(const Model& model) const {
  for (const CameraView& view : data_.cameras) {
    const std::string pole =
        effects::lens_pole(effects::model_of(model, view.name), view.width_px, view.height_px);
    if (!pole.empty()) return pole;
  }
  return "";
}

std::vector<Figure> PointsProblem::figures(const Model& model) const {
  std::vector<Figure> figures;
  for (const CameraView& view : data_.cameras) {
    const effects::ImagePoint axis =
        effects::Projection(model_of(model, view.name), view.width_px, view.height_px)
            .project({0, 0, 1});
    const std::string of = view.name.empty() ? "" : " of " + view.name;
    for (const auto& [name, value] : {std::pair{"focal length x", axis.fx},
                                      {"focal length y", axis.fy},
                                      {"centre x", axis.cx},
                                      {"centre y", axis.cy}})
      figures.push_back({.name = name + of, .unit = "px", .value = value});
  }
  return figures;
}

std::vector<PlacedPoint> PointsProblem::placed_points(const Model& model) const {
  const effects::TargetShape shape = effects::target_of(model);
  std::vector<PlacedPoint> points;
  if (shape.is_plan() && !(shape.scatter_sigma_m > 0)) return points;
  std::vector<Vec3> displaced_m;
  std::vector<Eigen::Matrix3d> covariances;
  if (shape.scatter_sigma_m > 0) {
    Evaluation evaluation;
    const auto adjustment = adjusted(model, all_groups(), nullptr, nullptr, evaluation);
    if (adjustment)
      displaced_m = adjustment->displaced_m(), covariances = adjustment->covariances();
  }
  const Target& target = data_.target;
  for (size_t i = 0; i < target.names.size(); ++i) {
    PlacedPoint point{.name = target.names[i], .plan_m = target.plan_W[i]};
    point.place_m = target.placed_W(i, shape);
    if (!displaced_m.empty()) point.place_m += target.axes_W * displaced_m[i];
    point.shift_m = (point.place_m - point.plan_m) * target.axes_W;
    if (i < covariances.size()) {
      for (int axis = 0; axis < 3; ++axis)
        point.sigma_m[axis] = std::sqrt(std::max(0.0, covariances[i](axis, axis)));
    }
    points.push_back(point);
  }
  return points;
}

}  // namespace seam::measurement
