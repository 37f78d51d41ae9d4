// Places in pictures to small parts of a pixel.
#pragma once

#include <optional>

#include "detector/found.h"

namespace seam::detector {

double distance(const cv::Point2d& a, const cv::Point2d& b);

// Where four fields meet: the point from which light changes along rays alone, in a window of this
// half width. Nothing where there is none near the start, or the window leaves the picture.
std::optional<cv::Point2d> refined_saddle(const cv::Mat& picture, const cv::Point2d& start,
                                          double half_px);

// Bilinear; the nearest border outside.
double light_at(const cv::Mat& picture, const cv::Point2d& place);

// The median width of the edges, of those that lie more in rows or more in columns, whichever is
// greater; 0 without edges.
double width_of(const cv::Mat& picture, const std::vector<Edge>& edges);

}  // namespace seam::detector
