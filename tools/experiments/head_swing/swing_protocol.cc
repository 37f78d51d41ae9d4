// The swing as a measurement set: what stands before the camera of the localising robot, when its
// frames are stamped, and where its head is said to be. `seam measure` records it with the camera
// of one mode; `seam compare` and `seam diagnose` hold the other mode's camera against the record.
#include <fmt/format.h>

#include <cmath>

#include "sim_core/base/maths.h"
#include "sim_core/base/output.h"
#include "sim_core/body/robot_body.h"
#include "tools/experiments/head_swing/swing_studies.h"

namespace seam::tools {
namespace {

constexpr double kDuration_s = 8.5;      // Two swings.
constexpr double kFirstStamp_s = 0.013;  // The camera's own clock.
constexpr double kBodyHeight_m = 0.145;  // On its paws.
constexpr int kLockedFrames = 25;        // A swing.

struct Point {
  double x_m, y_m, z_m;
};

// The corners of beacons' bands, as they are seen from the pose, and of the goals' mouths.
std::vector<Point> points_seen_from(const Pose2& pose) {
  constexpr double kRadius_m = 0.05;
  std::vector<Point> points;
  for (const Landmark& beacon : kBeaconPlaces) {
    const double towards = maths::atan2(beacon.y_m - pose.y_m, beacon.x_m - pose.x_m);
    for (const double side : {-kRadius_m, kRadius_m}) {
      for (const double z_m : {0.2, 0.3, 0.4})
        points.push_back({beacon.x_m - side * maths::sin(towards),
                          beacon.y_m + side * maths::cos(towards), z_m});
    }
  }
  for (const double x_m : {-2.1, 2.1}) {
    for (const double y_m : {-0.3, 0.3}) {
      for (const double z_m : {0.0, 0.3}) points.push_back({x_m, y_m, z_m});
    }
  }
  return points;
}

std::string rig_of(const Pose2& pose) {
  const RobotBody body;  // The published chain of the ERS-210 is its default.
  return fmt::format(
      "rig:\n  chain:\n"
      "    - {{translate_m: [{}, {}, {}]}}\n"
      "    - {{rotate_rad: [0, 0, {:.9f}]}}\n"
      "    - {{translate_m: [{}, {}, {}]}}\n"
      "    - {{joint: tilt, axis: [0, -1, 0]}}\n"
      "    - {{translate_m: [0, 0, {}]}}\n"
      "    - {{joint: pan, axis: [0, 0, 1]}}\n"
      "    - {{translate_m: [{}, 0, 0]}}\n",
      pose.x_m, pose.y_m, kBodyHeight_m, pose.theta_rad, body.tilt_axis_m.x, body.tilt_axis_m.y,
      body.tilt_axis_m.z, body.roll_height_m, body.camera_forward_m);
}

constexpr char kSet[] =
    "format: seam-measurement/1\nkind: points\ntitle: Beacons and goals seen from a swinging head\n"
    "camera: {width_px: 178, height_px: 144, frame_period_s: 0.04}\n"
    "noise: {u_px: 0.3, v_px: 0.3}   # of a corner in the image: assumed\n"
    "group: frame\nfiles: {points: points.csv, joints: joints.csv}\n";

std::string model(const char* name, const char* comment, const std::string& timing) {
  return fmt::format(
      "# {}\nformat: seam-model/1\nname: {}\neffects:\n"
      "  pinhole: {{fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}}\n"
      "  radial_distortion: {{kappa: -0.05}}\n{}",
      comment, name, timing);
}

}  // namespace

void write_swing_protocol(const std::filesystem::path& folder) {
  const Pose2 pose = paper_poses(4)[2];
  std::string joints = "time_s,tilt_rad,pan_rad\n", points = "frame,time_s,point,x_m,y_m,z_m\n";
  for (int i = 0; 0.008 * i < kDuration_s + 0.1; ++i)
    joints += fmt::format("{:.3f},0,{:.7f}\n", 0.008 * i, kSwing.pan_rad(0.008 * i));
  const std::vector<Point> seen = points_seen_from(pose);
  for (int frame = 0; kFirstStamp_s + kFramePeriod_s * frame < kDuration_s; ++frame) {
    for (size_t i = 0; i < seen.size(); ++i)
      points += fmt::format("{},{:.3f},{},{:.5f},{:.5f},{:.5f}\n", frame,
                            kFirstStamp_s + kFramePeriod_s * frame, i, seen[i].x_m, seen[i].y_m,
                            seen[i].z_m);
  }
  const std::string lock = fmt::format("  frame_sync: {{period_frames: {}}}\n", kLockedFrames);
  const std::string rows =
      "  rolling_shutter: {line_delay_s: 2.78e-4}\n  exposure: {exposure_s: 0.005}\n";
  std::filesystem::create_directories(folder / "protocol");
  write_file_atomically(folder / "protocol" / "measurement.yaml", kSet + rig_of(pose));
  write_file_atomically(folder / "protocol" / "joints.csv", joints);
  write_file_atomically(folder / "protocol" / "points.csv", points);
  write_file_atomically(
      folder / "locked.yaml",
      model("locked", "Frames locked to the swing, rows one after another.", lock + rows));
  write_file_atomically(
      folder / "locked_instant.yaml",
      model("locked-instant", "Frames locked to the swing, all rows at once.", lock));
  write_file_atomically(folder / "scheduled.yaml",
                        model("scheduled", "Rows at their times on the camera's own clock.", rows));
  write_file_atomically(folder / "instant.yaml",
                        model("instant", "The camera's own clock, all rows at once.", ""));
}

}  // namespace seam::tools
