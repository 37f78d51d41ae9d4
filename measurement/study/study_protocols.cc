// Small protocols for studies: what is done is typical of its kind, and varied enough that the
// catalogue's effects can be told apart.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "measurement/study/study.h"
#include "sim_core/base/config.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"
#include "sim_core/base/output.h"
#include "sim_core/base/pose.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

constexpr RandomStream kProtocol{.seed = 20, .stream = 5};

double between(const char* what, uint64_t index, double low, double high) {
  return low + (high - low) * uniform(kProtocol.child(what), index);
}

}  // namespace

std::string head_rig(const std::string& tilt_axis) {
  return fmt::format(
      "rig:\n  chain:\n    - {{translate_m: [0, 0, 0.195]}}\n    - {{joint: tilt, axis: {}}}\n"
      "    - {{translate_m: [0, 0, 0.048]}}\n    - {{joint: pan, axis: [0, 0, 1]}}\n"
      "    - {{translate_m: [0.0666, 0, 0]}}\n",
      tilt_axis);
}

namespace {

// A head that nods and swings before a room of points.
std::string points(const std::filesystem::path& folder) {
  std::string joints = "time_s,tilt_rad,pan_rad\n";
  const auto pan = [](double t) { return 0.8 * maths::sin(5.1 * t) + 0.1 * maths::sin(17 * t); };
  const auto tilt = [](double t) { return 0.25 * maths::sin(3.3 * t + 0.4); };
  for (int i = 0; i <= 500; ++i) {
    const double t = 0.008 * i;
    joints += fmt::format("{:.6f},{:.7f},{:.7f}\n", t, tilt(t), pan(t));
  }
  std::string table = "frame,time_s,point,x_m,y_m,z_m\n";
  for (int frame = 0; frame < 42; ++frame) {
    for (int point = 0; point < 64; ++point) {
      const double bearing = between("bearing", point, -1.3, 1.3),
                   range = between("range", point, 0.7, 3);
      table += fmt::format("{},{:.6f},{},{:.5f},{:.5f},{:.5f}\n", frame,
                           0.15 + 0.08 * frame + 0.003 * (frame % 7), point,
                           range * maths::cos(bearing), range * maths::sin(bearing),
                           0.25 + range * between("height", point, -0.55, 0.55));
    }
  }
  write_file_atomically(folder / "joints.csv", joints);
  write_file_atomically(folder / "points.csv", table);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: points\ntitle: Study of points\n"
                        "camera: {width_px: 178, height_px: 144, frame_period_s: 0.08}\n"
                        "noise: {u_px: 0.15, v_px: 0.15}\ngroup: frame\n"
                        "files: {points: points.csv, joints: joints.csv}\n" +
                            head_rig("[0, -1, 0]"));
  return "{pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}}";
}

// w, x, y, z of a rotation: from the largest of them, so that none is divided by little.
std::array<double, 4> quaternion_of(const Mat3& R) {
  const double trace = R[0][0] + R[1][1] + R[2][2];
  const double squares[4] = {1 + trace, 1 + 2 * R[0][0] - trace, 1 + 2 * R[1][1] - trace,
                             1 + 2 * R[2][2] - trace};  // Each 4 q^2.
  const double from_w[4] = {squares[0], R[1][2] - R[2][1], R[2][0] - R[0][2], R[0][1] - R[1][0]};
  const double from_x[4] = {from_w[1], squares[1], R[1][0] + R[0][1], R[2][0] + R[0][2]};
  const double from_y[4] = {from_w[2], from_x[2], squares[2], R[2][1] + R[1][2]};
  const double from_z[4] = {from_w[3], from_x[3], from_y[3], squares[3]};
  const double* rows[4] = {from_w, from_x, from_y, from_z};
  const auto largest = std::max_element(squares, squares + 4) - squares;
  const double scale = 0.5 / std::sqrt(squares[largest]);
  const double* row = rows[largest];
  return {scale * row[0], scale * row[1], scale * row[2], scale * row[3]};
}

// A pose of the camera that looks from its place at a point, turned about the line of sight.
std::string pose_row(double t_s, const Vec3& eye, const Vec3& at, double roll_rad) {
  const Vec3 forward = glm::normalize(at - eye);
  const Vec3 level = glm::normalize(glm::cross(forward, Vec3(0, -1, 0)));
  const Vec3 right =
      maths::cos(roll_rad) * level + maths::sin(roll_rad) * glm::cross(forward, level);
  const Mat3 R(right, glm::cross(forward, right), forward);
  const auto q = quaternion_of(R);
  return fmt::format("{:.3f},{:.7f},{:.7f},{:.7f},{:.9f},{:.9f},{:.9f},{:.9f}\n", t_s, eye.x, eye.y,
                     eye.z, q[0], q[1], q[2], q[3]);
}

