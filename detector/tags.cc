#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/aruco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "detector/refine.h"

namespace seam::detector {
namespace {

constexpr size_t kFewestCorners = 8;
constexpr double kSoft_px = 1.5;  // How far the light of what is beside a window reaches into it.

// Fewer say nothing of a pose.
Found enough(Found found, const std::string& what) {
  if (found.corners.size() >= kFewestCorners) return found;
  return {.corners = {},
          .why = found.corners.empty() ? "no target"
                                       : fmt::format("part of the target: {} corners of {}",
                                                     found.corners.size(), what)};
}

// Grids have small dark squares where the corners of tags meet, so that four fields meet there; a
// tag alone has a corner only, whose sides say where it is.
bool four_fields_meet(const cv::Mat& picture, const cv::Point2d& corner, const cv::Point2d& middle,
                      double step) {
  const cv::Point2d out = (step / distance(corner, middle)) * (corner - middle);
  const cv::Point2d side(-out.y, out.x);
  const double dark = std::max(light_at(picture, corner + out), light_at(picture, corner - out));
  const double light = std::min(light_at(picture, corner + side), light_at(picture, corner - side));
  return light > dark + 10;
}

struct TagReader {
  apriltag_family_t* family = tag36h11_create();
  apriltag_detector_t* detector = apriltag_detector_create();
  TagReader() { apriltag_detector_add_family_bits(detector, family, 1); }
  TagReader(const TagReader&) = delete;
  TagReader& operator=(const TagReader&) = delete;
  ~TagReader() {
    apriltag_detector_destroy(detector);
    tag36h11_destroy(family);
  }
};

// A tag's corners against the clock from the lower left, as Kalibr numbers them.
struct Tag {
  std::array<cv::Point2d, 4> corners;
  float margin = 0;  // Of light, by which its bits were read.
};

// The tags by number; those with numbers from `most` on are counted as strangers. `grown_px` is by
// how much light fields were grown in the picture.
void read_tags(const cv::Mat& picture, double grown_px, int most, std::map<int, Tag>& found,
               int& strangers) {
  static const TagReader reader;
  // Half the size is enough to find tags in large pictures; their corners are sought at full size.
  reader.detector->quad_decimate = picture.total() > 1'500'000 ? 2.0F : 1.0F;
  image_u8_t image = {.width = picture.cols,
                      .height = picture.rows,
                      .stride = static_cast<int32_t>(picture.step),
                      .buf = picture.data};
  zarray_t* tags = apriltag_detector_detect(reader.detector, &image);
  strangers = 0;
  for (int i = 0; i < zarray_size(tags); ++i) {
    apriltag_detection_t* read = nullptr;
    zarray_get(tags, i, &read);
    if (read->decision_margin < 20) continue;
    if (read->id >= most) {
      ++strangers;
      continue;
    }
    Tag tag{.corners = {}, .margin = read->decision_margin};
    // Its pixels' centres are at halves.
    for (size_t k = 0; k < 4; ++k) tag.corners[k] = {read->p[k][0] - 0.5, read->p[k][1] - 0.5};
    const auto corners = tag.corners;
    for (size_t k = 0; k < 4; ++k) {
      for (const size_t other : {(k + 1) % 4, (k + 3) % 4})
        tag.corners[k] +=
            (grown_px / distance(corners[k], corners[other])) * (corners[k] - corners[other]);
    }
    const auto [known, is_new] = found.emplace(read->id, tag);
    if (!is_new && grown_px == 0 && tag.margin > known->second.margin) known->second = tag;
  }
  apriltag_detections_destroy(tags);
}

void add_tag(const cv::Mat& picture, int id, const Tag& tag, const Target& target, Found& found,
             std::vector<Edge>& edges) {
  const auto& corners = tag.corners;
  const cv::Point2d middle = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  double side = 1e9;
  for (size_t i = 0; i < 4; ++i) side = std::min(side, distance(corners[i], corners[(i + 1) % 4]));
  const int row = id / target.columns, column = id % target.columns;
  for (size_t i = 0; i < 4; ++i) {
    const int point =
        (2 * row + (i >= 2 ? 1 : 0)) * 2 * target.columns + 2 * column + (i == 1 || i == 2 ? 1 : 0);
    // Its black border is an eighth of the tag.
    const bool meet = four_fields_meet(picture, corners[i], middle, 0.1 * side);
    const cv::Rect2d inside(2, 2, picture.cols - 5, picture.rows - 5);
    const auto corner = meet ? refined_saddle(picture, corners[i], 0.125 * side - kSoft_px)
                             : std::optional(corners[i]);
    if (corner && inside.contains(*corner)) found.corners.push_back({point, *corner});
    edges.push_back({corners[i], corners[(i + 1) % 4], 0.11 * side});
  }
}

}  // namespace

Found find_aprilgrid(const cv::Mat& picture, const Target& target) {
  const int count = target.columns * target.rows;
  std::map<int, Tag> tags;
  int strangers = 0;
  read_tags(picture, 0, count, tags, strangers);
  if (!tags.empty() && static_cast<int>(tags.size()) < count) {
    // Where tags touch the squares between them they are one dark thing: light is grown to part
    // them.
    cv::Mat grown;
    cv::dilate(picture, grown, cv::Mat());
    int again = 0;
    read_tags(grown, 1, count, tags, again);
  }
  Found found;
  std::vector<Edge> edges;
  for (const auto& [id, tag] : tags) add_tag(picture, id, tag, target, found, edges);
  std::sort(found.corners.begin(), found.corners.end(),
            [](const Corner& a, const Corner& b) { return a.point < b.point; });
  found.edge_px = width_of(picture, edges);
  if (strangers > static_cast<int>(tags.size()))
    return {
        .corners = {},
        .why = fmt::format("another target: {} tags with numbers from {} on", strangers, count)};
  return enough(std::move(found), fmt::format("{} x {} tags", target.columns, target.rows));
}

namespace {

// Corners of markers by number, and where the board has them: fields are numbered from the upper
// left, and markers stand in the light ones.
struct Markers {
  std::map<int, std::vector<cv::Point2f>> seen;
  std::map<int, cv::Point> fields;  // Column and row.
  double ratio = 0;

