#include "app/import/draft/points_draft.h"

#include <fmt/ranges.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "app/import/draft/board_layout.h"
#include "app/import/draft/calibration.h"
#include "measurement/numerics/linear_algebra.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

void check_places(const std::vector<SeenView>& views, const std::string& file, SetDraft& draft) {
  const double width = draft.camera.width_px, height = draft.camera.height_px;
  double most_u = 0, most_v = 0;
  size_t outside = 0, all = 0;
  for (const SeenView& view : views) {
    for (const SeenCorner& c : view.corners) {
      most_u = std::max(most_u, c.u_px), most_v = std::max(most_v, c.v_px);
      const bool inside = c.u_px > -1 && c.v_px > -1 && c.u_px < width && c.v_px < height;
      outside += inside ? 0 : 1, ++all;
    }
  }
  if (outside == 0) return;
  if (most_u < height && most_v < width && most_v > height)
    throw InputError(
        fmt::format("{}: corners reach row {:.0f} of an image of {:.0f} x {:.0f} px and column "
                    "{:.0f} only: u and v are exchanged, or the size is that of the image turned",
                    file, most_v, width, height, most_u));
  if (outside * 10 > all)
    throw InputError(fmt::format("{}: {} of {} corners lie outside the image of {:.0f} x {:.0f} px",
                                 file, outside, all, width, height));
  draft.warn(fmt::format("{} of {} corners lie outside the image of {:.0f} x {:.0f} px", outside,
                         all, width, height));
}

}  // namespace

std::vector<Vec3> board_points(int columns, int rows, double spacing_x_m, double spacing_y_m) {
  std::vector<Vec3> points;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column)
      points.emplace_back(column * spacing_x_m, row * spacing_y_m, 0.0);
  }
  return points;
}

std::vector<Vec3> board_of(const ImportRequest& request, const std::string& why) {
  if (request.board_columns == 0 || request.spacing_m == 0)
    throw UsageError(
        fmt::format("{}: give --board COLUMNSxROWS (its corners) and --spacing METRES", why));
  check_spacing(request.spacing_m, "--spacing", request);
  return board_points(request.board_columns, request.board_rows, request.spacing_m,
                      request.spacing_m);
}

void check_spacing(double spacing_m, const std::string& where, const ImportRequest& request) {
  constexpr double kMost_m = 1.5;
  if (!(spacing_m > 0) || !std::isfinite(spacing_m))
    throw InputError(fmt::format("{}: found {}, expected a distance above 0", where, spacing_m));
  if (spacing_m > kMost_m && request.length_unit.empty())
    throw InputError(
        fmt::format("{}: found {} m between the target's corners, which looks like millimetres; "
                    "say it, --length-unit mm, or --length-unit m where it is right",
                    where, spacing_m));
}

double focal_length_from(const std::vector<SeenView>& views, int width_px, int height_px) {
  // Zhang: the columns of each view's map are orthogonal and equally long on the image of the
  // absolute conic, diag(1 / f^2, 1 / f^2, 1) with the principal point at 0.
  std::vector<double> found;
  const double scale = 0.5 * width_px;
  for (const SeenView& view : views) {
    if (view.corners.size() < 6 || !is_flat(view)) continue;
    const Eigen::Matrix3d h =
        plane_map(view.corners, 0.5 * (width_px - 1), 0.5 * (height_px - 1), scale).map;
    const double a1 = h(0, 0) * h(0, 1) + h(1, 0) * h(1, 1), b1 = -h(2, 0) * h(2, 1);
    const double a2 = h(0, 0) * h(0, 0) + h(1, 0) * h(1, 0) - h(0, 1) * h(0, 1) - h(1, 1) * h(1, 1);
    const double b2 = h(2, 1) * h(2, 1) - h(2, 0) * h(2, 0);
    const double inverse = (a1 * b1 + a2 * b2) / (a1 * a1 + a2 * a2);  // 1 / f^2.
    if (inverse > 0.01 && inverse < 100) found.push_back(scale / std::sqrt(inverse));
  }
  if (found.empty()) return 0;
  std::sort(found.begin(), found.end());
  return found[found.size() / 2];
}

