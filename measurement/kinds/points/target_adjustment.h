// Displaced points of a target, bendings, focal lengths and motions of its views and how it sways
// from one camera's picture of a frame to another's, fitted together with the views' poses, or the
// path through a video, where these are unknown: what effects of the target draw is estimated from
// all views, held near zero by its spread. Docs: docs/design/engine.md, "Draws that are estimated".
#pragma once

#include <functional>
#include <optional>

#include "effects/stages/geometry.h"
#include "measurement/kinds/points/data/points_data.h"
#include "measurement/kinds/points/motion/path_sight.h"
#include "measurement/numerics/damped_step.h"
#include "measurement/numerics/paired_blocks.h"

namespace seam::measurement {

class PointsPredictor;

// What is known of the points' displacements (along the target's axes) before views are seen.
struct DrawsKnown {
  std::vector<Eigen::Vector3d> mean_m;     // By point.
  std::vector<Eigen::Matrix3d> precision;  // 1 / m^2.
};

// A row's point at this place, as a path sees it.
PathSighting path_sighting(const PointsData& data, size_t row, const Vec3& place_W, double sigma_u,
                           double sigma_v);
// A path's controls among nuisances, which may have displaced points before them; false: those of
// other frames.
bool stored_path(const PointsData& data, const std::vector<double>& values,
                 std::vector<Control>& controls);

class TargetAdjustment {
 public:
  struct Given {
    const PointsData& data;
    const Model& model;
    std::vector<char> frames;   // Those that take part.
    std::vector<char> rows;     // Those that take part; rows of other frames are not looked at.
    std::vector<double> sigma;  // By scalar.
    // By frame, for rigs whose motion is known: causes that move several of its scalars together,
    // a column each of unit spread (rows: its used scalars in order). Empty: none.
    std::vector<Eigen::MatrixXd> causes = {};
    const DrawsKnown* known = nullptr;  // Null: nothing but the model's spread.
    // Of a video the path of its frames; of it points may be displaced, nothing else drawn.
    std::optional<PathLayout> path = std::nullopt;
  };
  explicit TargetAdjustment(Given given);

  // Poses to start from (12 numbers a frame, as Evaluation::nuisance_values has them), then those
  // numbers that an earlier adjustment stored behind them. Frames whose numbers are all zero take
  // no part from here on. Of a path its controls stand at the end in place of poses; false where
  // they are those of other frames.
  bool start(const std::vector<double>& values);
  // Goes down to the best nuisances, or so many steps of the way; false where that failed.
  bool fit(int most_steps = 30);

  // The adjusted numbers, to start another from.
  std::vector<double> values() const { return values_of(state_); }
  // Fills the residuals of all rows of its frames,
  void tell_residuals(Evaluation& evaluation) const;
  // and, after whiten_diagonal, what follows from the draws: whitened residuals and, behind them,
  // the draws; determinants; the freedom that they take.
  void whiten(Evaluation& evaluation) const;
  // The sigmas by scalar with which residuals count from here on.
  void set_sigma(std::vector<double> sigma) { given_.sigma = std::move(sigma); }
  // By unknown: the column of its derivatives with all nuisances following. `moved[k]` is the model
  // with the k-th unknown moved by step[k].
  std::vector<std::vector<double>> columns(const std::vector<Model>& moved,
                                           const std::vector<double>& steps);
  // The parabola of the unknowns, all nuisances following; nothing where these are not determined.
  std::optional<Parabola> look(const std::vector<Model>& moved, const std::vector<double>& steps);
  // The numbers where the unknowns go by this from the last look, the nuisances with them.
  std::vector<double> values_after(const Eigen::VectorXd& by) const;
  // Half the sum of squares where it stands, the draws' own among them.
  double height() const { return cost(state_); }
  // Sums over draws of one sort, where the last look or fit stood.
  struct DrawsSum {
    double square = 0;       // Of draws over their spread.
    double freedom = 0;      // How many of them the views tell, not their spread.
    double information = 0;  // On the logarithm of their spread.
  };
  struct DrawsSums {
    DrawsSum points, bendings, focuses, motions, shifts, turns;
  };
  DrawsSums sums() const;
  // The squares alone, wherever it stands.
  DrawsSums squares() const;
  // Displacements and their covariances, poses being estimated, too.
  const std::vector<Vec3>& displaced_m() const { return state_.displaced_m; }
  std::vector<Eigen::Matrix3d> covariances();

 private:
  struct State {
    std::vector<Pose> X_CW;         // By frame.
    std::vector<Control> controls;  // Of a path.
    // By frame, over their spreads: bending, then the focal length of each camera, then the turn
    // while the rows are read, then a shift and a turn before each camera but the first, then
    // causes.
    std::vector<Eigen::VectorXd> extra;
    std::vector<Vec3> displaced_m;  // By point.
  };
  // A compiled model: one for the fit, one for each moved unknown.
  struct Compiled {
    Compiled(const PointsData& data, const Model& model);
    effects::TargetShape shape;
    RowCamera camera;
    std::shared_ptr<const PointsPredictor> predictor;  // Of known motion.
    std::vector<Vec3> places_W;                        // By row, without displacements.
  };
  // One observation: its image, residuals over their sigmas, and derivatives of these.
  struct Cell {
    Eigen::Vector2d uv;
    Eigen::Vector2d z;
    Eigen::Index from = 0;  // Of its view's unknowns the first that acts.
    PairedBlocks::Slopes by_view;
    Eigen::Matrix<double, 2, 3> by_point;
  };

