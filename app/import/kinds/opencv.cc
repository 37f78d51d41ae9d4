// `seam import opencv`: corners and calibrations in files of cv::FileStorage; ROS's camera_info has
// the same names.
#include <cmath>

#include "app/import/cameras/camera_file.h"
#include "app/import/draft/calibration.h"
#include "app/import/draft/points_draft.h"
#include "app/import/files/storage.h"
#include "app/import/kinds/kinds.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

using Names = std::vector<std::string>;

std::optional<ConfigNode> first_of(const ConfigNode& root, const Names& names) {
  for (const std::string& name : names) {
    if (auto node = root.find(name)) return node;
  }
  return std::nullopt;
}

// What the files hold together.
struct Storage {
  std::optional<ConfigNode> corners, target, matrix, coefficients, names;
  std::optional<ConfigNode> board_width, board_height, square;
  int width_px = 0, height_px = 0;
  bool fisheye = false;
  double line_delay_s = 0;
};

void take(const ConfigNode& root, const ImportRequest& request, Storage& found) {
  if (!root.is_map()) root.fail("expected names with values");
  const auto keep = [&](std::optional<ConfigNode>& to, const char* quantity, Names usual) {
    const std::string mapped = request.name_of(quantity);
    if (!mapped.empty()) usual = {mapped};
    if (auto node = first_of(root, usual)) to = node;
  };
  keep(found.corners, "corners",
       {"image_points", "imagePoints", "corners", "img_points", "imgpoints", "Corners"});
  keep(found.target, "target",
       {"object_points", "objectPoints", "grid_points", "obj_points", "objpoints"});
  keep(found.matrix, "camera_matrix",
       {"camera_matrix", "Camera_Matrix", "cameraMatrix", "K", "M1", "mtx", "intrinsic_matrix"});
  keep(found.coefficients, "distortion",
       {"distortion_coefficients", "Distortion_Coefficients", "dist_coeffs", "distCoeffs", "D",
        "D1", "dist", "distortion"});
  keep(found.names, "names", {"image_names", "images", "filenames", "image_list", "imagelist"});
  keep(found.board_width, "board_width", {"board_width", "board_Width", "boardWidth"});
  keep(found.board_height, "board_height", {"board_height", "board_Height", "boardHeight"});
  keep(found.square, "square_size", {"square_size", "square_Size", "squareSize"});
  const auto size = [&](const Names& names, int& value) {
    if (auto node = first_of(root, names)) value = static_cast<int>(node->integer(2, 100'000));
  };
  size({"image_width", "image_Width", "imageWidth", "width"}, found.width_px);
  size({"image_height", "image_Height", "imageHeight", "height"}, found.height_px);
  if (auto pair = first_of(root, {"image_size", "imageSize"})) {
    const auto numbers = numbers_in(*pair);
    if (numbers.size() != 2) pair->fail("expected two numbers, width and height");
    found.width_px = static_cast<int>(numbers[0]), found.height_px = static_cast<int>(numbers[1]);
  }
  if (auto flag = first_of(root, {"fisheye_model", "fisheye"}))
    found.fisheye = numbers_in(*flag) == std::vector<double>{1};
  if (auto model = root.find("distortion_model")) {
    const std::string name = model->text();
    const Names known = {"plumb_bob", "rational_polynomial", "equidistant", "fisheye", "opencv"};
    if (std::find(known.begin(), known.end(), name) == known.end())
      model->fail(fmt::format("found '{}'{}", name, suggestion_for(name, known)));
    found.fisheye = name == "equidistant" || name == "fisheye";
  }
}

PlainCamera camera_of(const Storage& found, SetDraft& draft) {
  PlainCamera camera{.width_px = draft.camera.width_px, .height_px = draft.camera.height_px};
  const auto k = numbers_in(*found.matrix);
  if (k.size() != 9) found.matrix->fail(fmt::format("found {} numbers, expected 3 x 3", k.size()));
  check_calibrated(k, found.matrix->where());
  if (k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
    found.matrix->fail(k[1] == 0 && k[2] == 0 && k[5] == 0 && k[8] == 1
                           ? "expected [fx, 0, cx, 0, fy, cy, 0, 0, 1]: exchanged rows and columns?"
                           : "expected [fx, 0, cx, 0, fy, cy, 0, 0, 1]");
  camera.lens.fx_px = k[0], camera.lens.fy_px = k[4];
  camera.lens.cx_px = k[2], camera.lens.cy_px = k[5];
  if (k[1] != 0)
    draft.warn(
        fmt::format("{}: a skew of {} px is no effect: left out", found.matrix->where(), k[1]));
  take_coefficients(
      found.coefficients ? numbers_in(*found.coefficients) : std::vector<double>{}, found.fisheye,
      (found.coefficients ? *found.coefficients : *found.matrix).where(), camera.lens, draft);
  check_camera(camera, found.matrix->where());
  return camera;
}

// A view a row of a matrix, or an item of a list.
std::vector<std::vector<double>> views_in(const ConfigNode& node) {
  std::vector<std::vector<double>> views;
  if (is_matrix(node)) {
    const auto rows = static_cast<size_t>(matrix_rows(node));
    const auto all = numbers_in(node, true);
    for (size_t i = 0; i < rows; ++i) {
      const auto first = all.begin() + static_cast<std::ptrdiff_t>(i * all.size() / rows);
      views.emplace_back(first, first + static_cast<std::ptrdiff_t>(all.size() / rows));
    }
    return views;
  }
  if (node.is_map()) {
    for (const std::string& key : node.keys()) views.push_back(numbers_in(node.at(key), true));
    return views;
  }
  for (const ConfigNode& item : node.items()) {
    if (is_matrix(item)) matrix_rows(item);
    views.push_back(numbers_in(item, true));
  }
  return views;
}

// The target's points, those of the file before the request's.
std::vector<std::vector<Vec3>> targets_of(const Storage& found, const ImportRequest& request,
                                          SetDraft& draft) {
  double metres = request.length_unit.empty() ? 1 : metres_in(request.length_unit);
  // The calibration sample's users write millimetres; no square of a board is a metre and a half.
  const auto in_millimetres = [&](double far_m, const char* what) {
    if (!request.length_unit.empty() || !(far_m > 1.5)) return;
    draft.did(
        fmt::format("{}, {} apart, {} taken for millimetres (--length-unit m where it is not)",
                    what, exact(far_m), what[0] == 't' ? "are" : "is"));
    metres = 1e-3;
  };
  std::vector<std::vector<Vec3>> targets;
  if (request.board_columns > 0 || (!found.target && !found.board_width))
    return {board_of(request, "corners without their target")};
  double spacing = 0;
  if (found.target) {
    auto lists = views_in(*found.target);
    // One list of points is a matrix of one row, or of a row a point, or a list of points.
    if (lists.size() > 1 && lists.front().size() == 3) lists = {numbers_in(*found.target)};
    if (lists.front().size() >= 6) {
      const auto& p = lists.front();
      in_millimetres(std::hypot(p[3] - p[0], p[4] - p[1], p[5] - p[2]) * metres, "target's points");
    }
    for (const auto& list : lists) {
      if (list.size() % 3 != 0 || list.empty())
        found.target->fail(fmt::format("found {} numbers, expected three a point", list.size()));
      std::vector<Vec3> points;
      for (size_t i = 0; i < list.size(); i += 3)
        points.emplace_back(list[i] * metres, list[i + 1] * metres, list[i + 2] * metres);
      if (points.size() > 1) spacing = glm::length(points[1] - points[0]);
      targets.push_back(std::move(points));
    }
    if (spacing > 0) check_spacing(spacing, found.target->where(), request);
    return targets;
  }
  if (!found.board_height || !found.square)
    found.board_width->fail("expected board_height and square_size beside it");
  in_millimetres(found.square->number() * metres, "square_size");
  spacing = found.square->number() * metres;
  return {board_points(static_cast<int>(found.board_width->integer(2, 1000)),
                       static_cast<int>(found.board_height->integer(2, 1000)), spacing, spacing)};
}

std::vector<SeenView> seen_views(const Storage& found, const ImportRequest& request,
                                 SetDraft& draft) {
  const auto lists = views_in(*found.corners);
  const auto targets = targets_of(found, request, draft);
  if (targets.size() != 1 && targets.size() != lists.size())
    found.target->fail(fmt::format("found {} targets, expected one or {}, as many as views",
                                   targets.size(), lists.size()));
  Names names;
  if (found.names && !found.names->is_map() && !found.names->is_scalar()) {
    for (const ConfigNode& item : found.names->items()) names.push_back(item.text());
  }
  std::vector<SeenView> views;
  size_t missing = 0, blind = 0;
  for (size_t i = 0; i < lists.size(); ++i) {
    const auto& target = targets[targets.size() == 1 ? 0 : i];
    const auto& list = lists[i];
    if (list.empty()) {
      ++blind;
      continue;
    }
    if (list.size() != 2 * target.size())
      found.corners->fail(
          fmt::format("view {}: found {} numbers, expected two for each of the "
                      "target's {} points",
                      i, list.size(), target.size()));
    SeenView view{.name = fmt::format("{}", i)};
    for (size_t p = 0; p < target.size(); ++p) {
      const double u = list[2 * p], v = list[2 * p + 1];
      // Detectors write what they did not find as NaN or -1.
      if (!std::isfinite(u) || !std::isfinite(v) || (u == -1 && v == -1)) {
        ++missing;
        continue;
      }
      view.corners.push_back({.point = p, .p_W = target[p], .u_px = u, .v_px = v});
    }
    views.push_back(std::move(view));
  }
  if (missing > 0)
    draft.did(fmt::format("{} corners were not found (NaN or -1): left out", missing));
  if (blind > 0) draft.did(fmt::format("{} views show no corner: left out", blind));
  if (views.empty()) found.corners->fail("found no view, expected lists of corners");
  return views;
}

}  // namespace

void import_opencv(const ImportRequest& request, SetDraft& draft) {
  Storage found;
  std::string files;
  std::vector<PlainCamera> cameras;
  for (const auto& source : request.sources) {
    const ConfigNode root = read_storage(source);
    if (const auto foreign = foreign_cameras(root, request, draft)) {
      cameras = chosen_cameras(*foreign, root, request, draft);
      found.width_px = cameras.front().width_px, found.height_px = cameras.front().height_px;
    } else {
      take(root, request, found);
    }
    files += (files.empty() ? "" : ", ") + source.string();
  }
  if (request.width_px > 0) found.width_px = request.width_px, found.height_px = request.height_px;
  draft.camera.width_px = found.width_px, draft.camera.height_px = found.height_px;
  if (!found.corners && !found.matrix && cameras.empty())
    throw InputError(
        fmt::format("{}: found neither corners (image_points) nor a calibration (camera_matrix, or "
                    "those of camodocal, ORB-SLAM and basalt)",
                    files));
  if (found.width_px < 2 || found.height_px < 2)
    throw InputError(
        fmt::format("{}: says no size of the images, expected image_width and image_height or "
                    "--size WIDTHxHEIGHT",
                    files));
  if (found.matrix) cameras = {camera_of(found, draft)};
  if (!found.corners) return draft_protocol(cameras, request, draft);
  if (cameras.size() > 1)
    throw UsageError("opencv: corners of one camera, expected --camera with one name");
  draft_views(seen_views(found, request, draft), false, cameras, files, draft);
}

}  // namespace seam::app