namespace {

// The cameras of a rig in the order in which the table names them; one without a name if there is
// no rig.
std::vector<std::string> cameras_of(const std::vector<SeenView>& views) {
  std::vector<std::string> names;
  for (const SeenView& view : views) {
    if (std::find(names.begin(), names.end(), view.camera) == names.end())
      names.push_back(view.camera);
  }
  return names;
}

// Where a camera of a rig stands beside the first; free where that is not known.
std::string place_of(const std::string& name, const std::optional<Pose>& X_FC) {
  std::array<double, 6> numbers{};
  if (X_FC) {
    const Mat3& R = X_FC->R;
    const Vec3 axis(R[1][2] - R[2][1], R[2][0] - R[0][2], R[0][1] - R[1][0]);
    const double twice_sine = glm::length(axis), twice_cosine = R[0][0] + R[1][1] + R[2][2] - 1;
    const double angle = std::atan2(twice_sine, twice_cosine);
    const Vec3 turn = twice_sine > 0 ? axis * (angle / twice_sine) : Vec3(0.0);
    numbers = {X_FC->p.x, X_FC->p.y, X_FC->p.z, turn.x, turn.y, turn.z};
  }
  constexpr std::array<const char*, 6> kNames = {"x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"};
  std::string text = "  camera_pose@" + name + ": {";
  for (size_t i = 0; i < kNames.size(); ++i)
    text += fmt::format("{}{}: {}", i == 0 ? "" : ", ", kNames[i],
                        X_FC ? exact(numbers[i]) : "{value: 0, free: true}");
  return text + "}\n";
}

// Focal lengths and centre, with errors where the file has them.
std::string said_of(const PlainCamera& camera) {
  const Lens& lens = camera.lens;
  const auto with = [&](double value, size_t which) {
    const bool known = camera.sigma_px.has_value();
    return fmt::format("{:.6g}{}", value,
                       known ? fmt::format(" +- {:.2g}", (*camera.sigma_px)[which]) : "");
  };
  return fmt::format("focal lengths {} and {} px, centre {} and {} px{}", with(lens.fx_px, 0),
                     with(lens.fy_px, 1), with(lens.cx_px, 2), with(lens.cy_px, 3),
                     camera.sigma_px ? "" : "; the file states no errors");
}

// The calibrations as they stand.
void known_cameras(const std::vector<PlainCamera>& cameras, SetDraft& draft) {
  const bool rig = cameras.size() > 1;
  std::string free;
  for (size_t k = 0; k < cameras.size(); ++k) {
    const PlainCamera& camera = cameras[k];
    doubt_lens(camera, rig ? "the calibration of " + camera.name : "the calibration", draft);
    draft.did((rig ? camera.name + ": " : "") + said_of(camera));
    draft.effects += effects_of(camera, rig ? camera.name : "");
    if (k > 0 && !camera.X_FC) free += (free.empty() ? "" : ", ") + camera.name;
  }
  for (size_t k = 1; k < cameras.size(); ++k)
    draft.effects += place_of(cameras[k].name, cameras[k].X_FC);
  draft.did(rig ? "the nominal model is the calibrations as they stand, their numbers fixed"
                : "the nominal model is the calibration as it stands, its numbers fixed");
  if (!free.empty())
    draft.could_not_know(fmt::format("where {} stand{} beside {}: free in the nominal model", free,
                                     free.find(',') == std::string::npos ? "s" : "",
                                     cameras.front().name));
}

// Free perspective cameras that start from the views.
void free_cameras(const std::vector<SeenView>& views, SetDraft& draft) {
  std::vector<std::string> focal_px;
  const std::vector<std::string> cameras = cameras_of(views);
  for (const std::string& camera : cameras) {
    std::vector<SeenView> own;
    std::copy_if(views.begin(), views.end(), std::back_inserter(own),
                 [&](const SeenView& view) { return view.camera == camera; });
    double f = focal_length_from(own, draft.camera.width_px, draft.camera.height_px);
    if (f == 0) f = draft.camera.width_px;
    focal_px.push_back(fmt::format("{:.0f}", f));
    draft.effects += fmt::format(
        "  pinhole{4}: {{fx_px: {{value: {0:.1f}, free: true}}, fy_px: {{value: {0:.1f}, free: "
        "true}}, cx_px: {{value: {1}, free: true}}, cy_px: {{value: {2}, free: true}}}}{3}",
        f, exact(0.5 * (draft.camera.width_px - 1)), exact(0.5 * (draft.camera.height_px - 1)),
        "\n", camera.empty() ? "" : "@" + camera);
  }
  if (cameras.size() == 1) {
    draft.did(
        fmt::format("the nominal model is a perspective camera of {} px focal length, estimated "
                    "from the views; "
                    "its four numbers are free",
                    focal_px.front()));
    return;
  }
  for (size_t k = 1; k < cameras.size(); ++k) draft.effects += place_of(cameras[k], std::nullopt);
  draft.did(
      fmt::format("the nominal model is a perspective camera each of {} px focal length ({}), "
                  "estimated from the "
                  "views; their numbers are free, and where they stand beside '{}'",
                  fmt::join(focal_px, ", "), fmt::join(cameras, ", "), cameras.front()));
}

}  // namespace

