#include "app/import/draft/walk_draft.h"

#include <algorithm>
#include <cmath>

#include "app/import/draft/points_draft.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::app {
namespace {

double seconds_between(int64_t from, int64_t to) {
  return 1e-9 * static_cast<double>(to - from);
}

// Where the poses are, and a box of points around them.
std::vector<Vec3> points_around(const std::vector<StampedPose>& poses) {
  constexpr int kSide = 5;
  Vec3 low = poses.front().p, high = low;
  for (const StampedPose& pose : poses) low = glm::min(low, pose.p), high = glm::max(high, pose.p);
  const double margin_m = std::max(1.0, 0.5 * glm::length(high - low));
  low -= Vec3(margin_m), high += Vec3(margin_m);
  std::vector<Vec3> points;
  for (int i = 0; i < kSide * kSide * kSide; ++i) {
    const Vec3 share = Vec3(i % kSide, i / kSide % kSide, i / kSide / kSide) / (kSide - 1.0);
    points.push_back(low + share * (high - low));
  }
  return points;
}

StampedPose pose_near(const std::vector<StampedPose>& poses, int64_t ns) {
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), ns,
                       [](const StampedPose& pose, int64_t t) { return pose.ns < t; });
  return after == poses.end() ? poses.back() : *after;
}

// Between the second and the ninety-eighth percentile.
double inner_extent(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t cut = values.size() / 50;
  return values.empty() ? 0 : values[values.size() - 1 - cut] - values[cut];
}

Vec3 mean_of(const std::vector<Vec3>& directions) {
  Vec3 sum(0.0);
  for (const Vec3& direction : directions) sum += direction;
  return sum / std::max(1.0, static_cast<double>(directions.size()));
}

// By how much the axis turns away from its mean direction; a tracker may sit aslant on the body.
double usual_tilt(const std::vector<Vec3>& up) {
  if (up.empty()) return 0;
  const Vec3 mean = glm::normalize(mean_of(up) + Vec3(0, 0, 1e-12));
  std::vector<double> tilts;
  for (const Vec3& axis : up) tilts.push_back(std::acos(std::clamp(glm::dot(axis, mean), -1., 1.)));
  std::sort(tilts.begin(), tilts.end());
  return tilts[tilts.size() - 1 - tilts.size() / 50];
}

bool up_is_no_axis(const std::vector<Vec3>& up) {
  return !up.empty() && std::abs(mean_of(up).z) < 0.7;
}

}  // namespace

// By its largest component.
std::array<double, 4> quaternion_of(const Mat3& R) {
  // m(i, j) is row i, column j.
  const auto m = [&](int i, int j) { return R[j][i]; };
  const double trace = m(0, 0) + m(1, 1) + m(2, 2);
  std::array<double, 4> squares = {1 + trace, 1 + 2 * m(0, 0) - trace, 1 + 2 * m(1, 1) - trace,
                                   1 + 2 * m(2, 2) - trace};
  const auto largest = std::max_element(squares.begin(), squares.end()) - squares.begin();
  const double root = 0.5 * std::sqrt(squares[static_cast<size_t>(largest)]);
  const double part = 0.25 / root;
  switch (largest) {
    case 0:
      return {root, (m(2, 1) - m(1, 2)) * part, (m(0, 2) - m(2, 0)) * part,
              (m(1, 0) - m(0, 1)) * part};
    case 1:
      return {(m(2, 1) - m(1, 2)) * part, root, (m(0, 1) + m(1, 0)) * part,
              (m(0, 2) + m(2, 0)) * part};
    case 2:
      return {(m(0, 2) - m(2, 0)) * part, (m(0, 1) + m(1, 0)) * part, root,
              (m(1, 2) + m(2, 1)) * part};
    default:
      return {(m(1, 0) - m(0, 1)) * part, (m(0, 2) + m(2, 0)) * part, (m(1, 2) + m(2, 1)) * part,
              root};
  }
}

Mat3 rotation_of(const std::array<double, 4>& q) {
  return rotation_from_quaternion(q[0], q[1], q[2], q[3]);
}

