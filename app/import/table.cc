// The table of imports, a row each: all that the command, the recognition of files and the fuzzer
// know of an import.
#include "app/import/file_look.h"
#include "app/import/import.h"
#include "app/import/kinds/kinds.h"
#include "app/import/servo/servo_columns.h"
#include "app/import/tracks/wheel_columns.h"

namespace seam::app {
namespace {

const std::vector<std::string> kOfCalibrations = {"corners",      "target",     "camera_matrix",
                                                  "distortion",   "names",      "board_width",
                                                  "board_height", "square_size"};

std::vector<std::string> with_calibrations(std::vector<std::string> names) {
  names.insert(names.end(), kOfCalibrations.begin(), kOfCalibrations.end());
  return names;
}

bool is_bag(const FileLook& look) {
  return look.ends({".bag", ".mcap"});
}
bool is_yaml(const FileLook& look) {
  return look.ends({".yaml", ".yml", ".xml"});
}
bool has_corners(const FileLook& look) {
  return (look.has_column({"u", "u_px"}) && look.has_column({"v", "v_px"})) ||
         (look.has_column({"x_px"}) && look.has_column({"y_px"}));
}
bool has_quaternions(const FileLook& look) {
  return look.has_column({"qw", "q_w", "q_rs_w"});
}
bool has_bearings_or_ranges(const FileLook& look) {
  return look.has_column({"landmark", "beacon", "anchor", "beacon_id", "anchor_id"});
}
bool has_wheels(const FileLook& look) {
  if (!look.table || has_bearings_or_ranges(look)) return false;
  const MotionColumns columns = motion_columns(*look.table, {});
  return columns.are_wheels() || columns.are_velocities();
}

}  // namespace

// Of a file that several would read, the first in this order is proposed.
const std::vector<ImportKind>& import_kinds() {
  static const std::vector<ImportKind> kinds = {
      {.name = "images",
       .help = "pictures, or a bag of ROS, of a chessboard or circles, or with a target YAML of an "
               "AprilGrid or ChArUco "
               "board; times from names, a CSV or EXIF",
       .options = {"target", "board", "spacing", "length-unit", "time-unit", "map", "camera"},
       .quantities = {"file", "time"},
       .fill = import_images,
       .what = "pictures of a target",
       .also = {"pictures", "photos", "chessboard", "video", "image", "board"},
       .looks =
           [](const FileLook& look) {
             return look.ends({".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".webp"});
           },
       .fuzzed = false},
      {.name = "kalibr",
       .help = "a camchain, a target YAML, corners as CSV",
       .options = {"map", "board", "spacing", "length-unit", "time-unit", "size", "camera"},
       .quantities = {"time", "frame", "camera", "tag", "point", "row", "column", "u", "v"},
       .fill = import_kalibr,
       .what = "corners as CSV (with --board 8x6 --spacing METRES --size WIDTHxHEIGHT)",
       .also = {"corners", "camchain", "points", "april", "aprilgrid"},
       .looks =
           [](const FileLook& look) {
             return has_corners(look) ||
                    (is_yaml(look) && (look.holds("camera_model:") || look.holds("target_type:")));
           }},
      {.name = "opencv",
       .help = "corners and calibration in YAML or XML of cv::FileStorage, camera_info YAML, "
               "calibrations of camodocal, ORB-SLAM and basalt",
       .options = {"map", "board", "spacing", "length-unit", "size", "camera"},
       .quantities = kOfCalibrations,
       .fill = import_opencv,
       .what = "calibrations of OpenCV",
       .also = {"calibration", "camera", "camera_info", "cv"},
       .looks =
           [](const FileLook& look) {
             return is_yaml(look) && (look.holds("camera_matrix") || look.holds("image_points") ||
                                      look.holds("cameraMatrix"));
           }},
      {.name = "mrcal",
       .help = "corners as .vnl and a .cameramodel, or a .cameramodel with its inputs",
       .options = {"board", "spacing", "length-unit", "size", "camera"},
       .fill = import_mrcal,
       .what = "corners and models of mrcal",
       .also = {"vnl", "cameramodel"},
       .looks =
           [](const FileLook& look) {
             return look.ends({".vnl", ".cameramodel"});
           }},
      {.name = "bouguet",
       .help = "Calib_Results.mat of the toolbox for MATLAB (save it with -v7)",
       .options = {"length-unit"},
       .fill = import_bouguet,
       .what = "results of the toolbox for MATLAB",
       .also = {"matlab"},
       .looks = [](const FileLook& look) { return look.name.starts_with("Calib_Results"); }},
      {.name = "ranges",
       .help = "ranges and bearings to beacons, their places and a path: the Plaza sets' .mat, or "
               "three CSV",
       .options = {"map", "unit", "time-unit", "length-unit"},
       .quantities = {"time", "beacon", "range", "bearing", "x", "y", "z", "theta", "qw", "qx",
                      "qy", "qz", "path", "ranges", "beacons"},
       .own_units = true,
       .fill = import_ranges,
       .what = "ranges and bearings to beacons",
       .also = {"bearings", "beacons", "landmarks", "anchors", "uwb", "distances"},
       .looks = has_bearings_or_ranges},
      {.name = "wheels",
       .help = "ticks or speeds of two wheels, or velocities of a body, and its poses: CSV, the "
               "poses also in a file of their own with its own clock",
       .options = {"map", "unit", "time-unit", "length-unit", "base", "radius", "metres-per-tick"},
       .quantities = {"time", "run", "left", "right", "vx", "vy", "omega", "x", "y", "z", "theta",
                      "qw", "qx", "qy", "qz", "pose_time"},
       .own_units = true,
       .fill = import_wheels,
       .what = "ticks and poses",
       .also = {"odometry", "odom", "ticks", "encoders", "encoder", "wheel", "drive", "velocities",
                "robot"},
       .looks = has_wheels},
      {.name = "servo",
       .help = "logs of commanded and measured angles: CSV or JSON, a file a run, or commands and "
               "states in two files",
       .options = {"map", "unit", "time-unit", "reverse", "off-where"},
       .quantities = {"time", "command", "measured", "run", "joint", "kp", "voltage", "effort",
                      "torque_enable"},
       .fill = import_servo,
       .what = "logs of a servo",
       .also = {"joints", "joint", "motor", "motors", "actuator", "arm"},
       .looks =
           [](const FileLook& look) {
             const auto has = [&](const Names& names) {
               return look.has_column(names) || (look.ends({".json"}) && look.has_key(names));
             };
             return look.ends({".jsonl"}) ||
                    (has(servo_names().commands) && has(servo_names().measured));
           }},
      {.name = "imu",
       .help =
           "readings of a gyroscope, an accelerometer or both, CSV or a bag of ROS, a file a run",
       .options = {"map", "unit", "time-unit"},
       .quantities = {"time", "gx", "gy", "gz", "ax", "ay", "az", "temperature", "imu"},
       .own_units = true,
       .fill = import_imu,
       .what = "readings of inertial sensors",
       .also = {"inertial", "gyro", "gyroscope", "accelerometer", "mpu6050"},
       .looks =
           [](const FileLook& look) {
             return look.has_column({"gx", "gyro_x", "gyr_x", "wx", "w_RS_S_x", "wx_radps"}) ||
                    look.has_column({"ax", "acc_x", "accel_x", "a_RS_S_x", "ax_mps2"});
           }},
      {.name = "ros",
       .help =
           "a bag of ROS 2 (MCAP) or ROS 1: states of controllers, joints or a walk with commands, "
           "pictures, CameraInfo, poses and TF; camera_info YAML",
       .options = {"map", "unit", "time-unit", "board", "spacing", "length-unit", "size", "camera",
                   "reverse"},
       .quantities = with_calibrations({"measured", "command", "odometry", "camera"}),
       .fill = import_ros,
       .what = "bags of ROS",
       .also = {"bag", "rosbag", "ros2", "mcap"},
       .looks = [](const FileLook& look) { return is_bag(look) && !look.holds("seam"); }},
      {.name = "euroc",
       .help = "an ASL folder or its ground truth, as poses; with a second trajectory as a walk",
       .options = {"size", "length-unit", "time-unit", "camera"},
       .fill = import_euroc,
       .what = "trajectories with named columns",
       .also = {"asl", "vicon"},
       .looks =
           [](const FileLook& look) { return has_quaternions(look) && look.extension == ".csv"; }},
      {.name = "tum",
       .help = "a trajectory 'time x y z qx qy qz qw' as poses; with a second one as a walk",
       .options = {"size", "length-unit", "time-unit"},
       .fill = import_tum,
       .what = "trajectories",
       .also = {"trajectory", "path", "groundtruth"},
       .looks =
           [](const FileLook& look) {
             return look.table && look.table->width() == 8 && look.extension != ".csv";
           }},
      {.name = "emva1288",
       .help = "a series by its descriptor text, with PNG or TIFF images of 8 to 16 bits",
       .options = {},
       .fill = import_emva1288,
       .what = "a series of EMVA 1288",
       .looks = [](const FileLook& look) { return look.ends({".txt"}) && look.holds("EMVA1288"); }},
      {.name = "flats",
       .help =
           "a folder of flat fields and darks: PNG, TIFF, FITS; exposures from CSV, FITS, EXIF, "
           "names",
       .options = {"map", "time-unit"},
       .quantities = {"file", "exposure", "illumination", "photons"},
       .fill = import_flats,
       .what = "flat fields and darks",
       .also = {"photometry", "darks", "fits"},
       .looks =
           [](const FileLook& look) {
             return look.ends({".fits", ".fit", ".fts"});
           }},
      {.name = "log",
       .help = "a replay log of SEAM: a robot's head joints or walk with its commands, or its "
               "frames",
       .options = {"camera", "part"},
       .fill = import_log,
       .what = "replay logs of ours",
       .also = {"replay", "seam"},
       .looks =
           [](const FileLook& look) { return look.extension == ".mcap" && look.holds("seam"); },
       .fuzzed = false},
  };
  return kinds;
}

}  // namespace seam::app