// A set of views of a target whose poses its reader does not know; `keys` are those that differ.
void write_views(const std::filesystem::path& folder, const std::string& poses,
                 const std::string& points, const std::string& keys) {
  write_file_atomically(folder / "poses.csv", poses);
  write_file_atomically(folder / "points.csv", points);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: points\ngroup: frame\n"
                        "files: {points: points.csv, poses: poses.csv}\n" +
                            keys);
}

// A board of 20 x 15 corners before a camera, in 16 views tilted all ways and turned; its reader
// does not know the poses.
std::string board(const std::filesystem::path& folder) {
  std::string table = "frame,time_s,point,x_m,y_m,z_m\n",
              poses = "time_s,x_m,y_m,z_m,qw,qx,qy,qz\n";
  for (int frame = 0; frame < 16; ++frame) {
    const double around = 2 * std::numbers::pi * frame / 16;
    const double tilt = frame % 4 == 0 ? 0.05 : between("tilt", frame, 0.3, 0.75);
    const double away = between("away", frame, 0.34, 0.5);
    const Vec3 at(between("x", frame, -0.09, 0.09), between("y", frame, -0.06, 0.06), 0);
    const Vec3 eye = at + away * Vec3(maths::sin(tilt) * maths::cos(around),
                                      maths::sin(tilt) * maths::sin(around), -maths::cos(tilt));
    poses += pose_row(frame, eye, at, between("roll", frame, -3, 3));
    for (int point = 0; point < 300; ++point)
      table += fmt::format("{0},{0},{1},{2:.4f},{3:.4f},0\n", frame, point,
                           0.02 * (point % 20 - 9.5), 0.02 * (point / 20 - 7));
  }
  write_views(folder, poses, table,
              "title: Study of boards\ncamera: {width_px: 640, height_px: 480}\n"
              "noise: {u_px: 0.15, v_px: 0.15}\nrig: {pose: unknown}\n");
  return "{pinhole: {fx_px: {value: 500, free: true}, fy_px: {value: 500, free: true}, cx_px: "
         "{value: 319.5, free: true}, cy_px: {value: 239.5, free: true}}, radial_distortion: "
         "{kappa: "
         "{value: -0.05, free: true}}}";
}

// A video of a board of 8 x 6 corners by a camera moved by hand: its aim and its place wander in
// waves of up to 1.6 Hz, by 1 rad/s and 0.1 m/s in the mean, which its reader does not know.
std::string video(const std::filesystem::path& folder) {
  constexpr double kPeriod_s = 0.04, kEach_s = 0.008;
  constexpr int kFrames = 24, kWaves = 3;
  const auto wave = [](uint64_t which, double speed, double t_s) {
    double sum = 0, speed2 = 0;
    for (int k = 0; k < kWaves; ++k) {
      const uint64_t at = which * kWaves + static_cast<uint64_t>(k);
      const double rate = 2 * std::numbers::pi * between("hand rate", at, 0.4, 1.6),
                   size = between("hand size", at, 0.5, 1) / rate;
      sum += size * maths::sin(rate * t_s + between("hand phase", at, 0, 6));
      speed2 += 0.5 * size * size * rate * rate;
    }
    return sum * speed / std::sqrt(speed2);
  };
  std::string table = "frame,time_s,point,x_m,y_m,z_m\n",
              poses = "time_s,x_m,y_m,z_m,qw,qx,qy,qz\n";
  const int last = static_cast<int>((kFrames + 2) * kPeriod_s / kEach_s);
  for (int i = -last / 8; i <= last; ++i) {
    const double t_s = kEach_s * i;
    const Vec3 eye(0.12 + wave(0, 0.1, t_s), 0.08 + wave(1, 0.1, t_s), -0.5 + wave(2, 0.1, t_s));
    // At half a metre the aim turns by twice what it wanders.
    const Vec3 at(wave(3, 0.3, t_s), wave(4, 0.3, t_s), 0);
    poses += pose_row(t_s, eye, at, wave(5, 0.55, t_s));
  }
  for (int frame = 0; frame < kFrames; ++frame) {
    for (int point = 0; point < 48; ++point)
      table += fmt::format("{},{:.3f},{},{:.4f},{:.4f},0\n", frame, kPeriod_s * frame, point,
                           0.04 * (point % 8 - 3.5), 0.04 * (point / 8 - 2.5));
  }
  write_views(folder, poses, table,
              "title: Study of videos\n"
              "camera: {width_px: 640, height_px: 480, frame_period_s: 0.04}\n"
              "noise: {u_px: 0.2, v_px: 0.2}\nrig: {pose: unknown, motion: spline}\n");
  return "{pinhole: {fx_px: {value: 500, free: true}, fy_px: {value: 500, free: true}, cx_px: "
         "{value: 319.5, free: true}, cy_px: {value: 239.5, free: true}}}";
}

