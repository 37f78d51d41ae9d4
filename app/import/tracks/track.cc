#include "app/import/tracks/track.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "app/import/draft/checks.h"
#include "app/import/draft/walk_draft.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

using Names = std::vector<std::string>;

size_t at(int column) {
  return static_cast<size_t>(column);
}

}  // namespace

int column_of(const TextTable& table, const ImportRequest& request, const std::string& quantity,
              const Names& usual) {
  const std::string mapped = request.name_of(quantity);
  const int own = mapped.empty() ? -1 : table.find({mapped});
  return own >= 0 ? own : table.find(usual);
}

TrackColumns track_columns(const TextTable& table, const ImportRequest& request,
                           const std::string& time) {
  TrackColumns columns;
  if (table.columns().empty()) {
    // As TUM's trajectories: time x y z qx qy qz qw.
    if (table.width() == 8)
      columns = {.time = 0, .x = 1, .y = 2, .z = 3, .theta = -1, .q = {7, 4, 5, 6}};
    return columns;
  }
  const auto column = [&](const std::string& quantity, const Names& usual) {
    return column_of(table, request, quantity, usual);
  };
  columns.time = column(time, {"time_s", "time", "timestamp", "t", "stamp", "time_ms", "time_ns",
                               "timestamp_ms", "timestamp_ns", "secs", "seconds"});
  const auto place = [&](const std::string& axis) {
    return column(axis, {axis + "_m", axis, "p" + axis, "p_" + axis, "pos_" + axis, "t" + axis,
                         "position_" + axis, "p_rs_r_" + axis, axis + "_mm", "pose_" + axis,
                         "position." + axis, "pose.position." + axis, "true_" + axis,
                         "mocap_" + axis, "gt_" + axis});
  };
  columns.x = place("x"), columns.y = place("y"), columns.z = place("z");
  if (columns.z < 0) columns.z = table.find({"height", "altitude", "height_m", "alt"});
  columns.theta = column("theta", {"theta_rad", "theta", "yaw", "heading", "yaw_rad", "heading_rad",
                                   "psi", "phi", "orientation", "true_theta", "mocap_theta",
                                   "mocap_yaw", "gt_theta", "gt_yaw", "pose_theta", "pose_yaw"});
  const std::array<std::string, 4> parts = {"w", "x", "y", "z"};
  for (size_t i = 0; i < 4; ++i)
    columns.q[i] =
        column("q" + parts[i], {"q" + parts[i], "q_" + parts[i], "q_rs_" + parts[i],
                                "quat_" + parts[i], "orientation." + parts[i],
                                "orientation_" + parts[i], "pose.orientation." + parts[i]});
  return columns;
}

std::set<int> places_of(const TrackColumns& columns) {
  std::set<int> places(columns.q.begin(), columns.q.end());
  places.insert({columns.time, columns.x, columns.y, columns.z, columns.theta});
  return places;
}

std::vector<size_t> numbers_beside(const TextTable& table, const std::set<int>& taken) {
  std::vector<size_t> found;
  for (size_t column = 0; column < table.columns().size(); ++column) {
    if (taken.contains(static_cast<int>(column))) continue;
    std::vector<double> values(table.rows());
    bool whole = true, counts = true;
    for (size_t row = 0; row < table.rows() && whole; ++row) {
      whole = parse_number(table.cell(row, column), values[row]);
      if (row > 1) counts = counts && values[row] - values[row - 1] == values[1] - values[0];
    }
    if (whole && !counts) found.push_back(column);
  }
  return found;
}

void name_beside(const TextTable& table, const std::set<int>& taken, std::set<std::string>& names) {
  for (const size_t column : numbers_beside(table, taken))
    names.insert(csv_word(table.column_name(column)));
}

void say_left_out(const std::set<std::string>& names, std::string_view follows, SetDraft& draft) {
  if (!names.empty()) draft.did(fmt::format("left out: {}; {}", fmt::join(names, ", "), follows));
}

