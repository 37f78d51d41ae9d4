#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "detector/refine.h"

namespace seam::detector {
namespace {

using Points = std::vector<cv::Point2f>;

cv::Ptr<cv::FeatureDetector> blobs(const cv::Mat& picture, bool dark) {
  cv::SimpleBlobDetector::Params p;
  p.filterByColor = true;
  p.blobColor = dark ? 0 : 255;
  p.minArea = 12;
  p.maxArea = 0.05F * static_cast<float>(picture.total());
  p.minDistBetweenBlobs = 4;
  p.filterByConvexity = true;
  p.minConvexity = 0.85F;
  p.filterByInertia = true;
  p.minInertiaRatio = 0.15F;
  return cv::SimpleBlobDetector::create(p);
}

// Places of round spots; of many the largest, since the search for a grid among them takes time
// with a power of their number.
Points spots(const cv::Mat& picture, const Target& target, bool dark) {
  std::vector<cv::KeyPoint> seen;
  blobs(picture, dark)->detect(picture, seen);
  std::stable_sort(seen.begin(), seen.end(),
                   [](const cv::KeyPoint& a, const cv::KeyPoint& b) { return a.size > b.size; });
  const size_t wanted = static_cast<size_t>(target.columns) * static_cast<size_t>(target.rows);
  seen.resize(std::min(seen.size(), wanted + wanted / 2 + 10));
  Points places;
  for (const cv::KeyPoint& spot : seen) places.push_back(spot.pt);
  return places;
}

// Among the spots of one of both colours; `most` is how many there were of either.
bool find(const cv::Mat& picture, const Target& target, Points& found, size_t& most) {
  const cv::Size size(target.columns, target.rows);
  const int form = target.pattern == Pattern::circles ? cv::CALIB_CB_SYMMETRIC_GRID
                                                      : cv::CALIB_CB_ASYMMETRIC_GRID;
  for (const bool dark : {true, false}) {
    const Points places = spots(picture, target, dark);
    most = std::max(most, places.size());
    if (places.size() < static_cast<size_t>(size.area())) continue;
    for (const int way : {0, static_cast<int>(cv::CALIB_CB_CLUSTERING)}) {
      if (cv::findCirclesGrid(places, size, found, form | way, nullptr)) return true;
    }
  }
  return false;
}

// A circle's place on the target, its pitch the unit.
cv::Point2d place_of(const Target& target, int point) {
  const int row = point / target.columns, column = point % target.columns;
  if (target.pattern == Pattern::circles) return {double(column), double(row)};
  return {2.0 * column + row % 2, double(row)};
}

struct Blob {
  cv::Point2d centre;
  double area_px2 = 0;
};

// The centroid of what differs from the ground around it, which a plane describes, within a radius
// that reaches half way to the next circle.
Blob weighed(const cv::Mat& picture, cv::Point2d centre, double radius_px) {
  Blob blob{centre};
  for (int round = 0; round < 3; ++round) {
    const int left = std::max(0, static_cast<int>(blob.centre.x - radius_px - 1));
    const int right = std::min(picture.cols - 1, static_cast<int>(blob.centre.x + radius_px + 2));
    const int top = std::max(0, static_cast<int>(blob.centre.y - radius_px - 1));
    const int bottom = std::min(picture.rows - 1, static_cast<int>(blob.centre.y + radius_px + 2));
    // The ground: light = a + b dx + c dy over the outer ring.
    cv::Matx33d normal = cv::Matx33d::zeros();
    cv::Vec3d right_side(0, 0, 0);
    const auto each = [&](double from, double to, const auto& take) {
      for (int y = top; y <= bottom; ++y) {
        for (int x = left; x <= right; ++x) {
          const double dx = x - blob.centre.x, dy = y - blob.centre.y, r = std::hypot(dx, dy);
          if (r >= from && r < to) take(dx, dy, double(picture.at<uint8_t>(y, x)));
        }
      }
    };
    each(0.84 * radius_px, radius_px, [&](double dx, double dy, double light) {
      const cv::Vec3d row(1, dx, dy);
      normal += row * row.t();
      right_side += light * row;
    });
    if (std::abs(cv::determinant(normal)) < 1e-6) return blob;
    const cv::Vec3d ground = normal.inv() * right_side;
    double inside = 0, count = 0;
    each(0, std::max(1.5, 0.15 * radius_px), [&](double dx, double dy, double light) {
      inside += light - ground[0] - ground[1] * dx - ground[2] * dy, ++count;
    });
    if (count == 0 || std::abs(inside) < 1) return blob;
    inside /= count;
    double sum = 0, sum_x = 0, sum_y = 0;
    each(0, radius_px, [&](double dx, double dy, double light) {
      const double weight = (light - ground[0] - ground[1] * dx - ground[2] * dy) / inside;
      sum += weight, sum_x += weight * dx, sum_y += weight * dy;
    });
    if (sum < 4) return blob;
    blob.centre += cv::Point2d(sum_x / sum, sum_y / sum);
    blob.area_px2 = sum;
  }
  return blob;
}

// The image of a circle's centre is not the centre of its image: how far it lies from there, where
// the map from the target to the picture is h.
cv::Point2d from_image_to_true_centre(const cv::Matx33d& h, const cv::Point2d& place,
                                      double radius) {
  const cv::Matx33d back = h.inv();
  const cv::Matx33d circle(1, 0, -place.x, 0, 1, -place.y, -place.x, -place.y,
                           place.dot(place) - radius * radius);
  const cv::Matx33d conic = back.t() * circle * back;
  const double det = conic(0, 0) * conic(1, 1) - conic(0, 1) * conic(0, 1);
  const cv::Point2d centre((conic(0, 1) * conic(1, 2) - conic(1, 1) * conic(0, 2)) / det,
                           (conic(0, 1) * conic(0, 2) - conic(0, 0) * conic(1, 2)) / det);
  const cv::Vec3d image = h * cv::Vec3d(place.x, place.y, 1);
  return cv::Point2d(image[0] / image[2], image[1] / image[2]) - centre;
}

// The size of an area of the target in the picture, at a place.
double scale_at(const cv::Matx33d& h, const cv::Point2d& place) {
  const double w = h(2, 0) * place.x + h(2, 1) * place.y + h(2, 2);
  return std::abs(cv::determinant(h) / (w * w * w));
}

void straighten(const Target& target, const std::vector<Blob>& blobs, Found& result) {
  std::vector<cv::Point2d> places;
  for (size_t i = 0; i < blobs.size(); ++i) places.push_back(place_of(target, static_cast<int>(i)));
  std::vector<cv::Point2d> centres;
  for (const Blob& blob : blobs) centres.push_back(blob.centre);
  for (int round = 0; round < 3; ++round) {
    const cv::Mat map = cv::findHomography(places, centres);
    if (map.empty()) return;
    const cv::Matx33d h = map;
    std::vector<double> radii;
    for (size_t i = 0; i < blobs.size(); ++i)
      radii.push_back(std::sqrt(blobs[i].area_px2 / (CV_PI * scale_at(h, places[i]))));
    std::nth_element(radii.begin(), radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2),
                     radii.end());
    const double radius = radii[radii.size() / 2];
    for (size_t i = 0; i < blobs.size(); ++i)
      centres[i] = blobs[i].centre + from_image_to_true_centre(h, places[i], radius);
  }
  for (size_t i = 0; i < blobs.size(); ++i) result.corners[i].place = centres[i];
}

}  // namespace