// Steps of several heights, swings of several speeds and slow ramps.
std::string joints(const std::filesystem::path& folder) {
  std::string table = "run,time_s,joint,command_rad\n";
  for (int run = 0; run < 10; ++run) {
    for (int i = 0; i < 100; ++i) {
      const double t = 0.016 * i;
      double command = 0;
      if (run % 3 == 0) command = between("step", 100 * run + i / 14, -1.2, 1.2);
      if (run % 3 == 1) command = 0.7 * maths::sin((2 + 1.5 * run) * t);
      if (run % 3 == 2) command = 0.1 * run * (2 * std::abs(std::fmod(0.6 * t, 1.0) - 0.5) - 0.5);
      table += fmt::format("{},{:.6f},pan,{:.6f}\n", run, t, i < 3 ? 0.0 : command);
    }
  }
  write_file_atomically(folder / "joints.csv", table);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: joints\ntitle: Study of joints\n"
                        "noise: {measured_rad: 0.0006}\ngroup: run\nfiles: {joints: joints.csv}\n");
  return "{ideal_servo: {}}";
}

std::string odometry(const std::filesystem::path& folder) {
  std::string table = "run,time_s,vx_cmd_mps,vy_cmd_mps,omega_cmd_radps\n";
  for (int run = 0; run < 12; ++run) {
    for (int i = 0; i < 28; ++i) {
      const uint64_t leg = 100 * run + i / 6;
      table += fmt::format("{},{:.3f},{:.5f},{:.5f},{:.5f}\n", run, 0.2 * i,
                           between("vx", leg, -0.1, 0.25), between("vy", leg, -0.12, 0.12),
                           between("omega", leg, -1, 1));
    }
  }
  write_file_atomically(folder / "odometry.csv", table);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: odometry\ntitle: Study of walks\n"
                        "noise: {x_m: 0.002, y_m: 0.002, theta_rad: 0.003}\ngroup: run\nfiles: "
                        "{odometry: odometry.csv}\n");
  return "{ideal_odometry: {}}";
}

}  // namespace

void write_landmark_walks(const std::filesystem::path& folder, int runs, double first_time_s) {
  std::string places = "landmark,x_m,y_m\n";
  for (int k = 0; k < 6; ++k)
    places += fmt::format("{},{:.4f},{:.4f}\n", k, 2.2 * maths::cos(1.05 * k),
                          1.6 * maths::sin(1.05 * k));
  std::string poses = "run,time_s,x_m,y_m,theta_rad\n", seen = "run,time_s,landmark\n";
  for (int run = 0; run < runs; ++run) {
    for (int i = 0; i <= 400; ++i) {
      const double t = 0.02 * i, turn = 0.9 * t + run;
      const double at = first_time_s + 10 * run + t;
      poses += fmt::format("{},{:.4f},{:.7f},{:.7f},{:.7f}\n", run, at, 0.8 * maths::cos(turn),
                           0.6 * maths::sin(turn + 0.3 * run),
                           turn + std::numbers::pi / 2 + 0.3 * maths::sin(2 * t));
      if (i % 20 != 10) continue;
      for (int k = 0; k < 6; k += 2)
        seen += fmt::format("{},{:.4f},{}\n", run, at, (k + i / 20) % 6);
    }
  }
  write_file_atomically(folder / "landmarks.csv", places);
  write_file_atomically(folder / "poses.csv", poses);
  write_file_atomically(folder / "observations.csv", seen);
  write_file_atomically(
      folder / "measurement.yaml",
      "format: seam-measurement/1\nkind: landmarks\ntitle: Study of landmarks\n"
      "noise: {range_m: 0.03, bearing_rad: 0.006}\ngroup: run\n"
      "files: {observations: observations.csv, landmarks: landmarks.csv, poses: poses.csv}\n");
}