PlanarPose planar(const StampedPose& pose) {
  const Mat3 R = rotation_of(pose.q);
  return {pose.ns, pose.p.x, pose.p.y, std::atan2(R[0].y, R[0].x)};
}

std::string check_plane(const std::vector<Vec3>& places, const std::vector<Vec3>& up,
                        const std::string& where, const std::string& remedy) {
  // A floor that is a little uneven, and a tracker's noise. Beyond it a walk in a plane is another.
  constexpr double kMostShare = 0.05, kLeastHeight_m = 0.05, kMostTilt_rad = 10 * maths::kPi / 180;
  std::array<double, 3> extent{};
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> along;
    for (const Vec3& place : places) along.push_back(place[axis]);
    extent[static_cast<size_t>(axis)] = inner_extent(std::move(along));
  }
  const double across_m = std::hypot(extent[0], extent[1]), height_m = extent[2];
  const double tilt_rad = usual_tilt(up);
  if (up_is_no_axis(up))
    throw InputError(
        fmt::format("{}: the body's z axis is not upright (a camera's is not), expected poses of a "
                    "body with x forward and z up: turn them; {}",
                    where, remedy));
  if (height_m > std::max(kLeastHeight_m, kMostShare * across_m))
    throw InputError(fmt::format(
        "{}: the path leaves the plane: heights differ by {:.3g} m over an extent of {:.3g} m{}; "
        "{}",
        where, height_m, across_m,
        std::min(extent[0], extent[1]) < 0.2 * height_m ? " (does another axis point up?)" : "",
        remedy));
  if (tilt_rad > kMostTilt_rad)
    throw InputError(fmt::format("{}: the path leaves the plane: the body tilts by {:.3g} deg; {}",
                                 where, tilt_rad * 180 / maths::kPi, remedy));
  if (!(height_m > 0) && !(tilt_rad > 1e-6)) return "";
  return fmt::format(
      "laid on the plane: heights that differ by {:.3g} m and tilts of {:.2g} deg "
      "are left out",
      height_m, tilt_rad * 180 / maths::kPi);
}

std::vector<PlanarPose> planar(const std::vector<StampedPose>& path, const std::string& where,
                               SetDraft& draft) {
  std::vector<Vec3> places, up;
  std::vector<PlanarPose> poses;
  for (const StampedPose& pose : path) {
    places.push_back(pose.p), up.push_back(rotation_of(pose.q)[2]);
    poses.push_back(planar(pose));
  }
  const std::string lost =
      path.empty() ? ""
                   : check_plane(places, up, where,
                                 "a walk lies in a plane: expected a body on the ground (where "
                                 "heights are noise alone, write 0 for them)");
  if (!lost.empty()) draft.did(fmt::format("{}: {}", where, lost));
  return poses;
}

void check_speed(const std::vector<StampedPose>& poses, const std::string& where,
                 const ImportRequest& request) {
  constexpr double kMost_mps = 60;
  std::vector<double> speeds;
  for (size_t i = 1; i < poses.size(); ++i)
    speeds.push_back(glm::length(poses[i].p - poses[i - 1].p) /
                     seconds_between(poses[i - 1].ns, poses[i].ns));
  if (speeds.empty() || !request.length_unit.empty()) return;
  std::nth_element(speeds.begin(), speeds.begin() + static_cast<std::ptrdiff_t>(speeds.size() / 2),
                   speeds.end());
  const double usual = speeds[speeds.size() / 2];
  if (usual > kMost_mps)
    throw InputError(
        fmt::format("{}: found a usual speed of {:.3g} m/s, which looks like millimetres; say it, "
                    "--length-unit "
                    "mm, or --length-unit m where it is right",
                    where, usual));
}

