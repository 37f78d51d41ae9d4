// For tests: a set of views of a board whose poses nobody knows, 640 x 480 pixels.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "sim_core/base/output.h"

namespace seam::measurement {

// `points`: rows of points.csv below its columns; `noise`: a line of measurement.yaml, or nothing;
// `further`: columns behind those.
inline std::filesystem::path write_views(const std::string& name, const std::string& points,
                                         const std::string& noise = "",
                                         const std::string& further = "") {
  const auto folder = std::filesystem::path(testing::TempDir()) / name;
  std::filesystem::create_directories(folder);
  write_file_atomically(folder / "points.csv",
                        "frame,time_s,point,x_m,y_m,z_m,u_px,v_px" + further + "\n" + points);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: points\n"
                        "camera: {width_px: 640, height_px: 480}\n" +
                            noise +
                            "group: frame\n"
                            "files: {points: points.csv}\nrig: {pose: unknown}\n");
  return folder;
}

}  // namespace seam::measurement
