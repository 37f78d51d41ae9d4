// `seam import kalibr`: camchain and target YAML, corners as CSV.
#include <algorithm>
#include <cmath>
#include <map>

#include "app/import/draft/calibration.h"
#include "app/import/draft/checks.h"
#include "app/import/draft/points_draft.h"
#include "app/import/draft/target.h"
#include "app/import/files/storage.h"
#include "app/import/files/text_table.h"
#include "app/import/kinds/kinds.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

bool is_camera(const ConfigNode& root, const std::string& name) {
  return root.at(name).is_map() && root.at(name).has("camera_model");
}

PlainCamera camera_of(const ConfigNode& root, const ImportRequest& request, SetDraft& draft) {
  std::vector<std::string> names;
  for (const std::string& name : root.keys()) {
    if (is_camera(root, name)) names.push_back(name);
  }
  std::string name = request.camera.empty() ? names.front() : request.camera;
  if (std::find(names.begin(), names.end(), name) == names.end())
    root.fail(fmt::format("--camera {}: no such camera{}", name, suggestion_for(name, names)));
  if (request.camera.empty() && names.size() > 1)
    draft.did(fmt::format("of {} cameras the first, {} (--camera)", names.size(), name));
  const ConfigNode node = root.at(name);
  const std::string model = node.at("camera_model").text();
  if (model != "pinhole")
    node.at("camera_model").fail(fmt::format("found '{}', expected pinhole", model));
  PlainCamera camera{.name = name};
  const auto k = numbers_in(node.at("intrinsics"));
  if (k.size() != 4) node.at("intrinsics").fail("expected fx, fy, cx, cy");
  camera.lens.fx_px = k[0], camera.lens.fy_px = k[1];
  camera.lens.cx_px = k[2], camera.lens.cy_px = k[3];
  const auto size = numbers_in(node.at("resolution"));
  if (size.size() != 2) node.at("resolution").fail("expected width and height");
  camera.width_px = static_cast<int>(size[0]), camera.height_px = static_cast<int>(size[1]);
  const ConfigNode distortion = node.at("distortion_model");
  const size_t form = distortion.choice({"none", "radtan", "equidistant"});
  const auto d = form == 0 ? std::vector<double>{} : numbers_in(node.at("distortion_coeffs"));
  take_coefficients(d, form == 2, distortion.where(), camera.lens, draft);
  camera.line_delay_s = node.number_or("line_delay", 0, {-1, 1});
  camera.time_shift_s = node.number_or("timeshift_cam_imu", 0, {-1e3, 1e3});
  check_camera(camera, node.where());
  if (node.has("T_cam_imu") || node.has("T_cn_cnm1"))
    draft.could_not_know("what T_cam_imu or T_cn_cnm1 would be good for: each view's pose is free");
  return camera;
}

// A corner of a tag, counted from its lower left against the clock, as a place of the grid.
size_t corner_of_tag(size_t tag, size_t corner, size_t tag_columns) {
  const size_t row = 2 * (tag / tag_columns) + (corner >= 2 ? 1 : 0);
  const size_t column = 2 * (tag % tag_columns) + (corner == 1 || corner == 2 ? 1 : 0);
  return row * 2 * tag_columns + column;
}

