#include "app/import/import.h"

#include <fmt/ranges.h>

#include "app/import/kinds/kinds.h"
#include "app/import/recognise.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

const std::vector<std::string> kOfCalibrations = {"corners",      "target",     "camera_matrix",
                                                  "distortion",   "names",      "board_width",
                                                  "board_height", "square_size"};

std::vector<std::string> with_calibrations(std::vector<std::string> names) {
  names.insert(names.end(), kOfCalibrations.begin(), kOfCalibrations.end());
  return names;
}

}  // namespace

const std::vector<ImportKind>& import_kinds() {
  static const std::vector<ImportKind> kinds = {
      {.name = "images",
       .help = "pictures, or a bag of ROS, of a chessboard or circles, or with a target YAML of an "
               "AprilGrid or ChArUco "
               "board; times from names, a CSV or EXIF",
       .options = {"target", "board", "spacing", "length-unit", "time-unit", "map", "camera"},
       .quantities = {"file", "time"},
       .fill = import_images},
      {.name = "servo",
       .help = "logs of commanded and measured angles: CSV or JSON, a file a run, or commands and "
               "states in two files",
       .options = {"map", "unit", "time-unit", "reverse", "off-where"},
       .quantities = {"time", "command", "measured", "run", "joint", "kp", "voltage",
                      "torque_enable"},
       .fill = import_servo},
      {.name = "ranges",
       .help = "ranges and bearings to beacons, their places and a path: the Plaza sets' .mat, or "
               "three CSV",
       .options = {"map", "unit", "time-unit", "length-unit"},
       .quantities = {"time", "beacon", "range", "bearing", "x", "y", "z", "theta", "qw", "qx",
                      "qy", "qz", "path", "ranges", "beacons"},
       .own_units = true,
       .fill = import_ranges},
      {.name = "wheels",
       .help = "ticks or speeds of two wheels, or velocities of a body, and its poses: CSV, the "
               "poses also in a file of their own with its own clock",
       .options = {"map", "unit", "time-unit", "length-unit", "base", "radius", "metres-per-tick"},
       .quantities = {"time", "run", "left", "right", "vx", "vy", "omega", "x", "y", "z", "theta",
                      "qw", "qx", "qy", "qz", "pose_time"},
       .own_units = true,
       .fill = import_wheels},
      {.name = "opencv",
       .help = "corners and calibration in YAML or XML of cv::FileStorage, camera_info YAML, "
               "calibrations of camodocal, ORB-SLAM and basalt",
       .options = {"map", "board", "spacing", "length-unit", "size", "camera"},
       .quantities = kOfCalibrations,
       .fill = import_opencv},
      {.name = "kalibr",
       .help = "a camchain, a target YAML, corners as CSV",
       .options = {"map", "board", "spacing", "length-unit", "time-unit", "size", "camera"},
       .quantities = {"time", "frame", "camera", "tag", "point", "u", "v"},
       .fill = import_kalibr},
      {.name = "mrcal",
       .help = "corners as .vnl and a .cameramodel, or a .cameramodel with its inputs",
       .options = {"board", "spacing", "length-unit", "size", "camera"},
       .fill = import_mrcal},
      {.name = "bouguet",
       .help = "Calib_Results.mat of the toolbox for MATLAB (save it with -v7)",
       .options = {"length-unit"},
       .fill = import_bouguet},
      {.name = "ros",
       .help =
           "a bag of ROS 2 (MCAP) or ROS 1: states of controllers, joints or a walk with commands, "
           "pictures, CameraInfo, poses and TF; camera_info YAML",
       .options = {"map", "unit", "time-unit", "board", "spacing", "length-unit", "size", "camera",
                   "reverse"},
       .quantities = with_calibrations({"measured", "command", "odometry", "camera"}),
       .fill = import_ros},
      {.name = "euroc",
       .help = "an ASL folder or its ground truth, as poses; with a second trajectory as a walk",
       .options = {"size", "length-unit", "time-unit", "camera"},
       .fill = import_euroc},
      {.name = "tum",
       .help = "a trajectory 'time x y z qx qy qz qw' as poses; with a second one as a walk",
       .options = {"size", "length-unit", "time-unit"},
       .fill = import_tum},
      {.name = "emva1288",
       .help = "a series by its descriptor text, with PNG or TIFF images of 8 to 16 bits",
       .options = {},
       .fill = import_emva1288},
      {.name = "flats",
       .help =
           "a folder of flat fields and darks: PNG, TIFF, FITS; exposures from CSV, FITS, EXIF, "
           "names",
       .options = {"map", "time-unit"},
       .quantities = {"file", "exposure", "illumination", "photons"},
       .fill = import_flats},
      {.name = "log",
       .help = "a replay log of ours: a robot's head joints or walk with its commands, or its "
               "frames",
       .options = {"camera", "part"},
       .fill = import_log},
  };
  return kinds;
}

std::string import_set(const ImportKind& kind, const ImportRequest& request,
                       const std::string& title, const std::filesystem::path& out,
                       const measurement::Instruments& instruments) {
  ImportRequest asked = request;
  asked.quantities = kind.quantities;
  check_names(asked, kind.name);
  if (!kind.own_units && !request.own_units.empty())
    throw UsageError(fmt::format(
        "{}={}: import {} takes one unit for all, expected --unit, --time-unit or --length-unit "
        "with a unit alone",
        request.own_units.begin()->first, request.own_units.begin()->second, kind.name));
  std::vector<std::string> names;
  // A folder may be given with a slash at its end.
  for (const auto& source : request.sources)
    names.push_back((source.has_filename() ? source : source.parent_path()).filename().string());
  std::string from = fmt::format(
      "{}", fmt::join(names.begin(), names.begin() + std::min<size_t>(names.size(), 4), ", "));
  if (names.size() > 4) from += fmt::format(" and {} more", names.size() - 4);
  SetDraft draft(out);
  draft.instruments = instruments;
  // Of a file that is another import's the reader says what it lacks, and we where it belongs.
  const auto with_other = [&](const std::exception& error) {
    const std::string other = other_import_for(request.sources, kind.name);
    return other.empty() ? error.what() : fmt::format("{}\n{}", error.what(), other);
  };
  try {
    kind.fill(asked, draft);
  } catch (const InputError& error) {
    throw InputError(with_other(error));
  } catch (const UsageError& error) {
    throw UsageError(with_other(error));
  }
  draft.title = title.empty() ? fmt::format("Imported from {} ({})", from, kind.name) : title;
  draft.finish(from);
  return draft.text();
}

}  // namespace seam::app