namespace {

std::string landmarks(const std::filesystem::path& folder) {
  write_landmark_walks(folder, 10, 0);
  return "{ideal_detector: {}}";
}

// Flat fields at five levels of light and two exposures.
std::string photometry(const std::filesystem::path& folder) {
  std::string table = "frame,file,time_s,exposure_s,illumination\n";
  int frame = 0;
  for (const double exposure : {0.005, 0.01}) {
    for (const double light : {0.0, 0.08, 0.2, 0.4}) {
      for (int k = 0; k < 5; ++k, ++frame)
        table +=
            fmt::format("{0},{0}.png,{1:.6f},{2},{3}\n", frame, 0.041 * frame, exposure, light);
    }
  }
  write_file_atomically(folder / "frames.csv", table);
  write_file_atomically(
      folder / "measurement.yaml",
      "format: seam-measurement/1\nkind: photometry\ntitle: Study of flat fields\n"
      "camera: {width_px: 16, height_px: 12, frame_period_s: 0.041}\ngroup: frame\n"
      "files: {frames: frames.csv}\n");
  return "{linear_response: {gain_dn: 220, black_dn: 16}, read_noise: {sigma_dn: 1.4}, "
         "rolling_shutter: {line_delay_s: 0.0012}}";
}

// A head that swings before a ball and posts; small images.
std::string frames(const std::filesystem::path& folder) {
  std::string joints = "time_s,tilt_rad,pan_rad\n", table = "frame,file,time_s\n";
  for (int i = 0; i <= 130; ++i) {
    const double t = 0.008 * i;
    joints += fmt::format("{:.6f},{:.7f},{:.7f}\n", t, 0.14 + 0.1 * maths::sin(4.2 * t),
                          0.6 * maths::sin(6.1 * t));
  }
  for (int frame = 0; frame < 6; ++frame)
    table += fmt::format("{0},{0}.png,{1:.6f}\n", frame, 0.15 + 0.13 * frame);
  write_file_atomically(folder / "joints.csv", joints);
  write_file_atomically(folder / "frames.csv", table);
  write_file_atomically(
      folder / "scene.yaml",
      "format: seam-scene/1\nbackground_rgb: [0.45, 0.45, 0.5]\nshading: flat\nobjects:\n"
      "  - {shape: rectangle, centre_m: [0, 0, 0], size_m: [4.2, 2.7], normal: [0, 0, 1], "
      "rgb: [0.05, 0.35, 0.08]}\n"
      "  - {shape: sphere, centre_m: [0.7, -0.2, 0.06], radius_m: 0.06, rgb: [0.9, 0.3, 0.02]}\n"
      "  - {shape: cylinder, base_m: [1.2, 0.6, 0], radius_m: 0.05, height_m: 0.4, "
      "rgb: [0.9, 0.4, 0.5]}\n"
      "  - {shape: cylinder, base_m: [1.3, -0.5, 0], radius_m: 0.05, height_m: 0.4, "
      "rgb: [0.9, 0.85, 0.1]}\n"
      "  - {shape: cylinder, base_m: [1, 0.1, 0], radius_m: 0.03, height_m: 0.5, "
      "rgb: [0.2, 0.6, 0.9]}\n");
  write_file_atomically(
      folder / "measurement.yaml",
      "format: seam-measurement/1\nkind: frames\ntitle: Study of images\n"
      "camera: {width_px: 60, height_px: 48, frame_period_s: 0.13}\ngroup: frame\n"
      "files: {frames: frames.csv, joints: joints.csv}\nscene: scene.yaml\n" +
          head_rig("[0, 1, 0]"));
  return "{pinhole: {fx_px: 54.6, fy_px: 54.8, cx_px: 29.5, cy_px: 23.5}, "
         "exposure: {exposure_s: 0.005}, read_noise: {sigma_dn: 1.5}}";
}

}  // namespace

Model write_study_protocol(const std::string& kind, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::string nominal;
  if (kind == "points") nominal = points(folder);
  if (kind == "board") nominal = board(folder);
  if (kind == "video") nominal = video(folder);
  if (kind == "joints") nominal = joints(folder);
  if (kind == "odometry") nominal = odometry(folder);
  if (kind == "landmarks") nominal = landmarks(folder);
  if (kind == "photometry") nominal = photometry(folder);
  if (kind == "frames") nominal = frames(folder);
  if (nominal.empty())
    throw InputError(
        fmt::format("no study protocol for kind '{}', expected points, board, video, joints, "
                    "odometry, landmarks, photometry or frames",
                    kind));
  return Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\nname: nominal\neffects: " + nominal + "\n", "nominal"));
}

}  // namespace seam::measurement