void draft_views(const std::vector<SeenView>& views, bool times_known, const PlainCamera* camera,
                 const std::string& file, SetDraft& draft) {
  draft_views(views, times_known,
              camera == nullptr ? std::vector<PlainCamera>{} : std::vector<PlainCamera>{*camera},
              file, draft);
}

void draft_views(const std::vector<SeenView>& views, bool times_known,
                 const std::vector<PlainCamera>& cameras, const std::string& file,
                 SetDraft& draft) {
  draft.kind = "points";
  draft.group = "frame";
  draft.rig = "{pose: unknown}";
  check_places(views, file, draft);
  check_layout(views, file);
  bool weighted = false, measured = false;
  size_t count = 0;
  std::set<size_t> points;
  for (const SeenView& view : views) {
    for (const SeenCorner& c : view.corners) {
      weighted = weighted || c.weight != 1;
      measured = measured || c.sigma_px > 0;
      points.insert(c.point);
    }
    count += view.corners.size();
  }
  std::vector<std::string> columns = {"frame", "time_s", "point", "x_m",
                                      "y_m",   "z_m",    "u_px",  "v_px"};
  if (weighted) columns.emplace_back("weight");
  if (measured) columns.emplace_back("sigma_px");
  const bool rig = cameras_of(views).size() > 1;
  if (rig) columns.emplace_back("camera");
  measurement::CsvWriter table(columns);
  size_t frame = 0;
  for (size_t i = 0; i < views.size(); ++i) {
    frame += i > 0 && !(rig && views[i].name == views[i - 1].name) ? 1 : 0;
    const std::string time =
        times_known ? seconds_text(views[i].time_ns) : fmt::format("{}", frame);
    for (const SeenCorner& c : views[i].corners) {
      std::vector<std::string> cells = {views[i].name,  time,           fmt::format("{}", c.point),
                                        exact(c.p_W.x), exact(c.p_W.y), exact(c.p_W.z),
                                        exact(c.u_px),  exact(c.v_px)};
      if (weighted) cells.push_back(exact(c.weight));
      if (measured) cells.push_back(fmt::format("{:.4g}", c.sigma_px));
      if (rig) cells.push_back(views[i].camera);
      table.row(cells);
    }
  }
  draft.add_table("points", table);
  draft.did(fmt::format("{} corners in {} views of a target of {} points", count, views.size(),
                        points.size()));
  if (!times_known)
    draft.could_not_know(
        "when the views were taken: numbered by seconds, which says nothing of time");
  if (!measured) draft.could_not_know("the noise of the corners: it is estimated");
  draft.could_not_know(
      "where the camera was: each view's pose is estimated with the model, so that a wrong spacing "
      "of the target scales all distances and shows in no number");
  if (cameras.empty()) {
    free_cameras(views, draft);
  } else {
    known_cameras(cameras, draft);
  }
}

