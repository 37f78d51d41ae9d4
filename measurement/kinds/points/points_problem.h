// The problem of a set of points. Its evaluation stands in a file for each sort of rig: known
// motion (points_rig.cc), estimated poses (points_unknown.cc) or paths (points_moving.cc), and
// poses beside draws of the target that are estimated, too (target_adjustment.cc).
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <mutex>

#include "measurement/kinds/points/data/points_data.h"
#include "measurement/kinds/points/data/points_noise.h"
#include "measurement/kinds/points/motion/path_adjustment.h"
#include "measurement/kinds/points/points_scatter.h"
#include "measurement/kinds/points/target/pose_solver.h"
#include "measurement/kinds/points/target_adjustment.h"
#include "measurement/problem/views.h"

namespace seam::measurement {

class PointsPredictor;

class PointsProblem : public Problem, public HasViews {
 public:
  explicit PointsProblem(const MeasurementSet& set);

  void place(const Model& model) override;
  void check_model(const Model& model) const override;
  // The table's, and the logged angles of the joints.
  std::vector<std::string> formula_columns() const override { return data_.further.names; }
  Evaluation evaluate(const Model& model, const Groups& groups,
                      const Evaluation* warm) const override;
  Evaluation evaluate_held_out(const Model& model, const Groups& groups) const override;
  Score score_held_out(const Model& model, const Groups& groups) const override;
  Fit fit(const Model& start, const std::vector<Unknown>& unknowns,
          const Groups& groups) const override;
  std::vector<std::vector<double>> jacobian(const Model& model,
                                            const std::vector<Unknown>& unknowns,
                                            const Groups& groups,
                                            const Evaluation& here) const override;
  std::vector<std::vector<double>> following(
      const Model& model, const Groups& groups, const Evaluation& here,
      std::vector<std::vector<double>> columns) const override;
  std::unique_ptr<SmallChanges> small_changes(const Model& model, const Groups& groups,
                                              const Evaluation& here) const override;
  // The place within a pixel, and the target's points.
  std::vector<FieldPlace> field_places(const Model& model, const Evaluation& here) const override;
  bool is_smooth(const Model&) const override { return true; }
  // Beside a gyroscope what its readings and its place have wrong, too.
  bool acts(const EffectDefinition& effect) const override;
  std::string not_testable(const Model& model, const EffectDefinition& effect,
                           size_t parameter) const override;
  std::vector<std::vector<double>> starts(const Model& model,
                                          const EffectDefinition& effect) const override;
  bool groups_are_independent(const Model& model) const override;
  // What a path can follow differs from stretch to stretch.
  bool training_stands_for_all() const override { return !on_path(); }
  std::vector<std::string> remarks(const Model& model) const override;
  // A lens with a pole inside the image.
  std::string no_result_because(const Model& model) const override;
  // Focal lengths and centre, with what effects change of them.
  std::vector<Figure> figures(const Model& model) const override;
  std::vector<PlacedPoint> placed_points(const Model& model) const override;
  std::vector<PlacedView> placed_views(const Model& model) const override;
  std::vector<char> find_outliers(const Model& model) const override;
  const std::vector<Groups>& folds() const override;
  // Each view shows most of the target: no point of it is a regime of its own.
  std::vector<Groups> regimes() const override { return {}; }

 private:
  void join_few_views();
  void state_noise(const MeasurementSet& set);
  void take_noise(const std::array<double, 2>& sigma);
  void take_noise_of_views();
  void weigh_views(const std::vector<double>& of_view);
  std::optional<SeenByCamera> seen_by_wide_camera() const;
  std::vector<int> neighbours(size_t row, size_t count) const override;
  Evaluation blank() const;
  double sigma_of(size_t row, int channel) const {
    const double spread = data_.spread.empty() ? 1 : data_.spread[row];
    return facts_.channels[channel].noise * (spread > 0 ? spread : 1);
  }
  bool takes_part(size_t row) const { return !left_out(2 * row) && !left_out(2 * row + 1); }

