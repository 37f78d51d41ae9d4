// Points seen in a video by a camera whose path is estimated with the model.
#include <fmt/core.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "measurement/kinds/points/points_predictor.h"
#include "measurement/kinds/points/points_problem.h"
#include "measurement/numerics/robust.h"

namespace seam::measurement {
namespace {

// Frame periods from knot to knot, the smoothest path first.
constexpr double kPeriods[] = {2.5, 1.75, 1.25, 1};

}  // namespace

// Times of the frames, the distance of knots, and which frames are held out together.
void PointsProblem::state_motion() {
  if (!moves()) return;
  for (const std::vector<int>& rows : data_.rows_of_frame)
    frame_stamp_s_.push_back(data_.stamp_s[rows.front()]);
  std::vector<size_t> order(frame_stamp_s_.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return frame_stamp_s_[a] < frame_stamp_s_[b]; });
  period_s_ = data_.camera.frame_period_s;
  std::vector<double> apart_s;
  for (size_t i = 1; i < order.size(); ++i) {
    const double step = frame_stamp_s_[order[i]] - frame_stamp_s_[order[i - 1]];
    if (step > 0) apart_s.push_back(step);
  }
  if (!(period_s_ > 0)) period_s_ = apart_s.empty() ? 1 : median_of(apart_s);
  knot_s_ = data_.rig.knot_s() > 0 ? data_.rig.knot_s() : kPeriods[0] * period_s_;
  if (!on_path()) return;
  // Stretches long enough for a path of their own, cut where no group is cut.
  constexpr size_t kFramesOfABlock = 6;
  std::vector<Groups> blocks;
  size_t frames = kFramesOfABlock;
  int last_group = -1;
  for (const size_t frame : order) {
    const int group = facts_.group_of_row[data_.rows_of_frame[frame].front()];
    if (frames >= kFramesOfABlock && group != last_group) {
      blocks.emplace_back(facts_.groups.size(), 0);
      frames = 0;
    }
    blocks.back()[static_cast<size_t>(group)] = 1;
    last_group = group, ++frames;
  }
  constexpr size_t kLeastBlocks = 4;
  if (blocks.size() < kLeastBlocks) return;
  // Those between them stay together: single ones have so many controls for their frames that they
  // say little of the lens and of the rows' times, and a model fitted to them would miss.
  constexpr size_t kOneOf = 4;
  Groups fold(facts_.groups.size(), 0);
  for (size_t b = 0; b < blocks.size(); b += kOneOf) {
    for (size_t g = 0; g < fold.size(); ++g) fold[g] |= blocks[b][g];
  }
  video_folds_ = {std::move(fold)};
}

// The smoothest path that passes where each frame's own pose says. A pose of its own is the best
// that its points allow, whatever else the model lacks, so that what a path costs beyond them tells
// of the path alone.
void PointsProblem::choose_knots(const Model& model) {
  constexpr double kSigmas = 3;
  const Groups all = all_groups();
  const Evaluation still = evaluate_unknown(model, all, nullptr);
  double chi2 = 0;
  for (size_t i = 0; i < facts_.scalars(); ++i)
    chi2 += still.used[i] ? still.whitened[i] * still.whitened[i] : 0;
  RowCamera camera(model, data_.cameras, data_.gyroscope.get());
  for (RowClock& clock : camera.clocks) clock.line_delay_s = 0;
  for (const double periods : kPeriods) {
    knot_s_ = periods * period_s_;
    const PathLayout layout = layout_of(all);
    const PathAdjustment adjustment = path_adjustment(model, all, layout);
    std::vector<Control> controls;
    if (!start_path(still, layout, controls) || !adjustment.fit(camera, controls)) continue;
    const double more = 2 * adjustment.cost(camera, controls) - chi2;
    const double freedom =
        static_cast<double>(still.nuisances) - 6 * static_cast<double>(layout.controls());
    if (more < freedom + kSigmas * std::sqrt(2 * std::max(freedom, 1.0))) return;
  }
}

void PointsProblem::remark_on_path(std::vector<std::string>& remarks) const {
  const PathLayout layout = layout_of(all_groups());
  const auto& stretches = layout.stretches();
  const auto alone = std::count_if(stretches.begin(), stretches.end(),
                                   [](const Stretch& stretch) { return stretch.degree == 0; });
  if (data_.gyroscope) {
    remarks.push_back(
        "each view turns as the gyroscope says while its rows are read, and moves by a velocity of "
        "its own: turns about the optical axis give the read-out time");
    return;
  }
  if (!on_path()) {
    remarks.push_back(
        "each view moves by a velocity of its own, of which only the product with a read-out time "
        "shows: state line_delay_s, or say motion: spline of a video");
    return;
  }
  remarks.push_back(fmt::format(
      "the camera's path is estimated: {} {} of cubic splines over {} frames, knots {:.3g} s apart",
      stretches.size(), stretches.size() == 1 ? "stretch" : "stretches", frame_stamp_s_.size(),
      knot_s_));
  if (alone > 0)
    remarks.push_back(fmt::format(
        "{} of {} stretches {} a single frame, more than {:.3g} s from the next: nothing is known "
        "of the motion there{}",
        alone, stretches.size(), alone == 1 ? "is" : "are", 1.6 * knot_s_,
        2 * static_cast<size_t>(alone) > stretches.size()
            ? "; effects of time are hardly testable with this set: take all frames of a video"
            : ""));
}

