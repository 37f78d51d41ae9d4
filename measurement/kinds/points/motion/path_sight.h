// Points seen from a path. Each is seen when its own row is read out, so that the row depends on
// the path and the path's instant on the row.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "measurement/kinds/points/motion/path.h"
#include "measurement/kinds/points/target/cameras.h"

namespace seam::measurement {

// One point in one frame.
struct PathSighting {
  size_t row = 0, frame = 0;
  Vec3 p_T{0.0};  // From the target's middle, along the world's axes.
  double u_px = 0, v_px = 0;
  double sigma_u = 1, sigma_v = 1;
  double stamp_s = 0;
  int camera = 0;
  effects::RowColumns columns;
};

// The time from one row's exposure to the next one's, and by how much the first one is later than
// that of the first camera with the same stamp.
struct RowClock {
  double line_delay_s = 0, late_s = 0;
};

// The path has the frames' own clock: what delays all rows alike belongs to it.
struct RowCamera {
  // `beside`: null where no gyroscope says how the camera turns.
  RowCamera(const effects::Model& model, const std::vector<CameraView>& views,
            const GyroscopeBeside* beside);
  Cameras cameras;
  std::vector<RowClock> clocks;            // By camera.
  std::shared_ptr<const ReadTurns> turns;  // Null: the controls say how it turns.
};

PathPoint point_on_path(const RowCamera& camera, const Stretch& stretch,
                        const std::vector<Control>& controls, double t_s, bool with_slopes);

constexpr Eigen::Index kControlUnknowns = 6;
// Controls that no point tells of stay where they are: what holds one, of the largest that points
// tell of its like.
constexpr double hold_of_control(double largest) {
  return 1e-10 * largest + 1e-300;
}

// Where a point is seen, its residuals over their sigmas, and derivatives of these: by the controls
// that act then, and by the point's place along the world's axes.
struct PathLook {
  ControlWeights weights;
  Eigen::Vector2d uv;
  Eigen::Vector2d z;
  Eigen::Matrix<double, 2, 4 * kControlUnknowns> by_controls;
  Eigen::Matrix<double, 2, 3> by_place;
};

// Both are false where the point has no image.
bool image_on_path(const PathLayout& layout, const RowCamera& camera,
                   const std::vector<Control>& controls, const PathSighting& point,
                   Eigen::Vector2d& uv);
bool look_on_path(const PathLayout& layout, const RowCamera& camera,
                  const std::vector<Control>& controls, const PathSighting& point, PathLook& look);

}  // namespace seam::measurement