  // A marker's corners on the board, a field's side the unit, in OpenCV's order.
  void add(int id, std::vector<cv::Point2d>& board, std::vector<cv::Point2d>& image) const {
    const cv::Point2d corner = cv::Point2d(fields.at(id)) + cv::Point2d(1, 1) * (0.5 - 0.5 * ratio);
    const cv::Point2d steps[] = {{0, 0}, {ratio, 0}, {ratio, ratio}, {0, ratio}};
    for (size_t i = 0; i < 4; ++i) {
      board.push_back(corner + steps[i]);
      image.emplace_back(seen.at(id)[i]);
    }
  }
};

// The board in one of its two forms: its upper left field dark, or light (of even rows before
// OpenCV 4.7).
std::map<int, cv::Point> marker_fields(const Target& target, bool first_is_dark) {
  std::map<int, cv::Point> fields;
  for (int row = 0; row < target.rows; ++row) {
    for (int column = 0; column < target.columns; ++column) {
      if (((row + column) % 2 == 0) != first_is_dark)
        fields.emplace(static_cast<int>(fields.size()), cv::Point(column, row));
    }
  }
  return fields;
}

// How far the markers lie from where one plane would have them, in fields; large where they are
// those of another board.
double disorder(Markers& markers) {
  std::erase_if(markers.seen,
                [&](const auto& item) { return !markers.fields.contains(item.first); });
  std::vector<cv::Point2d> board, image, mapped;
  for (const auto& [id, corners] : markers.seen) markers.add(id, board, image);
  const cv::Mat map = board.empty() ? cv::Mat() : cv::findHomography(image, board);
  if (map.empty()) return 1e9;
  cv::perspectiveTransform(image, mapped, map);
  double most = 0;
  for (size_t i = 0; i < mapped.size(); ++i) most = std::max(most, distance(mapped[i], board[i]));
  return most;
}

// Where the corners of the fields should be: estimated from the markers in the fields around each.
std::map<int, cv::Point2d> between(const Markers& markers, const Target& target) {
  std::map<std::pair<int, int>, int> at;
  for (const auto& [id, field] : markers.fields) at[{field.x, field.y}] = id;
  std::map<int, cv::Point2d> corners;
  for (int row = 1; row < target.rows; ++row) {
    for (int column = 1; column < target.columns; ++column) {
      std::vector<cv::Point2d> board, image, mapped;
      for (const auto& [x, y] : {std::pair{-1, -1}, {0, -1}, {-1, 0}, {0, 0}}) {
        const auto found = at.find({column + x, row + y});
        if (found != at.end() && markers.seen.contains(found->second))
          markers.add(found->second, board, image);
      }
      const cv::Mat map = board.size() < 8 ? cv::Mat() : cv::findHomography(board, image);
      if (map.empty()) continue;
      const std::vector<cv::Point2d> here = {cv::Point2d(column, row)};
      cv::perspectiveTransform(here, mapped, map);
      corners[(row - 1) * (target.columns - 1) + column - 1] = mapped[0];
    }
  }
  return corners;
}

}  // namespace

Found find_charuco(const cv::Mat& picture, const Target& target) {
  std::vector<std::vector<cv::Point2f>> places;
  std::vector<int> ids;
  cv::aruco::detectMarkers(picture, cv::aruco::getPredefinedDictionary(target.dictionary), places,
                           ids);
  Markers best;
  double least = 1e9;
  for (const bool first_is_dark : {true, false}) {
    Markers markers{
        .seen = {}, .fields = marker_fields(target, first_is_dark), .ratio = target.marker_ratio};
    for (size_t i = 0; i < ids.size(); ++i) markers.seen[ids[i]] = places[i];
    if (const double found = disorder(markers); found < least) least = found, best = markers;
  }
  constexpr double kMost = 0.7;  // Fields; a lens bends them less.
  if (!ids.empty() && least > kMost)
    return {.corners = {}, .why = "another target: its markers stand in another order"};
  const std::map<int, cv::Point2d> seen = between(best, target);
  Found found;
  std::vector<Edge> edges;
  const int across = target.columns - 1;
  for (const auto& [point, place] : seen) {
    double nearest = 1e9;
    for (const int step : {1, -1, across, -across}) {
      const auto other = seen.find(point + step);
      if (other == seen.end() || (std::abs(step) == 1 && other->first / across != point / across))
        continue;
      const double length = distance(place, other->second);
      nearest = std::min(nearest, length);
      // As far as the markers' white margins.
      const double margin = 0.45 * (1 - target.marker_ratio);
      if (step > 0) edges.push_back({place, other->second, margin * length});
    }
    if (nearest > 1e8) continue;  // Alone, without a size to search within.
    const double free_px = std::min(0.35, 0.5 * (1 - target.marker_ratio)) * nearest;
    if (const auto corner = refined_saddle(picture, place, free_px - kSoft_px))
      found.corners.push_back({point, *corner});
  }
  found.edge_px = width_of(picture, edges);
  return enough(std::move(found), fmt::format("{} x {} squares", target.columns, target.rows));
}

}  // namespace seam::detector
