// What the camera and its colour detection show of the ball, as in Fig. 10 and 13 of the paper.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace seam::tools {

struct BallPicture {
  std::filesystem::path scenario;  // Of the run.
  std::string robot;
  std::string caption;
};

// Two rows for each camera: frames with the ball framed, and below each the colours detected in it.
// All cameras have equally many pictures.
void draw_ball_pictures(const std::vector<std::vector<BallPicture>>& by_camera,
                        const std::filesystem::path& file);

}  // namespace seam::tools
