#include "app/import/draft/target.h"

#include "app/import/draft/points_draft.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

std::vector<Vec3> circle_points(int columns, int rows, double spacing_m, bool asymmetric) {
  std::vector<Vec3> points;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c)
      points.emplace_back((asymmetric ? 2 * c + r % 2 : c) * spacing_m, r * spacing_m, 0.0);
  }
  return points;
}

std::vector<Vec3> tag_points(int columns, int rows, double tag_m, double spacing) {
  const double step = tag_m * (1 + spacing);
  std::vector<Vec3> points;
  for (int r = 0; r < 2 * rows; ++r) {
    for (int c = 0; c < 2 * columns; ++c)
      points.emplace_back((c / 2) * step + (c % 2) * tag_m, (r / 2) * step + (r % 2) * tag_m, 0.0);
  }
  return points;
}

// In the order of OpenCV's numbers.
const std::vector<std::string>& dictionaries() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const char* bits : {"4X4", "5X5", "6X6", "7X7"}) {
      for (const int count : {50, 100, 250, 1000})
        all.push_back(fmt::format("DICT_{}_{}", bits, count));
    }
    for (const char* name :
         {"ARUCO_ORIGINAL", "APRILTAG_16h5", "APRILTAG_25h9", "APRILTAG_36h10", "APRILTAG_36h11"})
      all.push_back(std::string("DICT_") + name);
    return all;
  }();
  return names;
}

}  // namespace

TargetSpec read_target(const ConfigNode& root, const ImportRequest& request) {
  const size_t which =
      root.at("target_type").choice({"aprilgrid", "checkerboard", "circlegrid", "charuco"});
  const double metres = request.length_unit.empty() ? 1 : metres_in(request.length_unit);
  const auto count = [&](const char* key) {
    return static_cast<int>(root.at(key).integer(1, 1000));
  };
  const auto length = [&](const char* key) {
    const double value = root.at(key).number() * metres;
    check_spacing(value, root.at(key).where(), request);
    return value;
  };
  TargetSpec target;
  if (which == 0) {
    target.pattern = "aprilgrid";
    target.columns = count("tagCols"), target.rows = count("tagRows");
    target.points = tag_points(target.columns, target.rows, length("tagSize"),
                               root.at("tagSpacing").number({0, 10}));
    return target;
  }
  if (which == 3) {
    target.pattern = "charuco";
    target.columns = count("squareCols"), target.rows = count("squareRows");
    const double square = length("squareSize"), marker = length("markerSize");
    if (marker >= square)
      root.at("markerSize").fail(fmt::format("found {}, expected less than the squares'", marker));
    target.marker_ratio = marker / square;
    target.dictionary = static_cast<int>(root.at("dictionary").choice(dictionaries()));
    target.points = board_points(target.columns - 1, target.rows - 1, square, square);
    return target;
  }
  target.columns = count("targetCols"), target.rows = count("targetRows");
  if (which == 1) {
    target.pattern = "chessboard";
    target.points = board_points(target.columns, target.rows, length("colSpacingMeters"),
                                 length("rowSpacingMeters"));
    return target;
  }
  const bool asymmetric = root.boolean_or("asymmetricGrid", false);
  target.pattern = asymmetric ? "asymmetric_circles" : "circles";
  target.points = circle_points(target.columns, target.rows, length("spacingMeters"), asymmetric);
  return target;
}

TargetSpec stated_target(const ImportRequest& request) {
  TargetSpec target{.pattern = request.target.empty() ? "chessboard" : request.target,
                    .columns = request.board_columns,
                    .rows = request.board_rows,
                    .points = board_of(request, "pictures without a target YAML")};
  if (target.pattern != "chessboard")
    target.points = circle_points(target.columns, target.rows, request.spacing_m,
                                  target.pattern == "asymmetric_circles");
  return target;
}

}  // namespace seam::app
