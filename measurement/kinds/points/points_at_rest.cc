#include "measurement/kinds/points/points_at_rest.h"

#include "measurement/kinds/points/points_predictor.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/parallel_for.h"

namespace seam::measurement {

PointsProblem::ViewsAtRest::ViewsAtRest(const PointsProblem& problem, const Model& model,
                                        const Groups& groups, const Evaluation& here)
    : problem_(problem),
      places_W_(places_of_rows(problem.data_, effects::target_of(model))),
      views_(problem.data_.rows_of_frame.size()) {
  if (const std::optional<FewErrors> scatter = scatter_of(model))
    counted_ = problem.slopes_of_scattered(*scatter, groups, here);
  const Cameras cameras(model, problem.data_.cameras);
  parallel_for(views_.size(),
               [&](size_t frame) { views_[frame] = view_of(frame, cameras, groups, here); });
}

PointsProblem::ViewsAtRest::View PointsProblem::ViewsAtRest::view_of(size_t frame,
                                                                     const Cameras& cameras,
                                                                     const Groups& groups,
                                                                     const Evaluation& here) const {
  const std::vector<int>& rows = problem_.data_.rows_of_frame[frame];
  View view;
  if (!groups[problem_.facts().group_of_row[rows.front()]]) return view;
  view.seen = problem_.sightings(static_cast<int>(frame), places_W_, view.rows);
  std::vector<double> slopes;
  if (view.seen.empty() || !stored_pose(here.nuisance_values, frame, view.X_CW) ||
      !pose_residuals(cameras, view.seen, view.X_CW, view.residuals, &slopes))
    return view;
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>> pose(
      slopes.data(), static_cast<Eigen::Index>(view.residuals.size()), 6);
  count(view, pose);
  view.basis = column_basis(pose);
  return view;
}

// Residuals over their sigmas count as they do, or as scattered ones.
void PointsProblem::ViewsAtRest::count(const View& view, auto&& slopes) const {
  for (size_t k = 0; k < view.rows.size() && !counted_.empty(); ++k) {
    const Eigen::Vector2d sigma(view.seen[k].sigma_u, view.seen[k].sigma_v);
    const auto at = 2 * static_cast<Eigen::Index>(k);
    slopes.template middleRows<2>(at) =
        (counted_[view.rows[k]] * sigma.asDiagonal() * slopes.template middleRows<2>(at)).eval();
  }
}

std::vector<double> PointsProblem::ViewsAtRest::to(const Model& there) const {
  return to(there, -1);
}

std::vector<double> PointsProblem::ViewsAtRest::to(const Model& there, int only_camera) const {
  std::vector<double> changes(problem_.facts().scalars(), 0);
  const Cameras cameras(there, problem_.data_.cameras);
  const std::vector<Vec3> places_W = places_of_rows(problem_.data_, effects::target_of(there));
  parallel_for(views_.size(), [&](size_t frame) {
    const View& view = views_[frame];
    if (view.basis.size() == 0) return;
    std::vector<Sighting> moving;
    std::vector<size_t> place;
    moving.reserve(view.seen.size()), place.reserve(view.seen.size());
    for (size_t k = 0; k < view.seen.size(); ++k) {
      if (only_camera >= 0 && view.seen[k].camera != only_camera) continue;
      place.push_back(k), moving.push_back(view.seen[k]);
      moving.back().p_W = places_W[view.rows[k]];
    }
    std::vector<double> residuals;
    if (!pose_residuals(cameras, moving, view.X_CW, residuals, nullptr)) return;
    for (size_t i = 0; i < residuals.size(); ++i) {
      const size_t k = place[i / 2], channel = i % 2;
      changes[2 * view.rows[k] + channel] = residuals[i] - view.residuals[2 * k + channel];
    }
  });
  follow(changes);
  return changes;
}

void PointsProblem::ViewsAtRest::follow(std::vector<double>& column) const {
  for (size_t frame = 0; frame < views_.size(); ++frame) {
    const View& view = views_[frame];
    if (view.basis.size() == 0) {
      for (const int row : problem_.data_.rows_of_frame[frame])
        column[2 * row] = column[2 * row + 1] = 0;
      continue;
    }
    Eigen::VectorXd own(view.basis.rows());
    for (Eigen::Index k = 0; k < own.size(); ++k) own[k] = column[2 * view.rows[k / 2] + k % 2];
    count(view, own);
    own -= view.basis * (view.basis.transpose() * own);
    for (Eigen::Index k = 0; k < own.size(); ++k) column[2 * view.rows[k / 2] + k % 2] = own[k];
  }
}

std::unique_ptr<SmallChanges> PointsProblem::small_changes(const Model& model, const Groups& groups,
                                                           const Evaluation& here) const {
  const bool at_rest =
      data_.rig.type() == Rig::Type::unknown && !moves() && !effects::target_of(model).has_draws();
  if (!at_rest) return Problem::small_changes(model, groups, here);
  return std::make_unique<ViewsAtRest>(*this, model, groups, here);
}

std::vector<std::vector<double>> PointsProblem::jacobian_unknown(
    const Model& model, const std::vector<Unknown>& unknowns, const Groups& groups,
    const Evaluation& here) const {
  const ViewsAtRest views(*this, model, groups, here);
  const MovedModels moved(model, unknowns);
  std::vector<std::vector<double>> columns(unknowns.size());
  parallel_for(unknowns.size(), [&](size_t p) {
    columns[p] =
        views.to(moved.models[p], only_camera(*model.find(unknowns[p].effect)->definition));
    for (double& value : columns[p]) value /= moved.steps[p];
  });
  return columns;
}

std::vector<std::vector<double>> PointsProblem::following_unknown(
    const Model& model, const Groups& groups, const Evaluation& here,
    std::vector<std::vector<double>> columns) const {
  const ViewsAtRest views(*this, model, groups, here);
  parallel_for(columns.size(), [&](size_t p) { views.follow(columns[p]); });
  return columns;
}

}  // namespace seam::measurement