void draft_poses(const std::vector<StampedPose>& poses, const std::vector<int64_t>& stamps,
                 const Pose& X_BC, const PlainCamera& camera, SetDraft& draft) {
  constexpr size_t kFrames = 60;
  draft.kind = "points";
  draft.group = "frame";
  draft.rig = "{poses: poses.csv}";
  draft.camera.width_px = camera.width_px, draft.camera.height_px = camera.height_px;
  measurement::CsvWriter track({"time_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"});
  for (const StampedPose& pose : poses) {
    // Position and rotation of the camera; the quaternion of X_BC by way of its matrix.
    const Pose X_WC = Pose{rotation_of(pose.q), pose.p} * X_BC;
    const std::array<double, 4> q = quaternion_of(X_WC.R);
    track.row({seconds_text(pose.ns), exact(X_WC.p.x), exact(X_WC.p.y), exact(X_WC.p.z),
               fmt::format("{:.9f}", q[0]), fmt::format("{:.9f}", q[1]),
               fmt::format("{:.9f}", q[2]), fmt::format("{:.9f}", q[3])});
  }
  std::vector<int64_t> times;
  for (const int64_t stamp : stamps) {
    if (stamp >= poses.front().ns && stamp <= poses.back().ns) times.push_back(stamp);
  }
  if (times.empty()) {
    for (size_t i = 0; i < kFrames; ++i)
      times.push_back(poses.front().ns +
                      static_cast<int64_t>(static_cast<double>(poses.back().ns - poses.front().ns) *
                                           static_cast<double>(i) / kFrames));
  }
  const size_t stride = (times.size() + kFrames - 1) / kFrames;
  const std::vector<Vec3> points = points_around(poses);
  measurement::CsvWriter table({"frame", "time_s", "point", "x_m", "y_m", "z_m"});
  size_t rows = 0, frames = 0;
  for (size_t i = 0; i < times.size(); i += stride, ++frames) {
    const StampedPose at = pose_near(poses, times[i]);
    const Pose X_CW = (Pose{rotation_of(at.q), at.p} * X_BC).inverse();
    for (size_t k = 0; k < points.size(); ++k) {
      const Vec3 p_C = X_CW * points[k];
      const bool ahead = p_C.z > 0.3 &&
                         std::abs(p_C.x / p_C.z) * camera.lens.fx_px < 0.6 * camera.width_px &&
                         std::abs(p_C.y / p_C.z) * camera.lens.fy_px < 0.6 * camera.height_px;
      if (!ahead) continue;
      table.row({fmt::format("{}", i), seconds_text(times[i]), fmt::format("{}", k),
                 exact(points[k].x), exact(points[k].y), exact(points[k].z)});
      ++rows;
    }
  }
  if (rows == 0) throw InputError("none of the points around the path comes before the camera");
  draft.add_table("points", table);
  draft.add_table("poses", track);
  draft.effects = effects_of(camera);
  draft.did(fmt::format("{} poses over {:.4g} s in poses.csv, as the rig of a set of points",
                        poses.size(), seconds_between(poses.front().ns, poses.back().ns)));
  draft.did(
      fmt::format("trajectories hold no observations: points.csv is a protocol, {} points of a "
                  "made-up box in {} "
                  "frames along the path; put yours in its place, or `seam measure` it",
                  points.size(), frames));
  draft.could_not_know("what the camera saw, and where that stands");
}

PlainCamera camera_for_granted(const ImportRequest& request, SetDraft& draft) {
  PlainCamera camera{.name = "camera"};
  camera.width_px = request.width_px > 0 ? request.width_px : 640;
  camera.height_px = request.width_px > 0 ? request.height_px : 480;
  camera.lens = {.family = LensFamily::pinhole,
                 .fx_px = 0.8 * camera.width_px,
                 .fy_px = 0.8 * camera.width_px,
                 .cx_px = 0.5 * (camera.width_px - 1),
                 .cy_px = 0.5 * (camera.height_px - 1)};
  draft.could_not_know(fmt::format(
      "the camera: one of {} x {} px and {:.0f} px focal length is taken, as if the poses were its "
      "own (x right, y down, z forward)",
      camera.width_px, camera.height_px, camera.lens.fx_px));
  return camera;
}