void draft_protocol(const std::vector<PlainCamera>& cameras, const ImportRequest& request,
                    SetDraft& draft) {
  const PlainCamera& camera = cameras.front();
  const bool rig = cameras.size() > 1;
  constexpr int kViews = 24;
  const bool given = request.board_columns > 0;
  const int columns = given ? request.board_columns : 9, rows = given ? request.board_rows : 6;
  const double spacing_m = request.spacing_m > 0 ? request.spacing_m : 0.03;
  check_spacing(spacing_m, "--spacing", request);
  const auto points = board_points(columns, rows, spacing_m, spacing_m);
  const Vec3 middle(0.5 * (columns - 1) * spacing_m, 0.5 * (rows - 1) * spacing_m, 0.0);
  draft.kind = "points";
  draft.group = "frame";
  draft.rig = "{pose: unknown}";
  std::vector<std::string> columns_of_table = {"frame", "time_s", "point", "x_m", "y_m", "z_m"};
  if (rig) columns_of_table.emplace_back("camera");
  measurement::CsvWriter table(columns_of_table);
  measurement::CsvWriter poses({"time_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"});
  // The board fills about half of the image, turned to all sides by up to 35 degrees.
  const double far_m = 2 * (columns - 1) * spacing_m * camera.lens.fx_px / camera.width_px;
  for (int view = 0; view < kViews; ++view) {
    const double turn = 2.399963229728653 * view;  // The golden angle.
    const double tilt = 0.6 * std::sqrt((view + 0.5) / kViews);
    const Vec3 axis(std::cos(turn), std::sin(turn), 0.0);
    // The camera looks along its z: from behind the plane, so that x is right and y is down.
    const double w = std::cos(0.5 * tilt), s = std::sin(0.5 * tilt);
    const Vec3 forward(axis.y * std::sin(tilt), -axis.x * std::sin(tilt), std::cos(tilt));
    const Vec3 shift(0.15 * far_m * std::cos(2.1 * view) * camera.width_px / camera.lens.fx_px,
                     0.15 * far_m * std::sin(2.1 * view) * camera.height_px / camera.lens.fy_px,
                     0.0);
    const Vec3 p = middle - (far_m * (1 + 0.25 * std::sin(1.3 * view))) * forward + shift;
    poses.row({fmt::format("{}", view), fmt::format("{:.6f}", p.x), fmt::format("{:.6f}", p.y),
               fmt::format("{:.6f}", p.z), fmt::format("{:.9f}", w),
               fmt::format("{:.9f}", s * axis.x), fmt::format("{:.9f}", s * axis.y), "0"});
    for (const PlainCamera& seen_by : cameras) {
      for (size_t i = 0; i < points.size(); ++i) {
        std::vector<std::string> cells = {fmt::format("{}", view), fmt::format("{}", view),
                                          fmt::format("{}", i),    exact(points[i].x),
                                          exact(points[i].y),      exact(points[i].z)};
        if (rig) cells.push_back(seen_by.name);
        table.row(cells);
      }
    }
  }
  draft.add_table("points", table);
  draft.add_table("poses", poses);
  draft.did(fmt::format(
      "the files hold a calibration and no corners: a protocol of {} views of a board of {} x {} "
      "corners, {} m apart{}, for `seam measure`",
      kViews, columns, rows, exact(spacing_m), given ? "" : " (taken for granted)"));
  known_cameras(cameras, draft);
  draft.could_not_know("the corners that the calibration was made from");
}

}  // namespace seam::app
