// `seam import kalibr`: camchain and target YAML, corners as CSV.
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "app/import/cameras/camera_file.h"
#include "app/import/cameras/corner_table.h"
#include "app/import/draft/calibration.h"
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

PlainCamera camera_of(const ConfigNode& node, const std::string& name, SetDraft& draft) {
  const std::string model = node.at("camera_model").text();
  if (model != "pinhole")
    node.at("camera_model").fail(fmt::format("found '{}', expected pinhole", model));
  PlainCamera camera{.name = name};
  const auto k = numbers_in(node.at("intrinsics"));
  if (k.size() != 4) node.at("intrinsics").fail("expected fx, fy, cx, cy");
  check_calibrated(k, node.at("intrinsics").where());
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
  return camera;
}

CameraFile camera_file(const ConfigNode& root, SetDraft& draft) {
  CameraFile file;
  std::optional<Pose> X_RC = Pose{};  // Along the chain as far as it is stated.
  for (const std::string& name : root.keys()) {
    if (!is_camera(root, name)) continue;
    const ConfigNode node = root.at(name);
    if (!file.names.empty()) {
      const bool stated = X_RC && node.has("T_cn_cnm1");
      X_RC = stated ? std::optional(*X_RC * pose_in(node.at("T_cn_cnm1")).inverse()) : std::nullopt;
    }
    if (X_RC) file.X_RC[name] = *X_RC;
    file.names.push_back(name);
  }
  file.read = [root, &draft](const std::string& name) {
    return camera_of(root.at(name), name, draft);
  };
  return file;
}

bool is_yaml(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  return extension == ".yaml" || extension == ".yml" || extension == ".json";
}

}  // namespace

namespace {

// Which cameras' corners: those of the calibration or those that were asked for, else the first.
std::vector<std::string> cameras_wanted(const CornerTable& corners,
                                        const std::vector<PlainCamera>& cameras,
                                        const ImportRequest& request, SetDraft& draft) {
  const std::vector<std::string> known = corners.cameras();
  std::vector<std::string> wanted = cameras_in(request.camera);
  if (!corners.has_cameras()) {
    const bool of_chain = !cameras.empty() && wanted.size() == 1;
    if (!request.camera.empty() && !of_chain)
      throw InputError(fmt::format(
          "--camera {}: the corners have no column of cameras, expected one: --map camera=COLUMN",
          request.camera));
    return {""};
  }
  if (request.camera.empty() && !cameras.empty()) wanted = {cameras.front().name};
  if (wanted.front().empty()) wanted = {known.front()};
  if (request.camera.empty() && known.size() > 1)
    draft.did(
        fmt::format("of the cameras {} the first, {} (--camera; --camera {} takes them as one "
                    "rig)",
                    fmt::join(known, ", "), wanted.front(), fmt::join(known, ",")));
  for (std::string& one : wanted) {
    const auto found = std::find_if(known.begin(), known.end(), [&](const std::string& name) {
      return are_same_camera(name, one);
    });
    if (found != known.end()) one = *found;
  }
  return wanted;
}

}  // namespace

void import_kalibr(const ImportRequest& request, SetDraft& draft) {
  std::vector<PlainCamera> cameras;
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
    if (const auto foreign = foreign_cameras(root, request, draft)) {
      cameras = chosen_cameras(*foreign, root, request, draft);
      continue;
    }
    const auto keys = root.keys();
    if (std::none_of(keys.begin(), keys.end(),
                     [&](const std::string& key) { return is_camera(root, key); }))
      root.fail("expected cameras (cam0 with camera_model) or a target (target_type)");
    cameras = chosen_cameras(camera_file(root, draft), root, request, draft);
  }
  if (cameras.empty() && (request.width_px == 0 || !table))
    throw UsageError("kalibr: expected a camchain, or corners and --size WIDTHxHEIGHT");
  draft.camera.width_px = cameras.empty() ? request.width_px : cameras.front().width_px;
  draft.camera.height_px = cameras.empty() ? request.height_px : cameras.front().height_px;
  if (!table) return draft_protocol(cameras, request, draft);
  if (!target)
    target = TargetSpec{.columns = static_cast<int>(request.board_columns),
                        .rows = static_cast<int>(request.board_rows),
                        .points = board_of(request, "corners without a target YAML")};
  const CornerTable corners(*table, request);
  const auto wanted = cameras_wanted(corners, cameras, request, draft);
  for (size_t k = 0; k < cameras.size() && corners.has_cameras(); ++k) cameras[k].name = wanted[k];
  draft_views(corners.views(*target, wanted, draft), corners.has_times(), cameras, table->file(),
              draft);
}

}  // namespace seam::app
