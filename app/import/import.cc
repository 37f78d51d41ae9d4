#include "app/import/import.h"

#include <fmt/ranges.h>

#include "app/import/kinds/kinds.h"
#include "sim_core/base/error.h"

namespace seam::app {

const std::vector<ImportKind>& import_kinds() {
  static const std::vector<ImportKind> kinds = {
      {.name = "images",
       .help = "pictures, or a bag of ROS, of a chessboard or circles, or with a target YAML of an "
               "AprilGrid or ChArUco "
               "board; times from names, a CSV or EXIF",
       .options = {"target", "board", "spacing", "length-unit", "time-unit", "map", "camera"},
       .fill = import_images},
      {.name = "servo",
       .help = "logs of commanded and measured angles: CSV or JSON, a file a run, or commands and "
               "states in two files",
       .options = {"map", "unit", "time-unit", "reverse", "off-where"},
       .fill = import_servo},
      {.name = "ranges",
       .help = "ranges to beacons, their places and a path: the Plaza sets' .mat, or three CSV",
       .options = {"map", "unit", "time-unit", "length-unit"},
       .fill = import_ranges},
      {.name = "opencv",
       .help = "corners and calibration in YAML or XML of cv::FileStorage, camera_info YAML",
       .options = {"map", "board", "spacing", "length-unit", "size"},
       .fill = import_opencv},
      {.name = "kalibr",
       .help = "a camchain, a target YAML, corners as CSV",
       .options = {"map", "board", "spacing", "length-unit", "time-unit", "size", "camera"},
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
       .fill = import_flats},
      {.name = "log",
       .help = "a replay log of ours: a robot's head joints or walk with what it was told, or its "
               "frames",
       .options = {"camera", "part"},
       .fill = import_log},
  };
  return kinds;
}

std::string import_set(const ImportKind& kind, const ImportRequest& request,
                       const std::string& title, const std::filesystem::path& out,
                       const measurement::Instruments& instruments) {
  std::vector<std::string> names;
  // A folder may be given with a slash at its end.
  for (const auto& source : request.sources)
    names.push_back((source.has_filename() ? source : source.parent_path()).filename().string());
  std::string from = fmt::format(
      "{}", fmt::join(names.begin(), names.begin() + std::min<size_t>(names.size(), 4), ", "));
  if (names.size() > 4) from += fmt::format(" and {} more", names.size() - 4);
  SetDraft draft(out);
  draft.instruments = instruments;
  kind.fill(request, draft);
  draft.title = title.empty() ? fmt::format("Imported from {} ({})", from, kind.name) : title;
  draft.finish(from);
  return draft.text();
}

}  // namespace seam::app
