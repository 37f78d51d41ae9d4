#include "app/import/cameras/corner_table.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "app/import/draft/checks.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

// A corner of a tag, counted from its lower left against the clock, as a place of the grid.
size_t corner_of_tag(size_t tag, size_t corner, size_t tag_columns) {
  const size_t row = 2 * (tag / tag_columns) + (corner >= 2 ? 1 : 0);
  const size_t column = 2 * (tag % tag_columns) + (corner == 1 || corner == 2 ? 1 : 0);
  return row * 2 * tag_columns + column;
}

}  // namespace

CornerTable::CornerTable(const TextTable& table, const ImportRequest& request) : table_(table) {
  const auto column = [&](const char* quantity, std::vector<std::string> usual) {
    const std::string mapped = request.name_of(quantity);
    if (!mapped.empty()) usual = {mapped};
    const int found = table.find(usual);
    if (found < 0 && !mapped.empty())
      throw InputError(fmt::format("{}:1: --map {}={}: no such column{}", table.file(), quantity,
                                   mapped, suggestion_for(mapped, table.columns())));
    return found;
  };
  time_ = column("time", {"time_s", "timestamp", "time", "stamp", "t", "timestamp_ns", "time_ns"});
  frame_ = column("frame", {"frame", "image", "frame_id", "filename", "view", "sync_index"});
  camera_ = column("camera", {"camera", "cam", "cam_id", "camera_id", "camera_name", "port"});
  tag_ = column("tag", {"tag", "tag_id"});
  point_ =
      column("point", {"point", "corner", "corner_id", "point_id", "keypoint_id", "id", "index"});
  u_ = column("u", {"u_px", "u", "x_px", "px", "x", "image_x", "img_loc_x"});
  v_ = column("v", {"v_px", "v", "y_px", "py", "y", "image_y", "img_loc_y"});
  board_row_ = column("row", {"row", "corner_row", "board_row", "row_id", "i_row"});
  board_column_ = column("column", {"column", "col", "corner_col", "corner_column", "board_col",
                                    "board_column", "col_id", "i_col"});
  std::vector<std::string> missing;
  if (time_ < 0 && frame_ < 0) missing.emplace_back("time or frame");
  if (point_ < 0 && (board_row_ < 0 || board_column_ < 0))
    missing.emplace_back("point (or tag and corner, or row and column on the board)");
  if (u_ < 0) missing.emplace_back("u");
  if (v_ < 0) missing.emplace_back("v");
  if (!missing.empty())
    throw InputError(fmt::format(
        "{}:1: no column for {}; state it with --map NAME=COLUMN, found {}", table.file(),
        fmt::join(missing, ", nor for "), fmt::join(table.columns(), ", ")));
  unit_ns_ = time_ < 0 ? 1 : time_unit_ns(request, table.full_name(at(time_)));
  // Kalibr's and ROS's stamps are whole nanoseconds.
  if (time_ >= 0 && request.time_unit.empty() && table.cell(0, at(time_)).size() >= 18 &&
      table.cell(0, at(time_)).find('.') == std::string_view::npos)
    unit_ns_ = 1;
}

std::vector<std::string> CornerTable::cameras() const {
  std::vector<std::string> names;
  std::set<std::string> known;
  for (size_t row = 0; row < table_.rows() && camera_ >= 0; ++row) {
    if (known.insert(text(row, camera_)).second) names.push_back(text(row, camera_));
  }
  return names;
}

// The key of a corner within one camera.
std::string CornerTable::key_of(size_t row) const {
  std::string key = text(row, frame_ >= 0 ? frame_ : time_) + '\n' + corner_text(row);
  if (tag_ >= 0) key += '\n' + text(row, tag_);
  return key;
}

// A column that is none of the others, has few values, and makes corners that stand twice different
// without it; empty: none does.
std::string CornerTable::column_of_cameras() const {
  constexpr size_t kMostCameras = 64;
  const std::set<int> used = {time_, frame_, tag_, point_, u_, v_, board_row_, board_column_};
  for (size_t column = 0; column < table_.columns().size(); ++column) {
    if (used.contains(static_cast<int>(column))) continue;
    std::set<std::string> values, keys;
    bool apart = true;
    for (size_t row = 0; row < table_.rows() && apart; ++row) {
      values.emplace(table_.cell(row, column));
      apart = values.size() <= kMostCameras &&
              keys.insert(key_of(row) + '\n' + std::string(table_.cell(row, column))).second;
    }
    if (apart && values.size() > 1) return table_.columns()[column];
  }
  return "";
}

void CornerTable::fail_twice(size_t row, size_t before) const {
  const std::string what =
      fmt::format("{}:{}: point {} of {} {} stands here and in line {}", table_.file(),
                  table_.line(row), corner_text(row), frame_ >= 0 ? "frame" : "time",
                  text(row, frame_ >= 0 ? frame_ : time_), table_.line(before));
  if (camera_ >= 0)
    throw InputError(
        fmt::format("{}, both of camera {}: expected each corner once", what, text(row, camera_)));
  const std::string column = column_of_cameras();
  throw InputError(fmt::format(
      "{}: expected each corner once; the corners of several cameras need their column, {}", what,
      column.empty() ? "--map camera=COLUMN"
                     : fmt::format("--map camera={} (which distinguishes them), and --camera "
                                   "chooses among them",
                                   column)));
}