std::vector<VelocityCommand> velocities_of(const std::vector<PlanarPose>& poses) {
  std::vector<VelocityCommand> commands;
  for (size_t i = 0; i + 1 < poses.size(); ++i) {
    const PlanarPose &a = poses[i], &b = poses[i + 1];
    const double dt = seconds_between(a.ns, b.ns);
    if (!(dt > 0)) continue;
    const double turn = maths::wrap_angle(b.theta_rad - a.theta_rad);
    // The arc's chord in the body's frame; a straight line's where it hardly turns.
    const double dx = b.x_m - a.x_m, dy = b.y_m - a.y_m;
    const double c = std::cos(a.theta_rad), s = std::sin(a.theta_rad);
    const double x = c * dx + s * dy, y = c * dy - s * dx;
    const double sine = std::abs(turn) < 1e-6 ? 1 : std::sin(turn) / turn;
    const double cosine = std::abs(turn) < 1e-6 ? 0.5 * turn : (1 - std::cos(turn)) / turn;
    const double det = sine * sine + cosine * cosine;
    commands.push_back(
        {a.ns, (sine * x + cosine * y) / det / dt, (sine * y - cosine * x) / det / dt, turn / dt});
  }
  return commands;
}

void draft_walk(const std::vector<VelocityCommand>& commands, const std::vector<PlanarPose>& poses,
                SetDraft& draft, const std::vector<int64_t>& breaks) {
  std::vector<PlanarPose> seen;
  for (const PlanarPose& pose : poses) {
    const bool within =
        !commands.empty() && pose.ns >= commands.front().ns && pose.ns <= commands.back().ns;
    if (within && (seen.empty() || pose.ns > seen.back().ns)) seen.push_back(pose);
  }
  if (seen.size() < 4)
    throw InputError(fmt::format(
        "found {} measured poses while commands were given, expected 4 or more: other clocks?",
        seen.size()));
  // A long walk in parts, so that some can be held out; each begins where it was measured.
  const size_t parts = breaks.empty() ? std::clamp<size_t>(seen.size() / 16, 1, 20) : 1;
  measurement::CsvWriter table(
      {"run", "time_s", "vx_cmd_mps", "vy_cmd_mps", "omega_cmd_radps", "x_m", "y_m", "theta_rad"});
  size_t next = 0, run = 0, in_run = 0, rows = 0;
  VelocityCommand now;
  const auto row = [&](int64_t ns, const PlanarPose* pose) {
    table.row({fmt::format("{}", run), seconds_text(ns), exact(now.vx_mps), exact(now.vy_mps),
               exact(now.omega_radps), pose ? exact(pose->x_m) : "", pose ? exact(pose->y_m) : "",
               pose ? exact(pose->theta_rad) : ""});
    ++rows;
  };
  auto begins = breaks.begin();
  for (size_t i = 0; i < seen.size(); ++i) {
    for (; begins != breaks.end() && *begins <= seen[i].ns; ++begins) {
      if (in_run > 0) ++run;
      in_run = 0;
    }
    for (; next < commands.size() && commands[next].ns < seen[i].ns; ++next) {
      now = commands[next];
      if (i > 0 && in_run > 0) row(now.ns, nullptr);
    }
    if (next < commands.size() && commands[next].ns == seen[i].ns) now = commands[next++];
    row(seen[i].ns, &seen[i]);
    ++in_run;
    if (i + 1 < seen.size() && (i + 1) * parts / seen.size() != i * parts / seen.size())
      ++run, in_run = 0;
  }
  draft.kind = "odometry";
  draft.group = "run";
  draft.effects = "  ideal_odometry: {}\n";
  draft.add_table("odometry", table);
  draft.did(fmt::format("{} rows: {} measured poses among {} velocities, in {} runs", rows,
                        seen.size(), commands.size(), run + 1));
  if (parts > 1)
    draft.did(
        "one walk is cut into runs of equal length, so that some can be held out; each begins "
        "anew where it was measured, in motion");
  draft.could_not_know("the noise of the poses: it is estimated");
}

void draft_walk_of_estimate(const std::vector<StampedPose>& truth, const std::string& truth_name,
                            const std::vector<StampedPose>& estimate,
                            const std::string& estimate_name, SetDraft& draft) {
  const std::vector<PlanarPose> poses = planar(truth, truth_name, draft);
  const std::vector<PlanarPose> steps = planar(estimate, estimate_name, draft);
  draft_walk(velocities_of(steps), poses, draft);
  draft.did(
      "the second trajectory's own steps stand for the commanded velocities, the first is "
      "what was measured");
  draft.could_not_know("what was commanded: this constrains odometry's errors, not the gait's");
}

}  // namespace seam::app
