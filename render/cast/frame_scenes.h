// The scenes of a job, at its instants and between them, as far as some rows can see them: what
// stands out of sight is not even put where it stands.
#pragma once

#include <array>
#include <vector>

#include "render/cast/prepared_scene.h"
#include "render/cast/ray_table.h"
#include "sim_core/scene/frame.h"

namespace seam::render {

// Of one thread. Instants are asked for in ascending order, or the work is done anew.
class FrameScenes {
 public:
  FrameScenes(const FrameJob& job, const CameraRays& rays);

  // What these rows can see at the job's instant k, or at a time between its instants.
  void prepare_at(size_t k, RowRange rows, PreparedInstant& out);
  void prepare_at(SimTime time, RowRange rows, PreparedInstant& out);

  // An upper bound of how far any point moves in the image between instants k and k + 1, pixels.
  // Above `enough_px` it does not depend on how figures were looked at.
  double motion_px(size_t k, double enough_px);

 private:
  // A figure's parts at the last even and the last odd instant for which they were placed.
  struct Placed {
    const Figure* figure;
    std::array<size_t, 2> instant;
    std::array<std::vector<Primitive>, 2> parts;
  };
  const std::vector<Primitive>& parts_at(size_t k, const FigureAt& at);
  // Begins with the scenery and what an instant has beside figures; returns the place after them.
  int show_first(const Pose& X_CW, RowRange rows, const std::vector<Primitive>& primitives);
  void show(const std::vector<Primitive>& primitives, int first_place);

  const FrameJob& job_;
  const CameraRays& rays_;
  std::vector<Vec3> scenery_centres_W_;
  std::vector<double> scenery_radii_m_;
  std::vector<Placed> placed_;
  std::vector<Shown> shown_;
  std::vector<std::vector<Primitive>> between_;  // Parts of figures between two instants.
};

}  // namespace seam::render