const std::vector<Groups>& PointsProblem::folds() const {
  return video_folds_.empty() ? Problem::folds() : video_folds_;
}

std::vector<double> PointsProblem::exposures_of_frames() const {
  std::vector<double> exposure_s;
  for (const std::vector<int>& rows : data_.rows_of_frame) {
    if (data_.exposure_s.empty()) break;
    exposure_s.push_back(data_.exposure_s[static_cast<size_t>(rows.front())]);
  }
  return exposure_s;
}

PathLayout PointsProblem::layout_of(const Groups& groups) const {
  std::vector<char> takes_part_here;
  for (const std::vector<int>& rows : data_.rows_of_frame)
    takes_part_here.push_back(
        groups[static_cast<size_t>(facts_.group_of_row[rows.front()])] &&
        std::any_of(rows.begin(), rows.end(), [&](int row) { return takes_part(row); }));
  return on_path()
             ? PathLayout(frame_stamp_s_, takes_part_here, knot_s_)
             : PathLayout::alone(frame_stamp_s_, takes_part_here, knot_s_, exposures_of_frames());
}

PathAdjustment PointsProblem::path_adjustment(const Model& model, const Groups& groups,
                                              const PathLayout& layout, bool all) const {
  const std::vector<Vec3> places_W = places_of_rows(data_, effects::target_of(model));
  std::vector<PathSighting> seen;
  for (size_t row = 0; row < data_.p_W.size(); ++row) {
    if (!groups[static_cast<size_t>(facts_.group_of_row[row])] || !(all || takes_part(row)))
      continue;
    seen.push_back(path_sighting(data_, row, places_W[row], sigma_of(row, 0), sigma_of(row, 1)));
  }
  return {layout, std::move(seen)};
}

// From poses as if each view stood still.
bool PointsProblem::start_path(const Evaluation& still, const PathLayout& layout,
                               std::vector<Control>& controls) const {
  std::vector<Pose> X_CW(data_.rows_of_frame.size());
  std::vector<char> known;
  for (size_t frame = 0; frame < X_CW.size(); ++frame)
    known.push_back(stored_pose(still.nuisance_values, frame, X_CW[frame]));
  controls = path_through(layout, frame_stamp_s_, X_CW, known, data_.target.middle_W);
  return still.valid;
}

void PointsProblem::tell_path(const Model& model, const PathLayout& layout,
                              Evaluation& evaluation) const {
  const RowCamera camera(model, data_.cameras, data_.gyroscope.get());
  std::vector<Control> controls(layout.controls());
  stored_controls(evaluation.nuisance_values, controls);
  // Of a view that is read out at once no velocity shows.
  const bool at_once = !on_path() && camera.clocks.front().line_delay_s == 0;
  evaluation.nuisances =
      6 * static_cast<int64_t>(at_once ? layout.stretches().size() : layout.controls());
  // The second control of a view beside a gyroscope has a place alone.
  if (camera.turns && !at_once)
    evaluation.nuisances -= 3 * static_cast<int64_t>(layout.stretches().size());
  const double middle_s = 0.5 * camera.clocks.front().line_delay_s * data_.camera.height_px;
  for (size_t frame = 0; frame < data_.rows_of_frame.size(); ++frame) {
    if (!layout.takes_part(frame)) continue;
    const PathPoint at =
        point_on_path(camera, layout.of_frame(frame), controls, frame_stamp_s_[frame] + middle_s,
                      /*with_slopes=*/false);
    store_pose({at.R, at.middle_C - at.R * data_.target.middle_W}, frame,
               evaluation.nuisance_values);
  }
}