// Views that all have the same first points and no others show the whole of a smaller board.
void CornerTable::refuse_smaller_board(const std::vector<SeenView>& views, size_t points) const {
  const size_t seen = views.empty() ? points : views.front().corners.size();
  for (const SeenView& view : views) {
    if (view.corners.size() != seen) return;
    for (const SeenCorner& corner : view.corners)
      if (corner.point >= seen) return;
  }
  if (seen >= points) return;
  throw InputError(
      fmt::format("{}: each view has the points 0 to {} and no others, expected {} points of the "
                  "target (are its columns and rows those of the inner corners?)",
                  table_.file(), seen - 1, points));
}

std::vector<SeenView> CornerTable::views_of(const TargetSpec& target,
                                            const std::string& camera) const {
  std::vector<SeenView> views;
  std::map<std::string, size_t> place, seen;
  for (size_t row = 0; row < table_.rows(); ++row) {
    if (camera_ >= 0 && text(row, camera_) != camera) continue;
    if (const auto [first, is_new] = seen.try_emplace(key_of(row), row); !is_new)
      fail_twice(row, first->second);
    const std::string name = text(row, frame_ >= 0 ? frame_ : time_);
    const auto [found, is_new] = place.try_emplace(name, views.size());
    if (is_new)
      views.push_back(
          {.name = name, .time_ns = time_ < 0 ? 0 : table_.time_ns(row, at(time_), unit_ns_)});
    const size_t point = point_in(row, target);
    views[found->second].corners.push_back({.point = point,
                                            .p_W = target.points[point],
                                            .u_px = table_.number(row, at(u_)),
                                            .v_px = table_.number(row, at(v_))});
  }
  if (tag_ < 0) refuse_smaller_board(views, target.points.size());
  if (has_times()) {
    std::stable_sort(views.begin(), views.end(),
                     [](const SeenView& a, const SeenView& b) { return a.time_ns < b.time_ns; });
  }
  return views;
}

std::vector<SeenView> CornerTable::views(const TargetSpec& target,
                                         const std::vector<std::string>& cameras,
                                         SetDraft& draft) const {
  const std::vector<std::string> known = this->cameras();
  std::vector<CameraViews> of_cameras;
  for (const std::string& camera : cameras) {
    if (has_cameras() && std::find(known.begin(), known.end(), camera) == known.end())
      throw InputError(fmt::format("{}: --camera {}: no such camera{}, expected {}", table_.file(),
                                   camera, suggestion_for(camera, known), fmt::join(known, ", ")));
    of_cameras.push_back({camera, views_of(target, camera)});
  }
  if (of_cameras.size() == 1) return std::move(of_cameras.front().views);
  return views_of_rig(std::move(of_cameras), frame_ >= 0 ? SameFrame::name : SameFrame::time,
                      draft);
}

size_t CornerTable::count_in(size_t row, int column) const {
  const double value = table_.number(row, at(column));
  if (!(value >= 0 && value < 1e6) || value != std::floor(value))
    table_.fail(row, at(column), "a number of a point from 0 on");
  return static_cast<size_t>(value);
}

std::string CornerTable::corner_text(size_t row) const {
  return point_ >= 0 ? text(row, point_)
                     : fmt::format("{}, {}", text(row, board_row_), text(row, board_column_));
}

size_t CornerTable::point_on_grid(size_t row, const TargetSpec& target) const {
  if (target.columns == 0 ||
      static_cast<size_t>(target.columns) * static_cast<size_t>(target.rows) !=
          target.points.size())
    table_.fail(row, at(board_row_), "the number of a point: this target is no grid of rows");
  const size_t on_row = count_in(row, board_row_), on_column = count_in(row, board_column_);
  if (on_row >= static_cast<size_t>(target.rows))
    table_.fail(row, at(board_row_), fmt::format("one of the board's {} rows", target.rows));
  if (on_column >= static_cast<size_t>(target.columns))
    table_.fail(row, at(board_column_),
                fmt::format("one of the board's {} columns", target.columns));
  return on_row * static_cast<size_t>(target.columns) + on_column;
}

size_t CornerTable::point_in(size_t row, const TargetSpec& target) const {
  if (point_ < 0) return point_on_grid(row, target);
  size_t point = count_in(row, point_);
  if (tag_ >= 0) {
    if (target.pattern != "aprilgrid") table_.fail(row, at(tag_), "no tags: the target has none");
    if (point > 3) table_.fail(row, at(point_), "a corner of a tag, 0 to 3");
    point = corner_of_tag(count_in(row, tag_), point, static_cast<size_t>(target.columns));
  }
  if (point >= target.points.size())
    table_.fail(row, at(tag_ >= 0 ? tag_ : point_),
                fmt::format("one of the target's {} points", target.points.size()));
  return point;
}

}  // namespace seam::app
