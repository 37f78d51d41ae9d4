// Views with the poses that a fit has found, while a model changes a little: at rest, and then
// following as far as a first step goes.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "measurement/kinds/points/points_problem.h"

namespace seam::measurement {

class PointsProblem::ViewsAtRest : public SmallChanges {
 public:
  ViewsAtRest(const PointsProblem& problem, const Model& model, const Groups& groups,
              const Evaluation& here);

  std::vector<double> to(const Model& there) const override;
  // The same where all rows but those of one camera stay; -1: none stays.
  std::vector<double> to(const Model& there, int only_camera) const;
  // Takes out of a column, over each row's noise, what the pose of its view can take of it
  // (Kaufman 1975), and leaves residuals as they count.
  void follow(std::vector<double>& column) const;

 private:
  struct View {
    std::vector<int> rows;
    std::vector<Sighting> seen;
    Pose X_CW;
    std::vector<double> residuals;
    Eigen::MatrixXd basis;  // Orthonormal: of what its pose does. Empty: a view that takes no part.
  };
  View view_of(size_t frame, const Cameras& cameras, const Groups& groups,
               const Evaluation& here) const;
  void count(const View& view, auto&& slopes) const;

  const PointsProblem& problem_;
  std::vector<Vec3> places_W_;
  std::vector<Eigen::Matrix2d> counted_;  // Of scattered residuals, by row. Empty: as they are.
  std::vector<View> views_;
};

}  // namespace seam::measurement
