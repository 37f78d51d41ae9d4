// `seam import euroc` and `seam import tum`: trajectories as the poses of a camera, or two of them
// as a walk and its odometry.
#include <algorithm>
#include <cmath>

#include "app/import/draft/calibration.h"
#include "app/import/draft/checks.h"
#include "app/import/draft/points_draft.h"
#include "app/import/draft/walk_draft.h"
#include "app/import/files/storage.h"
#include "app/import/files/text_table.h"
#include "app/import/kinds/kinds.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;

// Where the numbers of a row stand.
struct PoseColumns {
  size_t time = 0, x = 1, y = 2, z = 3, qw = 4, qx = 5, qy = 6, qz = 7;
  int64_t unit_ns = 1;
};

PoseColumns columns_of(const TextTable& table, bool euroc, const ImportRequest& request) {
  if (table.width() < 8)
    throw InputError(fmt::format(
        "{}:{}: found {} columns, expected 8 or more: {}", table.file(), table.line(0),
        table.width(), euroc ? "ns, x, y, z, qw, qx, qy, qz" : "seconds, x, y, z, qx, qy, qz, qw"));
  if (table.width() == 12 && table.columns().empty())
    throw InputError(fmt::format(
        "{}:{}: found 12 columns, as KITTI's poses have, which say no times: expected {}",
        table.file(), table.line(0),
        euroc ? "ns, x, y, z, qw, qx, qy, qz" : "seconds, x, y, z, qx, qy, qz, qw"));
  PoseColumns columns;
  columns.unit_ns = nanoseconds_in(!request.time_unit.empty() ? request.time_unit
                                   : euroc                    ? "ns"
                                                              : "s");
  if (!euroc) columns.qx = 4, columns.qy = 5, columns.qz = 6, columns.qw = 7;
  // A header that names them goes before habit.
  for (auto& [place, names] : std::vector<std::pair<size_t*, std::vector<std::string>>>{
           {&columns.qw, {"q_RS_w", "qw", "q_w", "q_RS_w []"}},
           {&columns.qx, {"q_RS_x", "qx", "q_x", "q_RS_x []"}},
           {&columns.qy, {"q_RS_y", "qy", "q_y", "q_RS_y []"}},
           {&columns.qz, {"q_RS_z", "qz", "q_z", "q_RS_z []"}}}) {
    const int found = table.find(names);
    if (found >= 0) *place = static_cast<size_t>(found);
  }
  return columns;
}

std::vector<StampedPose> read_poses(const fs::path& path, bool euroc, const ImportRequest& request,
                                    SetDraft& draft) {
  const TextTable table = TextTable::read(path);
  const PoseColumns c = columns_of(table, euroc, request);
  const double metres = request.length_unit.empty() ? 1 : metres_in(request.length_unit);
  std::vector<StampedPose> poses;
  std::vector<int64_t> times;
  std::vector<size_t> rows;
  size_t repeated = 0;
  for (size_t row = 0; row < table.rows(); ++row) {
    StampedPose pose{
        .ns = table.time_ns(row, c.time, c.unit_ns),
        .p = metres * Vec3(table.number(row, c.x), table.number(row, c.y), table.number(row, c.z)),
        .q = {table.number(row, c.qw), table.number(row, c.qx), table.number(row, c.qy),
              table.number(row, c.qz)}};
    const double length =
        std::hypot(std::hypot(pose.q[0], pose.q[1]), std::hypot(pose.q[2], pose.q[3]));
    if (!(std::abs(length - 1) < 0.02))
      table.fail(row, c.qw,
                 fmt::format("a quaternion of length 1, not {:.4g}: other columns?", length));
    for (double& q : pose.q) q /= length;
    if (!times.empty() && pose.ns == times.back()) {
      ++repeated;
      continue;
    }
    times.push_back(pose.ns), rows.push_back(row), poses.push_back(pose);
  }
  check_times(
      times, [&](size_t i) { return fmt::format("{}:{}", table.file(), table.line(rows[i])); },
      request, 5, draft);
  if (poses.size() < 3)
    throw InputError(
        fmt::format("{}: found {} poses, expected 3 or more", table.file(), poses.size()));
  if (repeated > 0) draft.warn(fmt::format("{} rows repeat a time: left out", repeated));
  check_speed(poses, table.file(), request);
  return poses;
}

// What an ASL folder holds.
struct AslFolder {
  fs::path poses, camera, frames;
};