Evaluation PointsProblem::evaluate_moving(const Model& model, const Groups& groups,
                                          const Evaluation* warm) const {
  const PathLayout layout = layout_of(groups);
  const PathAdjustment adjustment = path_adjustment(model, groups, layout);
  const RowCamera camera(model, data_.cameras, data_.gyroscope.get());
  Evaluation evaluation = blank();
  std::vector<Control> controls(layout.controls());
  bool found = warm && warm->valid && stored_path(data_, warm->nuisance_values, controls) &&
               adjustment.fit(camera, controls);
  if (!found)
    found = start_path(evaluate_unknown(model, groups, nullptr), layout, controls) &&
            adjustment.fit(camera, controls);
  evaluation.nuisance_values.assign(12 * data_.rows_of_frame.size(), 0);
  evaluation.valid = found;
  if (found) {
    store_controls(controls, evaluation.nuisance_values);
    tell_path(model, layout, evaluation);
  }
  const PathAdjustment with_outliers = path_adjustment(model, groups, layout, /*all=*/true);
  for (const PathSighting& point : with_outliers.seen()) {  // They may come back.
    Eigen::Vector2d uv;
    if (!found || !layout.takes_part(point.frame) ||
        !with_outliers.image(camera, controls, point, uv))
      continue;
    evaluation.residual[2 * point.row] = point.u_px - uv[0];
    evaluation.residual[2 * point.row + 1] = point.v_px - uv[1];
  }
  whiten_diagonal(*this, groups, evaluation);
  if (const std::optional<FewErrors> scatter = scatter_of(model))
    whiten_all_scattered(*scatter, groups, evaluation);
  return evaluation;
}

// Differences at a fixed path, less what the path can follow (Kaufman 1975).
std::vector<std::vector<double>> PointsProblem::jacobian_moving(
    const Model& model, const std::vector<Unknown>& unknowns, const Groups& groups,
    const Evaluation& here) const {
  std::vector<std::vector<double>> columns(unknowns.size(),
                                           std::vector<double>(facts_.scalars(), 0));
  const PathLayout layout = layout_of(groups);
  const PathAdjustment adjustment = path_adjustment(model, groups, layout);
  const RowCamera camera(model, data_.cameras, data_.gyroscope.get());
  std::vector<Control> controls(layout.controls());
  if (!stored_path(data_, here.nuisance_values, controls)) return columns;
  const MovedModels moved(model, unknowns);
  const std::vector<PathSighting>& seen = adjustment.seen();
  for (size_t p = 0; p < unknowns.size(); ++p) {
    const PathAdjustment there = path_adjustment(moved.models[p], groups, layout);
    const RowCamera moved_camera(moved.models[p], data_.cameras, data_.gyroscope.get());
    for (size_t i = 0; i < seen.size(); ++i) {
      Eigen::Vector2d before, after;
      if (!adjustment.image(camera, controls, seen[i], before) ||
          !there.image(moved_camera, controls, there.seen()[i], after))
        continue;
      const Eigen::Vector2d by = (before - after) / moved.steps[p];
      columns[p][2 * seen[i].row] = by[0] / seen[i].sigma_u;
      columns[p][2 * seen[i].row + 1] = by[1] / seen[i].sigma_v;
    }
  }
  return following_moving(model, groups, here, std::move(columns));
}

// Without what the path can take of a column, of residuals as they count.
std::vector<std::vector<double>> PointsProblem::following_moving(
    const Model& model, const Groups& groups, const Evaluation& here,
    std::vector<std::vector<double>> columns) const {
  const PathLayout layout = layout_of(groups);
  const PathAdjustment adjustment = path_adjustment(model, groups, layout);
  const RowCamera camera(model, data_.cameras, data_.gyroscope.get());
  std::vector<Control> controls(layout.controls());
  const std::vector<PathSighting>& seen = adjustment.seen();
  Eigen::MatrixXd all(2 * static_cast<Eigen::Index>(seen.size()),
                      static_cast<Eigen::Index>(columns.size()));
  for (size_t p = 0; p < columns.size(); ++p) {
    for (size_t i = 0; i < 2 * seen.size(); ++i)
      all(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(p)) =
          columns[p][2 * seen[i / 2].row + i % 2];
    std::fill(columns[p].begin(), columns[p].end(), 0);
  }
  std::vector<Eigen::Matrix2d> counted;
  if (const std::optional<FewErrors> scatter = scatter_of(model)) {
    const std::vector<Eigen::Matrix2d> by_row = slopes_of_scattered(*scatter, groups, here);
    for (const PathSighting& point : seen)
      counted.push_back(by_row[point.row] *
                        Eigen::Vector2d(point.sigma_u, point.sigma_v).asDiagonal());
  }
  if (!stored_path(data_, here.nuisance_values, controls) ||
      !adjustment.take_out_path(camera, controls, counted, all))
    return columns;
  for (size_t p = 0; p < columns.size(); ++p) {
    for (size_t i = 0; i < 2 * seen.size(); ++i)
      columns[p][2 * seen[i / 2].row + i % 2] =
          all(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(p));
  }
  return columns;
}

}  // namespace seam::measurement
