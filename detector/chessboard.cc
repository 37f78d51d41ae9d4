#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "detector/refine.h"

namespace seam::detector {
namespace {

using Points = std::vector<cv::Point2f>;

// Numbered so that the board is seen from its face, and, where turning it round changes its
// colours, that the field right below the first corner is dark.
void turn(const cv::Mat& picture, int columns, int rows, std::vector<cv::Point2d>& places) {
  const auto at = [&](int row, int column) -> cv::Point2d& {
    return places[static_cast<size_t>(row * columns + column)];
  };
  const cv::Point2d x = at(0, columns - 1) - at(0, 0), y = at(rows - 1, 0) - at(0, 0);
  if (x.x * y.y - x.y * y.x < 0) {
    for (int row = 0; row < rows; ++row)
      std::reverse(places.begin() + row * columns, places.begin() + (row + 1) * columns);
  }
  if ((columns + rows) % 2 == 0) return;
  const auto field = [&](int row, int column) {
    return light_at(picture, 0.25 * (at(row, column) + at(row + 1, column) + at(row, column + 1) +
                                     at(row + 1, column + 1)));
  };
  if (field(0, 0) > field(0, 1)) std::reverse(places.begin(), places.end());
}

// The board in a picture that is smaller by so many powers of two: it is there, and was blurred.
bool seen_smaller(const cv::Mat& picture, cv::Size size) {
  cv::Mat smaller;
  for (const double scale : {0.5, 0.25}) {
    cv::resize(picture, smaller, {}, scale, scale, cv::INTER_AREA);
    Points found;
    if (smaller.cols > 60 &&
        cv::findChessboardCornersSB(smaller, size, found, cv::CALIB_CB_NORMALIZE_IMAGE))
      return true;
  }
  return false;
}

// What there is in place of the board.
std::string what_else(const cv::Mat& picture, cv::Size size) {
  cv::Mat meta;
  Points found;
  if (seen_smaller(picture, size)) return "blurred: its fields have no edges at full size";
  if (!cv::findChessboardCornersSB(picture, {3, 3}, found,
                                   cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_LARGER, meta))
    return "no target";
  const int columns = std::max(meta.cols, meta.rows), rows = std::min(meta.cols, meta.rows);
  const int wide = std::max(size.width, size.height), high = std::min(size.width, size.height);
  if (columns > wide || rows > high)
    return fmt::format("another target: a board of {} x {} corners", columns, rows);
  if (columns == wide && rows == high)
    return "part of the target or a smaller one: outer fields leave the picture";
  return fmt::format("part of the target or a smaller one: {} x {} corners", columns, rows);
}

// The search takes 44 bytes and half a microsecond a pixel, so that large pictures are searched in
// a smaller copy: by the scale that leaves so many pixels or fewer. Corners are refined in the
// whole.
int scale_of(const cv::Mat& picture) {
  constexpr size_t kMostPixels = size_t{8} << 20;
  constexpr int kSmaller = 4;  // 44 bytes a pixel become 3.
  return picture.total() <= kMostPixels ? 1 : kSmaller;
}

// The board's corners in the picture's pixels, found in a copy smaller by `scale`; empty: none.
std::vector<cv::Point2d> search(const cv::Mat& picture, cv::Size size, int scale,
                                std::string& why) {
  cv::Mat smaller = picture;
  if (scale > 1) cv::resize(picture, smaller, {}, 1.0 / scale, 1.0 / scale, cv::INTER_AREA);
  Points found;
  if (!cv::findChessboardCornersSB(smaller, size, found, cv::CALIB_CB_NORMALIZE_IMAGE) &&
      !cv::findChessboardCornersSB(smaller, size, found,
                                   cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_EXHAUSTIVE)) {
    why = what_else(smaller, size);
    return {};
  }
  std::vector<cv::Point2d> places;
  // (0, 0) is the centre of the first pixel in both.
  const double x = static_cast<double>(picture.cols) / smaller.cols,
               y = static_cast<double>(picture.rows) / smaller.rows;
  for (const cv::Point2f& place : found)
    places.emplace_back((place.x + 0.5) * x - 0.5, (place.y + 0.5) * y - 0.5);
  return places;
}

}  // namespace

Found find_chessboard(const cv::Mat& picture, const Target& target) {
  const cv::Size size(target.columns, target.rows);
  std::string why;
  std::vector<cv::Point2d> places = search(picture, size, scale_of(picture), why);
  if (places.empty()) return {.corners = {}, .why = why};
  turn(picture, target.columns, target.rows, places);
  std::vector<Edge> edges;
  Found result;
  const auto at = [&](int row, int column) {
    return places[static_cast<size_t>(row * target.columns + column)];
  };
  for (int row = 0; row < target.rows; ++row) {
    for (int column = 0; column < target.columns; ++column) {
      double nearest = 1e9;
      const cv::Point2d here = at(row, column);
      for (const auto& [down, right] : {std::pair{0, 1}, {1, 0}, {0, -1}, {-1, 0}}) {
        if (row + down < 0 || row + down >= target.rows || column + right < 0 ||
            column + right >= target.columns)
          continue;
        const cv::Point2d there = at(row + down, column + right);
        nearest = std::min(nearest, distance(here, there));
        if (down + right > 0) edges.push_back({here, there, 0.35 * distance(here, there)});
      }
      if (const auto corner = refined_saddle(picture, here, 0.35 * nearest))
        result.corners.push_back({row * target.columns + column, *corner});
    }
  }
  result.edge_px = width_of(picture, edges);
  return result;
}

}  // namespace seam::detector