AslFolder look_into(const fs::path& source, const std::string& camera) {
  if (!fs::is_directory(source)) return {.poses = source, .camera = {}, .frames = {}};
  const fs::path root = fs::is_directory(source / "mav0") ? source / "mav0" : source;
  AslFolder found;
  for (const char* name :
       {"state_groundtruth_estimate0", "vicon0", "leica0", "pose0", "mocap0", ""}) {
    const fs::path table = root / name / "data.csv";
    if (fs::is_regular_file(table)) {
      found.poses = table;
      break;
    }
  }
  if (found.poses.empty())
    throw InputError(fmt::format(
        "{}: holds no poses, expected state_groundtruth_estimate0/data.csv", source.string()));
  const fs::path sensor = root / (camera.empty() ? "cam0" : camera);
  if (!camera.empty() && !fs::is_directory(sensor))
    throw InputError(fmt::format("{}: no such folder: --camera {}", sensor.string(), camera));
  if (fs::is_regular_file(sensor / "sensor.yaml")) found.camera = sensor / "sensor.yaml";
  if (fs::is_regular_file(sensor / "data.csv")) found.frames = sensor / "data.csv";
  return found;
}

// The camera of a sensor.yaml and how it sits on the body.
PlainCamera read_sensor(const fs::path& path, Pose& X_BC, SetDraft& draft) {
  const ConfigNode root = read_storage(path);
  PlainCamera camera{.name = "cam0"};
  const auto k = numbers_in(root.at("intrinsics")), size = numbers_in(root.at("resolution"));
  if (k.size() != 4) root.at("intrinsics").fail("expected fu, fv, cu, cv");
  if (size.size() != 2) root.at("resolution").fail("expected width and height");
  camera.width_px = static_cast<int>(size[0]), camera.height_px = static_cast<int>(size[1]);
  camera.lens.fx_px = k[0], camera.lens.fy_px = k[1];
  camera.lens.cx_px = k[2], camera.lens.cy_px = k[3];
  const size_t form =
      root.at("distortion_model").choice({"radial-tangential", "equidistant", "none"});
  const auto d = form == 2 ? std::vector<double>{} : numbers_in(root.at("distortion_coefficients"));
  take_coefficients(d, form == 1, root.at("distortion_model").where(), camera.lens, draft);
  check_camera(camera, path.string());
  const auto T = numbers_in(root.at("T_BS"));
  if (T.size() != 16) root.at("T_BS").fail("expected 4 x 4 numbers");
  X_BC.R = Mat3(T[0], T[4], T[8], T[1], T[5], T[9], T[2], T[6], T[10]);
  X_BC.p = Vec3(T[3], T[7], T[11]);
  if (!(std::abs(glm::determinant(X_BC.R) - 1) < 1e-3))
    root.at("T_BS").fail("expected a rotation in the first three rows and columns");
  return camera;
}

void import_trajectory(const ImportRequest& request, bool euroc, SetDraft& draft) {
  if (request.sources.size() > 2)
    throw UsageError("expected one trajectory, or two: the truth, then what was estimated");
  const AslFolder folder = look_into(request.sources[0], request.camera);
  const auto poses = read_poses(folder.poses, euroc, request, draft);
  if (request.sources.size() == 2) {
    // The second may be of the other habit.
    const auto other = look_into(request.sources[1], "").poses;
    const auto estimate = read_poses(other, euroc && other.extension() == ".csv", request, draft);
    return draft_walk_of_estimate(poses, folder.poses.string(), estimate, other.string(), draft);
  }
  Pose X_BC{Mat3(1.0), Vec3(0.0)};
  PlainCamera camera;
  if (!folder.camera.empty()) {
    camera = read_sensor(folder.camera, X_BC, draft);
    draft.did("the camera, its lens and its place on the body from sensor.yaml");
  } else {
    camera = camera_for_granted(request, draft);
  }
  std::vector<int64_t> stamps;
  if (!folder.frames.empty()) {
    const TextTable frames = TextTable::read(folder.frames);
    for (size_t row = 0; row < frames.rows(); ++row) stamps.push_back(frames.time_ns(row, 0, 1));
  }
  draft_poses(poses, stamps, X_BC, camera, draft);
}

}  // namespace

void import_euroc(const ImportRequest& request, SetDraft& draft) {
  import_trajectory(request, true, draft);
}

void import_tum(const ImportRequest& request, SetDraft& draft) {
  import_trajectory(request, false, draft);
}

}  // namespace seam::app