  // Without draws of the target.
  Evaluation evaluate_plain(const Model& model, const Groups& groups, const Evaluation* warm) const;

  // points_rig.cc
  Evaluation evaluate_rig(const Model& model, const Groups& groups, const Evaluation* warm) const;
  // Derivatives of each row's image by latency and by each joint's angle: (u, v) pairs.
  struct Slopes {
    size_t width = 2;
    std::vector<double> by_row;
    std::vector<double> instant_s;
  };
  bool has_shared_causes(const PointsPredictor& predictor) const;
  Slopes slopes_of(const PointsPredictor& predictor, const Groups& groups) const;
  // What moves several points of a frame together: a column a cause, each of unit spread.
  Eigen::MatrixXd shared_causes(const PointsPredictor& predictor, const Slopes& slopes,
                                const std::vector<size_t>& scalars) const;
  void whiten_frames(const PointsPredictor& predictor, const Groups& groups, const Slopes& slopes,
                     const std::optional<FewErrors>& scatter, Evaluation& evaluation) const;
  // Where points share no causes.
  void whiten_all_scattered(const FewErrors& scatter, const Groups& groups,
                            Evaluation& evaluation) const;

  // points_at_rest.cc
  class ViewsAtRest;
  std::vector<std::vector<double>> jacobian_unknown(const Model& model,
                                                    const std::vector<Unknown>& unknowns,
                                                    const Groups& groups,
                                                    const Evaluation& here) const;
  std::vector<std::vector<double>> following_unknown(
      const Model& model, const Groups& groups, const Evaluation& here,
      std::vector<std::vector<double>> columns) const;

  // points_unknown.cc
  // Not `refined`: poses good enough to start an adjustment from.
  Evaluation evaluate_unknown(const Model& model, const Groups& groups, const Evaluation* warm,
                              bool refined = true) const;
  std::vector<Eigen::Matrix2d> slopes_of_scattered(const FewErrors& scatter, const Groups& groups,
                                                   const Evaluation& here) const;
  std::vector<Sighting> sightings(int frame, const std::vector<Vec3>& places_W,
                                  std::vector<int>& rows) const;
  double reach_rad(const Model& model, int camera) const;
  int only_camera(const effects::EffectDefinition& effect) const;
  void count_as_missed(int frame, Evaluation& evaluation) const;

  // points_fields.cc
  std::vector<std::vector<double>> slopes_of_target(const Model& model,
                                                    const Evaluation& here) const;
  std::vector<std::vector<double>> slopes_on_path(const Model& model, const Evaluation& here) const;

  // points_moving.cc
  bool moves() const {
    return data_.rig.type() == Rig::Type::unknown && data_.rig.path() != Rig::Path::still;
  }
  bool on_path() const { return moves() && data_.rig.path() == Rig::Path::spline; }
  void state_motion();
  void check_offset(const Model& model) const;  // points_gyroscope.cc
  void choose_knots(const Model& model);
  void remark_on_path(std::vector<std::string>& remarks) const;
  std::vector<double> exposures_of_frames() const;
  PathLayout layout_of(const Groups& groups) const;
  PathAdjustment path_adjustment(const Model& model, const Groups& groups, const PathLayout& layout,
                                 bool all = false) const;
  // Poses and nuisances of an evaluation whose nuisance values have a path's controls.
  void tell_path(const Model& model, const PathLayout& layout, Evaluation& evaluation) const;
  bool start_path(const Evaluation& still, const PathLayout& layout,
                  std::vector<Control>& controls) const;
  Evaluation evaluate_moving(const Model& model, const Groups& groups,
                             const Evaluation* warm) const;
  std::vector<std::vector<double>> jacobian_moving(const Model& model,
                                                   const std::vector<Unknown>& unknowns,
                                                   const Groups& groups,
                                                   const Evaluation& here) const;
  std::vector<std::vector<double>> following_moving(const Model& model, const Groups& groups,
                                                    const Evaluation& here,
                                                    std::vector<std::vector<double>> columns) const;

