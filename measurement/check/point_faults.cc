// Faults of points in pictures: stamps, views stored twice, targets mirrored.
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>

#include "measurement/check/fault_parts.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/robust.h"
#include "measurement/sets/pose_of_view.h"
#include "measurement/sets/rig_keys.h"

namespace seam::measurement {
namespace {

// What one camera shows in one frame.
struct View {
  std::string name, camera;
  Rows rows;
};

// The image of a flat target as an affine map: its handedness tells which side is seen.
double handedness(const Numbers& x, const Numbers& y, const Numbers& u, const Numbers& v,
                  const Rows& rows) {
  Eigen::MatrixXd a(rows.size(), 3);
  Eigen::MatrixXd b(rows.size(), 2);
  for (size_t i = 0; i < rows.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    a.row(row) << x[rows[i]], y[rows[i]], 1;
    b.row(row) << u[rows[i]], v[rows[i]];
  }
  const Eigen::MatrixXd map = solve_any_rank(a, b);
  return map(0, 0) * map(1, 1) - map(0, 1) * map(1, 0);
}

// In the order in which they were taken, camera by camera.
std::vector<View> views_of(const CsvTable& table, const std::string& group) {
  std::vector<View> views;
  std::map<std::pair<std::string, std::string>, size_t> known;
  for (size_t row = 0; row < table.rows(); ++row) {
    const std::string frame(table.cell(row, table.has("frame") ? "frame" : group));
    const std::string camera(table.has("camera") ? table.cell(row, "camera") : "");
    const auto place = known.emplace(std::pair(camera, frame), views.size());
    if (place.second)
      views.push_back({frame + (camera.empty() ? "" : " of camera " + camera), camera, {}});
    views[place.first->second].rows.push_back(row);
  }
  std::stable_sort(views.begin(), views.end(),
                   [](const View& a, const View& b) { return a.camera < b.camera; });
  return views;
}

// A frame has one stamp; and on one smooth path a camera is at one place at a time.
void tell_stamps(const MeasurementSet& set, const CsvTable& table, const std::vector<View>& views,
                 std::vector<std::string>& found) {
  if (!table.has("time_s")) return;
  const auto times = table.times_ns("time_s");
  size_t unlike = 0;
  std::string first;
  for (const View& view : views) {
    const auto other = std::find_if(view.rows.begin(), view.rows.end(), [&](size_t row) {
      return times[row] != times[view.rows.front()];
    });
    if (other == view.rows.end() || unlike++ > 0) continue;
    first = fmt::format("{}: column time_s: found {} and {} in frame {}", place(table, *other),
                        table.cell(view.rows.front(), "time_s"), table.cell(*other, "time_s"),
                        view.name);
  }
  if (unlike > 0)
    found.push_back(
        fmt::format("{}, {} such frames in all: one stamp each, the start of row 0, is expected "
                    "(read-out times are the model's)",
                    first, unlike));
  const auto rig = set.root.find("rig");
  if (!rig || !rig->is_map() || !rig->has("motion") || rig->at("motion").text() != "spline") return;
  std::map<std::pair<std::string, int64_t>, const View*> at;
  for (const View& view : views) {
    const size_t row = view.rows.front();
    const auto [earlier, is_new] = at.emplace(std::pair(view.camera, times[row]), &view);
    if (is_new) continue;
    found.push_back(fmt::format(
        "{}: column time_s: frames {} and {} have one time ({} s), expected another for each: a "
        "camera on one path is at one place at a time",
        place(table, row), earlier->second->name, view.name, table.cell(row, "time_s")));
    return;
  }
}

// Angles of a rig's joints that no head turns to, and a target whose points stand metres apart.
void tell_units(const MeasurementSet& set, const CsvTable& table, bool held_before_it,
                std::vector<std::string>& found) {
  constexpr double kMost_rad = 20, kMost_m = 1.5;
  if (set.has_file("joints")) {
    const CsvTable joints = set.table("joints");
    for (const std::string& column : joints.extra_numeric_columns({})) {
      if (!column.ends_with("_rad")) continue;
      const double span = span_of(joints.numbers(column));
      if (span > kMost_rad)
        found.push_back(fmt::format("{}: {} spans {:.4g}, {:.0f} turns: degrees for radians?",
                                    joints.file(), column, span, span / (2 * std::numbers::pi)));
    }
  }
  if (!held_before_it || table.rows() < 2) return;
  const Numbers x = table.numbers("x_m"), y = table.numbers("y_m");
  Numbers steps;
  for (size_t row = 1; row < table.rows(); ++row) {
    const double step = std::hypot(x[row] - x[row - 1], y[row] - y[row - 1]);
    if (step > 0) steps.push_back(step);
  }
  if (!steps.empty() && median_of(steps) > kMost_m)
    found.push_back(
        fmt::format("{}: neighbouring points of the target are {:.4g} m apart: "
                    "millimetres for metres?",
                    table.file(), median_of(steps)));
}

}  // namespace

void point_faults(const MeasurementSet& set, std::vector<std::string>& found) {
  const CsvTable table = set.table("points");
  if (!has_all(table, {"u_px", "v_px", "x_m", "y_m", "z_m", "frame"})) return;
  const Numbers u = table.numbers("u_px"), v = table.numbers("v_px");
  const Numbers x = table.numbers("x_m"), y = table.numbers("y_m"), z = table.numbers("z_m");
  const bool flat = std::all_of(z.begin(), z.end(), [](double value) { return value == 0; });
  const bool held_before_it = has_unknown_poses(set.root);
  tell_units(set, table, held_before_it, found);
  const auto views = views_of(table, set.group);
  tell_stamps(set, table, views, found);
  const std::optional<double> noise_px = stated_noise_px(set, table);
  size_t mirrored = 0, repeated = 0, looked_at = 0;
  std::string first_mirrored, first_repeated;
  for (size_t i = 0; i < views.size(); ++i) {
    const Rows& rows = views[i].rows;
    if (rows.size() < kPointsOfPose) continue;
    std::vector<Vec3> points_m, image_px;
    for (const size_t row : rows)
      points_m.emplace_back(x[row], y[row], z[row]), image_px.emplace_back(u[row], v[row], 0);
    // Points on a line have no handedness.
    if (flat && held_before_it && why_no_pose(points_m, image_px, noise_px).empty()) {
      ++looked_at;
      if (handedness(x, y, u, v, rows) < 0 && mirrored++ == 0) first_mirrored = views[i].name;
    }
    const auto same = [&](size_t a, size_t b) {
      return u[a] == u[b] && v[a] == v[b] && x[a] == x[b] && y[a] == y[b] && z[a] == z[b];
    };
    if (i > 0 && views[i - 1].camera == views[i].camera &&
        std::equal(rows.begin(), rows.end(), views[i - 1].rows.begin(), views[i - 1].rows.end(),
                   same) &&
        repeated++ == 0)
      first_repeated = views[i].name;
  }
  if (repeated > 0)
    found.push_back(fmt::format(
        "{} views repeat the one before to the last digit, the first is {}: a frame that was "
        "stored twice",
        repeated, first_repeated));
  if (mirrored > 0 && mirrored < looked_at)
    found.push_back(fmt::format(
        "{} of {} views show the target mirrored against the others, the first is {}: its corners "
        "are numbered from another end there",
        mirrored, looked_at, first_mirrored));
}

}  // namespace seam::measurement
