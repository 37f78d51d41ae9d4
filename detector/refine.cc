#include "detector/refine.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace seam::detector {
namespace {

// From 10 to 90 % of the step across an edge; 0 where there is none.
double width_of_one(const cv::Mat& picture, const Edge& edge) {
  constexpr int kSteps = 96;
  const cv::Point2d along = edge.b - edge.a;
  const double length = std::hypot(along.x, along.y);
  if (length < 2 || edge.half_length_px < 1) return 0;
  const cv::Point2d across(-along.y / length, along.x / length);
  std::vector<double> light(kSteps + 1, 0);
  // Nine lines, since a single one has the noise of single pixels.
  for (int line = -4; line <= 4; ++line) {
    const cv::Point2d middle = edge.a + (0.5 + 0.02 * line) * along;
    for (int i = 0; i <= kSteps; ++i)
      light[static_cast<size_t>(i)] +=
          light_at(picture, middle + (2.0 * i / kSteps - 1) * edge.half_length_px * across) / 9;
  }
  if (light.front() > light.back()) std::reverse(light.begin(), light.end());
  const double step = light.back() - light.front();
  if (step < 12) return 0;
  const auto crossing = [&](double level) {
    for (size_t i = 1; i < light.size(); ++i) {
      if (light[i] >= level && light[i] > light[i - 1])
        return static_cast<double>(i) - (light[i] - level) / (light[i] - light[i - 1]);
    }
    return static_cast<double>(kSteps);
  };
  const double rise = crossing(light.front() + 0.9 * step) - crossing(light.front() + 0.1 * step);
  return std::max(0.0, rise) * 2 * edge.half_length_px / kSteps;
}

double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

double distance(const cv::Point2d& a, const cv::Point2d& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

std::optional<cv::Point2d> refined_saddle(const cv::Mat& picture, const cv::Point2d& start,
                                          double half_px) {
  const int half = std::clamp(static_cast<int>(half_px), 2, 12);
  if (start.x < half + 2 || start.y < half + 2 || start.x > picture.cols - half - 3 ||
      start.y > picture.rows - half - 3)
    return std::nullopt;
  // Edges that no lens has softened fall between pixels: a little blur puts them in their place.
  const int reach = 2 * half + 6;
  const cv::Rect around =
      cv::Rect(static_cast<int>(start.x) - reach, static_cast<int>(start.y) - reach, 2 * reach + 1,
               2 * reach + 1) &
      cv::Rect(0, 0, picture.cols, picture.rows);
  cv::Mat soft;
  picture(around).convertTo(soft, CV_32F);
  cv::GaussianBlur(soft, soft, {}, std::min(1.3, 0.4 * half));
  const cv::Point2d corner(around.tl());
  std::vector<cv::Point2f> place = {cv::Point2f(start - corner)};
  cv::cornerSubPix(soft, place, {half, half}, {-1, -1},
                   {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 60, 1e-4});
  const cv::Point2d found = cv::Point2d(place[0]) + corner;
  if (distance(found, start) > half) return std::nullopt;
  return found;
}

double light_at(const cv::Mat& picture, const cv::Point2d& place) {
  const double x = std::clamp(place.x, 0.0, picture.cols - 1.0001);
  const double y = std::clamp(place.y, 0.0, picture.rows - 1.0001);
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const double a = x - column, b = y - row;
  const uint8_t* upper = picture.ptr<uint8_t>(row) + column;
  const uint8_t* lower = picture.ptr<uint8_t>(row + 1) + column;
  return (1 - b) * ((1 - a) * upper[0] + a * upper[1]) + b * ((1 - a) * lower[0] + a * lower[1]);
}

double width_of(const cv::Mat& picture, const std::vector<Edge>& edges) {
  std::vector<double> level, upright;
  for (const Edge& edge : edges) {
    const double width = width_of_one(picture, edge);
    if (width <= 0) continue;
    const cv::Point2d along = edge.b - edge.a;
    (std::abs(along.x) > std::abs(along.y) ? level : upright).push_back(width);
  }
  return std::max(median_of(level), median_of(upright));
}

}  // namespace seam::detector