class Corners {
 public:
  Corners(const TextTable& table, const ImportRequest& request) : table_(table) {
    const auto column = [&](const char* quantity, std::vector<std::string> usual) {
      const std::string mapped = request.name_of(quantity);
      if (!mapped.empty()) usual = {mapped};
      return table.find(usual);
    };
    time_ =
        column("time", {"time_s", "timestamp", "time", "stamp", "t", "timestamp_ns", "time_ns"});
    frame_ = column("frame", {"frame", "image", "frame_id", "filename", "view"});
    camera_ = column("camera", {"camera", "cam", "cam_id"});
    tag_ = column("tag", {"tag", "tag_id"});
    point_ = column("point", {"point", "corner", "corner_id", "point_id", "id", "index"});
    u_ = column("u", {"u_px", "u", "x_px", "px", "x", "image_x"});
    v_ = column("v", {"v_px", "v", "y_px", "py", "y", "image_y"});
    const bool known = (time_ >= 0 || frame_ >= 0) && point_ >= 0 && u_ >= 0 && v_ >= 0;
    if (!known)
      throw InputError(fmt::format(
          "{}:1: expected columns time or frame, point (or tag and corner), u and v; say theirs "
          "with --map",
          table.file()));
    unit_ns_ = time_ < 0 ? 1 : time_unit_ns(request, table.full_name(static_cast<size_t>(time_)));
    // Kalibr's and ROS's stamps are whole nanoseconds.
    if (time_ >= 0 && request.time_unit.empty() &&
        table.cell(0, static_cast<size_t>(time_)).size() >= 18 &&
        table.cell(0, static_cast<size_t>(time_)).find('.') == std::string_view::npos)
      unit_ns_ = 1;
  }

  bool has_times() const { return time_ >= 0; }

  std::vector<SeenView> views(const TargetSpec& target, const std::string& camera) const {
    std::vector<SeenView> views;
    std::map<std::string, size_t> place;
    for (size_t row = 0; row < table_.rows(); ++row) {
      if (camera_ >= 0 && !camera.empty() && text(row, camera_) != camera) continue;
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
    if (views.empty())
      throw InputError(fmt::format("{}: found no corner of camera '{}'", table_.file(), camera));
    return views;
  }

 private:
  static size_t at(int column) { return static_cast<size_t>(column); }
  std::string text(size_t row, int column) const {
    return std::string(table_.cell(row, at(column)));
  }

  size_t count_in(size_t row, int column) const {
    const double value = table_.number(row, at(column));
    if (!(value >= 0 && value < 1e6) || value != std::floor(value))
      table_.fail(row, at(column), "a number of a point from 0 on");
    return static_cast<size_t>(value);
  }

  size_t point_in(size_t row, const TargetSpec& target) const {
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

  const TextTable& table_;
  int time_ = -1, frame_ = -1, camera_ = -1, tag_ = -1, point_ = -1, u_ = -1, v_ = -1;
  int64_t unit_ns_ = 1;
};

bool is_yaml(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  return extension == ".yaml" || extension == ".yml";
}

}  // namespace

void import_kalibr(const ImportRequest& request, SetDraft& draft) {
  std::optional<PlainCamera> camera;
  std::optional<TargetSpec> target;
  std::optional<TextTable> table;
  for (const auto& source : request.sources) {
    if (!is_yaml(source)) {
      if (table) throw UsageError("kalibr: expected one table of corners");
      table = TextTable::read(source);
      continue;
    }
    const ConfigNode root = read_storage(source);
    if (!root.is_map()) root.fail("expected a camchain or a target");
    if (root.has("target_type")) {
      target = read_target(root, request);
      continue;
    }
    const auto keys = root.keys();
    if (std::none_of(keys.begin(), keys.end(),
                     [&](const std::string& key) { return is_camera(root, key); }))
      root.fail("expected cameras (cam0 with camera_model) or a target (target_type)");
    camera = camera_of(root, request, draft);
  }
  if (!camera && (request.width_px == 0 || !table))
    throw UsageError("kalibr: expected a camchain, or corners and --size WIDTHxHEIGHT");
  draft.camera.width_px = camera ? camera->width_px : request.width_px;
  draft.camera.height_px = camera ? camera->height_px : request.height_px;
  if (!table) return draft_protocol(*camera, request, draft);
  if (!target) target = TargetSpec{.points = board_of(request, "corners without a target YAML")};
  const Corners corners(*table, request);
  auto views = corners.views(*target, request.camera);
  if (corners.has_times()) {
    std::stable_sort(views.begin(), views.end(),
                     [](const SeenView& a, const SeenView& b) { return a.time_ns < b.time_ns; });
  }
  draft_views(views, corners.has_times(), camera ? &*camera : nullptr, table->file(), draft);
}

}  // namespace seam::app