Found find_circles(const cv::Mat& picture, const Target& target) {
  Points found;
  size_t most = 0;
  if (!find(picture, target, found, most)) {
    const size_t wanted = static_cast<size_t>(target.columns) * static_cast<size_t>(target.rows);
    return {.corners = {},
            .why = most < wanted / 4
                       ? "no target"
                       : fmt::format("part of the target or another one: {} spots in place of {}",
                                     most, wanted)};
  }
  std::vector<cv::Point2d> places(found.begin(), found.end());
  // Seen from its face.
  const cv::Point2d x = places[1] - places[0],
                    y = places[places.size() - static_cast<size_t>(target.columns)] - places[0];
  if (x.x * y.y - x.y * y.x < 0 && target.pattern == Pattern::circles) {
    for (int row = 0; row < target.rows; ++row)
      std::reverse(places.begin() + row * target.columns,
                   places.begin() + (row + 1) * target.columns);
  }
  Found result;
  std::vector<Blob> weighed_blobs;
  std::vector<Edge> edges;
  for (size_t i = 0; i < places.size(); ++i) {
    double nearest = 1e9;
    for (size_t k = 0; k < places.size(); ++k) {
      const cv::Point2d way = places[k] - places[i];
      if (k != i) nearest = std::min(nearest, std::hypot(way.x, way.y));
    }
    weighed_blobs.push_back(weighed(picture, places[i], 0.5 * nearest));
    const Blob& blob = weighed_blobs.back();
    result.corners.push_back({static_cast<int>(i), blob.centre});
    // Its sides, as straight as they are over a short way.
    const double radius = std::sqrt(blob.area_px2 / CV_PI);
    for (const cv::Point2d out : {cv::Point2d(1, 0), {0, 1}}) {
      const cv::Point2d along(-out.y, out.x), rim = blob.centre + radius * out;
      edges.push_back({rim - along, rim + along, 0.5 * std::min(radius, nearest - 2 * radius)});
    }
  }
  result.edge_px = width_of(picture, edges);
  straighten(target, weighed_blobs, result);
  return result;
}

}  // namespace seam::detector