  // points_draws.cc
  // An adjustment that stands at these numbers (Evaluation::nuisance_values); no sigmas: the stated
  // ones. None where the numbers are those of another path.
  std::unique_ptr<TargetAdjustment> adjustment_at(const Model& model, const Groups& groups,
                                                  const DrawsKnown* known,
                                                  const std::vector<double>& values,
                                                  const std::vector<double>& sigma = {}) const;
  // By scalar: the sigmas with which these residuals count where points may have failed.
  std::vector<double> counted_sigma(const FewErrors& scatter, const Evaluation& evaluation) const;
  std::vector<double> counted_sigma(const FewErrors& scatter,
                                    const TargetAdjustment& adjustment) const;
  void settle_scattered(const FewErrors& scatter, const Model& model, const Groups& groups,
                        const DrawsKnown* known, std::vector<double> last,
                        std::unique_ptr<TargetAdjustment>& adjustment) const;
  // An adjustment of these groups' draws and poses, and what it evaluates to; nothing where none
  // could be found.
  std::unique_ptr<TargetAdjustment> adjusted(const Model& model, const Groups& groups,
                                             const Evaluation* warm, const DrawsKnown* known,
                                             Evaluation& evaluation) const;
  // Where to start an adjustment of these groups: at the end of that of a model like this one, if
  // there was one.
  std::vector<double> start_beside(const Model& model, const Groups& groups) const;
  std::vector<double> key_of_ends(const Groups& groups) const;
  void remember_end(const Model& model, const Groups& groups,
                    const std::vector<double>& values) const;
  // points_draws_fit.cc
  class DrawsFit;
  std::vector<Eigen::MatrixXd> causes_by_frame(const Model& model, const Groups& groups) const;
  Evaluation predict_held_out(const Model& model, const Groups& groups) const;
  DrawsKnown known_from(const Model& model, const Groups& groups) const;
  std::vector<std::vector<double>> jacobian_draws(const Model& model,
                                                  const std::vector<Unknown>& unknowns,
                                                  const Groups& groups,
                                                  const Evaluation& here) const;

  // points_cameras.cc
  void check_cameras(const Model& model) const;
  // Where a fit may begin: with the cameras that it shall find at places that the views say.
  Model with_cameras_placed(const Model& model, const std::vector<Unknown>& unknowns,
                            const Groups& groups) const;
  std::vector<std::optional<Pose>> places_by_views(const Model& model, const Groups& groups) const;

  // points_remarks.cc
  std::string least_and_most(const std::vector<double>& of_view) const;  // points.cc
  void remark_on_scatter(const Evaluation& evaluation, std::vector<std::string>& remarks) const;
  void remark_on_views(const Evaluation& evaluation, std::vector<std::string>& remarks) const;
  // Of several cameras: frames in which they see the target in places of their own
  // (points_cameras.cc).
  void remark_on_agreement(const Model& model, const Evaluation& evaluation,
                           std::vector<std::string>& remarks) const;
  void remark_on_reach(const Model& model, std::vector<std::string>& remarks) const;
  void remark_on_spacing(const Model& model, std::vector<std::string>& remarks) const;

  PointsData data_;
  std::vector<double> frame_stamp_s_;
  double period_s_ = 0, knot_s_ = 0;
  // Frames of a video are held out in stretches: a path through single ones says nothing of them.
  std::vector<Groups> video_folds_;
  // Held-out evaluations asked for last: a function of their keys, so that it does not matter which
  // thread asked first.
  mutable std::mutex recent_mutex_;
  mutable std::deque<std::pair<std::vector<double>, Evaluation>> recent_;
  // Nuisances at the ends of fits, by the fitted model, since outliers were marked last. The first
  // that is stored stays, so that no thread's haste changes another's result.
  mutable std::map<std::vector<double>, std::vector<double>> ends_;
  mutable int64_t ends_marked_ = -1;
};

// The model with each unknown moved by a small step, for differences at fixed nuisances.
struct MovedModels {
  MovedModels(const Model& model, const std::vector<Unknown>& unknowns);
  std::vector<Model> models;
  std::vector<double> steps;
};

}  // namespace seam::measurement