void read_track(const TextTable& table, const TrackColumns& columns, const ImportRequest& request,
                const std::string& time, Track& track) {
  const auto name = [&](int column) { return table.full_name(at(column)); };
  const int64_t unit = time_unit_of(request, time, name(columns.time));
  const double x_m = metres_of(request, "x", name(columns.x)),
               y_m = metres_of(request, "y", name(columns.y)),
               z_m = columns.z < 0 ? 0 : metres_of(request, "z", name(columns.z));
  const double rad = columns.theta < 0 ? 0 : radians_of(request, "theta", name(columns.theta));
  const bool turns = std::none_of(columns.q.begin(), columns.q.end(), [](int c) { return c < 0; });
  track.has_heights = track.has_heights || columns.z >= 0;
  track.has_headings = track.has_headings || columns.theta >= 0 || turns;
  track.has_tilts = track.has_tilts || turns;
  for (size_t row = 0; row < table.rows(); ++row) {
    const double x = table.number_or_blank(row, at(columns.x)),
                 y = table.number_or_blank(row, at(columns.y));
    if (std::isnan(x) || std::isnan(y)) continue;
    TrackPose pose{.ns = time_in(table, row, columns.time, unit),
                   .x_m = x_m * x,
                   .y_m = y_m * y,
                   .place = fmt::format("{}:{}", table.file(), table.line(row))};
    if (columns.z >= 0) pose.z_m = z_m * table.number(row, at(columns.z));
    if (turns) {
      StampedPose whole{.ns = 0, .p = Vec3(0.0), .q = {}};
      double square = 0;
      for (size_t i = 0; i < 4; ++i) {
        whole.q[i] = table.number(row, at(columns.q[i]));
        square += whole.q[i] * whole.q[i];
      }
      if (!(std::abs(std::sqrt(square) - 1) < 0.02))
        table.fail(row, at(columns.q[0]), "a quaternion of length 1: other columns?");
      for (double& q : whole.q) q /= std::sqrt(square);
      pose.theta_rad = planar(whole).theta_rad;
      const Vec3 up = rotation_of(whole.q)[2];
      pose.up = {up.x, up.y, up.z};
    }
    if (columns.theta >= 0) pose.theta_rad = rad * table.number_or_blank(row, at(columns.theta));
    track.poses.push_back(std::move(pose));
  }
}

int64_t time_in(const TextTable& table, size_t row, int column, int64_t unit_ns) {
  constexpr int64_t kMost_ns = 3'000'000'000'000'000'000;
  const int64_t ns = table.time_ns(row, at(column), unit_ns);
  if (ns > kMost_ns || ns < -kMost_ns)
    table.fail(row, at(column), "a time before 2065 (in another unit? --time-unit)");
  return ns;
}

void check_columns_met(const ImportRequest& request, const std::vector<TextTable>& tables) {
  Names known;
  for (const TextTable& table : tables)
    known.insert(known.end(), table.columns().begin(), table.columns().end());
  for (const auto& [quantity, name] : request.names) {
    const bool met = std::any_of(tables.begin(), tables.end(),
                                 [&](const TextTable& table) { return table.find({name}) >= 0; });
    if (!met)
      throw InputError(fmt::format("{}: column '{}' (--map {}={}) is missing{}",
                                   tables.front().file(), name, quantity, name,
                                   suggestion_for(name, known)));
  }
}

int64_t time_unit_of(const ImportRequest& request, const std::string& quantity,
                     const std::string& column) {
  ImportRequest own = request;
  own.time_unit = request.unit_of(quantity, request.time_unit);
  return time_unit_ns(own, column);
}

double metres_of(const ImportRequest& request, const std::string& quantity,
                 const std::string& column) {
  const std::string said = request.unit_of(quantity, request.length_unit);
  const std::string unit = said.empty() ? length_unit_in(column) : said;
  return unit.empty() ? 1 : metres_in(unit);
}

double radians_of(const ImportRequest& request, const std::string& quantity,
                  const std::string& column) {
  const std::string said = request.unit_of(quantity, request.unit);
  const std::string unit = said.empty() ? angle_unit_in(column) : said;
  return unit.empty() ? 1 : radians_in(unit);
}

std::string laid_on_plane(const Track& track, const std::string& remedy) {
  std::vector<Vec3> places, ups;
  for (const TrackPose& pose : track.poses) {
    places.emplace_back(pose.x_m, pose.y_m, pose.z_m);
    if (track.has_tilts) ups.emplace_back(pose.up[0], pose.up[1], pose.up[2]);
  }
  return places.empty() ? "" : check_plane(places, ups, track.poses.front().place, remedy);
}

}  // namespace seam::app