  bool has_points() const { return compiled_.shape.scatter_sigma_m > 0; }
  bool has_flex() const { return compiled_.shape.flex_sigma_m > 0; }
  bool has_focus() const { return compiled_.shape.focus_sigma > 0; }
  bool has_motion() const { return unknown_poses_ && compiled_.shape.motion_sigma_rad > 0; }
  bool has_sway() const { return compiled_.shape.has_sway(); }
  // Of a frame's extras: where the focal length of this camera stands, where those of the motion
  // begin, those of the sway before this camera, and causes.
  Eigen::Index focus_at(int camera) const { return (has_flex() ? 1 : 0) + camera; }
  Eigen::Index motion_at() const {
    return focus_at(has_focus() ? static_cast<int>(given_.data.cameras.size()) : 0);
  }
  Eigen::Index sway_at(int camera) const {
    return motion_at() + (has_motion() ? 3 : 0) + 6 * (camera - 1);
  }
  // The spread of an extra between the bending and the causes.
  double spread_at(Eigen::Index extra) const;
  Eigen::Index causes_at() const {
    return sway_at(has_sway() ? static_cast<int>(given_.data.cameras.size()) : 1);
  }
  bool sways(size_t row) const { return has_sway() && given_.data.camera_of_row[row] > 0; }
  bool has_own_poses() const { return unknown_poses_ && !given_.path; }
  Eigen::Index pose_unknowns() const { return unknown_poses_ ? kControlUnknowns : 0; }
  Eigen::Index unknowns(size_t frame) const;
  // What the blocks take for views: frames, or the stretches of a path.
  size_t view_of(size_t frame) const {
    return given_.path ? given_.path->stretch_of(frame) : frame;
  }
  std::vector<Eigen::Index> view_sizes() const;
  PathSighting sighting(const Compiled& model, const State& state, size_t row) const;
  Vec3 place_W(const Compiled& model, const State& state, size_t row) const;
  // Where a point of the rig's frame is while the row is read: the rig turns meanwhile.
  Vec3 carried(const State& state, size_t row, const Vec3& p_R) const;
  // The image as the view's own focal length has it.
  effects::ImagePoint focused(const State& state, size_t row, effects::ImagePoint image) const;
  // The image of a row's point; null slopes: not wanted.
  bool see(const Compiled& model, const State& state, size_t row, Eigen::Vector2d& uv) const;
  bool look(const State& state, size_t row, size_t k, Cell& cell) const;
  bool look_on_path(const State& state, size_t row, Cell& cell) const;
  void slopes_of_extras(size_t row, size_t k, Cell& cell) const;
  void slopes_of_motion(const State& state, size_t row, const Eigen::Matrix<double, 2, 3>& by_R,
                        const Vec3& p_R, Cell& cell) const;
  void slopes_of_pose(const State& state, size_t row, const Eigen::Matrix<double, 2, 3>& by_C,
                      Cell& cell) const;
  double cause(size_t frame, size_t k, int channel, Eigen::Index which) const;
  std::vector<size_t> used_rows() const;
  Eigen::Vector2d left_over(size_t row, const Cell& cell, const Evaluation& evaluation) const;
  double square(const State& state, size_t frame) const;
  double cost(const State& state) const;
  bool look_at_rows();
  double prior_cost(const State& state) const;
  void hold_unseen_controls();
  bool build(Eigen::MatrixXd& by_views, Eigen::MatrixXd& by_points);
  Eigen::VectorXd slopes_by(const Model& moved, double step, const std::vector<size_t>& used) const;
  std::vector<double> column_of(const Eigen::VectorXd& slopes, const std::vector<size_t>& used,
                                size_t unknown);
  std::vector<double> values_of(const State& state) const;
  State moved(const Eigen::MatrixXd& views, const Eigen::MatrixXd& points, double by) const;
  Eigen::Matrix3d precision(size_t point) const;
  Eigen::Vector3d mean(size_t point) const;
  // The draws' blocks with poses as they stand, for the used rows.
  PairedBlocks blocks_of_draws(const std::vector<size_t>& used) const;
  double log_det_of_pose(size_t frame) const;
  Eigen::MatrixXd left_by_pose(size_t frame) const;
  std::vector<double> left_with_draws(const std::vector<size_t>& used) const;

  Given given_;
  Compiled compiled_;
  bool unknown_poses_;
  State state_;
  std::unique_ptr<PairedBlocks> blocks_;
  std::vector<Cell> cells_;  // Of the used rows, in order of frames_.
  // How nuisances follow the unknowns (a column each), and their own step behind that.
  Eigen::MatrixXd following_views_, following_points_;
};

}  // namespace seam::measurement
