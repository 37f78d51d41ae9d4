// What is looked for in a picture, and what was found.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace seam::detector {

enum class Pattern { chessboard, circles, asymmetric_circles, aprilgrid, charuco };

struct Target {
  Pattern pattern = Pattern::chessboard;
  // Inner corners of a chessboard, circles, tags, or squares of a ChArUco board.
  int columns = 0, rows = 0;
  // Of ChArUco: a marker's side over a square's, and the dictionary's number in OpenCV.
  double marker_ratio = 0;
  int dictionary = 0;
};

struct Corner {
  int point = 0;
  // In pixels, (0, 0) the centre of the top left one.
  cv::Point2d place;
};

// A straight border between dark and light, to measure its width across: at the middle between two
// corners, as far to each side as nothing else is near.
struct Edge {
  cv::Point2d a, b;
  double half_length_px = 0;
};

struct Found {
  std::vector<Corner> corners;  // Empty where the target is not seen.
  std::string why;              // Then what is seen instead, in words.
  double edge_px = 0;  // From 10 to 90 % of the step of light, the blurrier way; 0 unknown.
};

// Each takes a grey picture of 8 bits.
Found find_chessboard(const cv::Mat& picture, const Target& target);
Found find_circles(const cv::Mat& picture, const Target& target);
Found find_aprilgrid(const cv::Mat& picture, const Target& target);
Found find_charuco(const cv::Mat& picture, const Target& target);

}  // namespace seam::detector
