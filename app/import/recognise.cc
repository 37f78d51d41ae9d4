#include "app/import/recognise.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <optional>

#include "app/import/files/text_table.h"
#include "app/import/servo/servo_columns.h"
#include "app/import/tracks/track.h"
#include "app/import/tracks/wheel_columns.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

struct FileLook {
  std::string name, extension;
  std::string start;               // The first bytes.
  std::optional<TextTable> table;  // Of the first rows, where it is one.

  bool has_column(const Names& names) const { return table && table->find(names) >= 0; }
  bool holds(const char* text) const { return start.find(text) != std::string::npos; }
  bool ends(const Names& ends) const {
    return std::find(ends.begin(), ends.end(), extension) != ends.end();
  }
};

FileLook look_at(const fs::path& path) {
  constexpr size_t kStart = 4096;
  FileLook look{.name = path.filename().string(), .extension = path.extension().string()};
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return look;
  std::ifstream file(path, std::ios::binary);
  look.start.resize(kStart);
  file.read(look.start.data(), static_cast<std::streamsize>(kStart));
  look.start.resize(static_cast<size_t>(file.gcount()));
  // A row that is cut off is none.
  const size_t whole = look.start.size() < kStart ? look.start.size() : look.start.rfind('\n');
  try {
    if (whole != std::string::npos)
      look.table = TextTable::from_text(look.start.substr(0, whole), look.name);
  } catch (const InputError&) {
    // No table.
  }
  return look;
}

bool is_bag(const FileLook& look) {
  return look.ends({".bag", ".mcap"});
}
bool is_yaml(const FileLook& look) {
  return look.ends({".yaml", ".yml", ".xml"});
}
bool has_corners(const FileLook& look) {
  return look.has_column({"u", "u_px"}) && look.has_column({"v", "v_px"});
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

// What an import reads, in words, what people call it, and how its files look.
struct Sort {
  const char* kind;
  const char* what;
  Names also;
  bool (*reads)(const FileLook& look);
};

const std::vector<Sort>& sorts() {
  static const std::vector<Sort> all = {
      {"kalibr",
       "corners as CSV",
       {"corners", "camchain", "points", "april", "aprilgrid"},
       [](const FileLook& look) {
         return has_corners(look) ||
                (is_yaml(look) && (look.holds("camera_model:") || look.holds("target_type:")));
       }},
      {"ranges",
       "ranges and bearings to beacons",
       {"bearings", "beacons", "landmarks", "anchors", "uwb", "distances"},
       has_bearings_or_ranges},
      {"wheels",
       "ticks and poses",
       {"odometry", "odom", "ticks", "encoders", "encoder", "wheel", "drive", "velocities",
        "robot"},
       has_wheels},
      {"servo",
       "logs of a servo",
       {"joints", "joint", "motor", "motors", "actuator", "arm"},
       [](const FileLook& look) {
         return look.ends({".jsonl"}) || (look.has_column(servo_names().commands) &&
                                          look.has_column(servo_names().measured));
       }},
      {"euroc",
       "trajectories with named columns",
       {"asl", "vicon"},
       [](const FileLook& look) { return has_quaternions(look) && look.extension == ".csv"; }},
      {"tum",
       "trajectories",
       {"trajectory", "path", "groundtruth"},
       [](const FileLook& look) {
         return look.table && look.table->width() == 8 && look.extension != ".csv";
       }},
      {"opencv",
       "calibrations of OpenCV",
       {"calibration", "camera", "camera_info", "cv"},
       [](const FileLook& look) {
         return is_yaml(look) && (look.holds("camera_matrix") || look.holds("image_points") ||
                                  look.holds("cameraMatrix"));
       }},
      {"mrcal",
       "corners and models of mrcal",
       {"vnl", "cameramodel"},
       [](const FileLook& look) {
         return look.ends({".vnl", ".cameramodel"});
       }},
      {"bouguet",
       "results of the toolbox for MATLAB",
       {"matlab"},
       [](const FileLook& look) { return look.name.starts_with("Calib_Results"); }},
      {"log",
       "replay logs of ours",
       {"replay", "seam"},
       [](const FileLook& look) { return look.extension == ".mcap" && look.holds("seam"); }},
      {"ros",
       "bags of ROS",
       {"bag", "rosbag", "ros2", "mcap"},
       [](const FileLook& look) { return is_bag(look) && !look.holds("seam"); }},
      {"flats",
       "flat fields and darks",
       {"photometry", "darks", "fits"},
       [](const FileLook& look) {
         return look.ends({".fits", ".fit", ".fts"});
       }},
      {"images",
       "pictures of a target",
       {"pictures", "photos", "chessboard", "video", "image", "board"},
       [](const FileLook& look) {
         return look.ends({".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".webp"});
       }},
  };
  return all;
}

std::string sentence(const Sort& sort) {
  return fmt::format("{}: `seam import {}`", sort.what, sort.kind);
}

}  // namespace

std::string kind_meant_by(const std::string& word) {
  for (const Sort& sort : sorts()) {
    if (std::find(sort.also.begin(), sort.also.end(), word) != sort.also.end())
      return "For " + sentence(sort);
  }
  return "";
}

std::string other_import_for(const std::vector<fs::path>& sources, const std::string& kind) {
  for (const fs::path& source : sources) {
    const FileLook look = look_at(source);
    // These read where a robot was beside what it measured.
    const bool reads_poses = kind == "wheels" || kind == "ranges";
    const Sort* other = nullptr;
    bool own = false;
    for (const Sort& sort : sorts()) {
      if (!sort.reads(look)) continue;
      own = own || sort.kind == kind ||
            (reads_poses && (sort.kind == std::string("tum") || sort.kind == std::string("euroc")));
      if (other == nullptr) other = &sort;
    }
    if (!own && other != nullptr)
      return fmt::format("{} looks like {}", source.string(), sentence(*other));
  }
  return "";
}

void refuse_foreign_file(const fs::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".yaml" || extension == ".yml" || extension == ".mcap") return;
  const std::string other = other_import_for({path}, "");
  if (!other.empty())
    throw InputError(
        fmt::format("{}: found a file of another program, expected a measurement set "
                    "or another file of ours. {}",
                    path.string(), other));
}

}  // namespace seam::app
