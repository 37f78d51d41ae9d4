// Evaluations in which draws of the target (displaced points, bendings of views) are estimated with
// the model. Of groups that are held out the draws are known from all others.
#include <algorithm>
#include <cmath>

#include "measurement/kinds/points/points_predictor.h"
#include "measurement/kinds/points/points_problem.h"
#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {

namespace {

// What tells one model from another, less one of its effects, behind what else matters.
std::vector<double> key_of(const Model& model, std::vector<double> key = {},
                           const effects::ModelEffect* less = nullptr) {
  for (const effects::ModelEffect& effect : model.effects()) {
    if (&effect == less) continue;
    const std::string text = effect.definition->name + "\n" + effect.definition->source;
    key.push_back(static_cast<double>(std::hash<std::string>{}(text) >> 12));
    key.insert(key.end(), effect.values().begin(), effect.values().end());
  }
  return key;
}

}  // namespace

// A path's controls are those of its frames.
std::vector<double> PointsProblem::key_of_ends(const Groups& groups) const {
  return moves() ? std::vector<double>(groups.begin(), groups.end()) : std::vector<double>();
}

void PointsProblem::remember_end(const Model& model, const Groups& groups,
                                 const std::vector<double>& values) const {
  const std::lock_guard lock(recent_mutex_);
  if (ends_marked_ != times_marked()) ends_.clear(), ends_marked_ = times_marked();
  ends_.emplace(key_of(model, key_of_ends(groups)), values);
}

// The same model, or that to which one effect was added to be tried.
std::vector<double> PointsProblem::start_beside(const Model& model, const Groups& groups) const {
  std::vector<double> values;
  const auto recall = [&](const effects::ModelEffect* less) {
    const std::lock_guard lock(recent_mutex_);
    if (ends_marked_ != times_marked()) return;
    const auto found = ends_.find(key_of(model, key_of_ends(groups), less));
    if (found != ends_.end()) values = found->second;
  };
  recall(nullptr);
  for (const effects::ModelEffect& effect : model.effects()) {
    if (values.empty()) recall(&effect);
  }
  if (values.empty() || data_.rig.type() != Rig::Type::unknown || moves()) return values;
  // Views that took no part there.
  Groups missing(groups.size(), 0);
  for (size_t frame = 0; frame < data_.rows_of_frame.size(); ++frame) {
    Pose X_CW;
    const int group = facts_.group_of_row[data_.rows_of_frame[frame].front()];
    if (groups[group] && !stored_pose(values, frame, X_CW)) missing[group] = 1;
  }
  if (std::find(missing.begin(), missing.end(), 1) == missing.end()) return values;
  const Evaluation others = evaluate_unknown(model, missing, nullptr, /*refined=*/false);
  for (size_t frame = 0; frame < data_.rows_of_frame.size(); ++frame) {
    Pose X_CW;
    if (!stored_pose(values, frame, X_CW) && stored_pose(others.nuisance_values, frame, X_CW))
      store_pose(X_CW, frame, values);
  }
  return values;
}

std::vector<Eigen::MatrixXd> PointsProblem::causes_by_frame(const Model& model,
                                                            const Groups& groups) const {
  const PointsPredictor predictor(data_, model);
  if (!has_shared_causes(predictor)) return {};
  const Slopes slopes = slopes_of(predictor, groups);
  std::vector<Eigen::MatrixXd> causes;
  for (const std::vector<int>& rows : data_.rows_of_frame) {
    std::vector<size_t> scalars;
    for (const int row : rows) {
      if (!groups[facts_.group_of_row[row]] || !takes_part(row)) continue;
      scalars.insert(scalars.end(),
                     {2 * static_cast<size_t>(row), 2 * static_cast<size_t>(row) + 1});
    }
    causes.push_back(shared_causes(predictor, slopes, scalars));
  }
  return causes;
}

std::unique_ptr<TargetAdjustment> PointsProblem::adjustment_at(
    const Model& model, const Groups& groups, const DrawsKnown* known,
    const std::vector<double>& values, const std::vector<double>& sigma) const {
  TargetAdjustment::Given given{.data = data_, .model = model, .known = known};
  for (const std::vector<int>& rows : data_.rows_of_frame) {
    const bool any =
        std::any_of(rows.begin(), rows.end(), [&](int row) { return takes_part(row); });
    given.frames.push_back(any && groups[facts_.group_of_row[rows.front()]]);
  }
  for (size_t row = 0; row < data_.p_W.size(); ++row) given.rows.push_back(takes_part(row));
  given.sigma = sigma.empty() ? blank().sigma : sigma;
  if (data_.rig.type() != Rig::Type::unknown) given.causes = causes_by_frame(model, groups);
  if (moves()) given.path = layout_of(groups);
  auto adjustment = std::make_unique<TargetAdjustment>(std::move(given));
  return adjustment->start(values) ? std::move(adjustment) : nullptr;
}

std::vector<double> PointsProblem::counted_sigma(const FewErrors& scatter,
                                                 const TargetAdjustment& adjustment) const {
  Evaluation here = blank();
  adjustment.tell_residuals(here);
  return counted_sigma(scatter, here);
}

std::vector<double> PointsProblem::counted_sigma(const FewErrors& scatter,
                                                 const Evaluation& evaluation) const {
  std::vector<double> sigma = blank().sigma;
  for (size_t u = 0; u < sigma.size(); u += 2) {
    const Failure failure = failure_of(scatter, evaluation.residual[u], evaluation.residual[u + 1],
                                       sigma[u], sigma[u + 1]);
    sigma[u] = failure.sigma_u, sigma[u + 1] = failure.sigma_v;
  }
  return sigma;
}

// Points that may have failed count for less, and how likely they did follows from where the
// others have them: a step of each in turn until neither changes. `last` has the sigmas that they
// counted with so far; empty: the stated ones.
void PointsProblem::settle_scattered(const FewErrors& scatter, const Model& model,
                                     const Groups& groups, const DrawsKnown* known,
                                     std::vector<double> last,
                                     std::unique_ptr<TargetAdjustment>& adjustment) const {
  constexpr int kRounds = 8;
  // Sigmas that change by less, all together, move the nuisances by less than matters: a point that
  // half failed takes many rounds to settle, and moves next to nothing.
  constexpr double kSame = 0.02;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<double> sigma = counted_sigma(scatter, *adjustment);
    double changed2 = last.empty() ? 1 : 0;
    for (size_t i = 0; i < last.size(); ++i) changed2 += std::pow(sigma[i] / last[i] - 1, 2);
    if (changed2 < kSame * kSame) return;
    auto next = adjustment_at(model, groups, known, adjustment->values(), sigma);
    if (!next->fit(/*most_steps=*/1)) return;
    adjustment = std::move(next), last = sigma;
  }
}

std::unique_ptr<TargetAdjustment> PointsProblem::adjusted(const Model& model, const Groups& groups,
                                                          const Evaluation* warm,
                                                          const DrawsKnown* known,
                                                          Evaluation& evaluation) const {
  const bool unknown = data_.rig.type() == Rig::Type::unknown, still = unknown && !moves();
  const bool warm_draws =
      warm && warm->valid && warm->nuisance_values.size() > 12 * data_.rows_of_frame.size();
  const std::vector<double> start =
      warm_draws ? warm->nuisance_values : start_beside(model, groups);
  const std::optional<FewErrors> scatter = unknown ? scatter_of(model) : std::nullopt;
  std::unique_ptr<TargetAdjustment> adjustment;
  std::vector<double> sigma;
  bool found = false;
  if (!start.empty()) adjustment = adjustment_at(model, groups, known, start);
  if (adjustment) {
    // Near the end each point counts as it will there.
    if (scatter) sigma = counted_sigma(*scatter, *adjustment);
    if (scatter) adjustment = adjustment_at(model, groups, known, start, sigma);
    found = adjustment->fit();
  }
  // Else from poses of their own: linear ones, or refined where these are too far off.
  for (const bool refined : {false, true}) {
    if (found || (refined && !still)) break;
    const Evaluation poses = still ? evaluate_unknown(model, groups, warm, refined)
                                   : evaluate_plain(model, groups, warm);
    if (!poses.valid) continue;
    sigma.clear();
    adjustment = adjustment_at(model, groups, known, poses.nuisance_values);
    found = adjustment->fit();
  }
  if (found && scatter)
    settle_scattered(*scatter, model, groups, known, std::move(sigma), adjustment);
  evaluation = blank();
  evaluation.valid = found;
  if (found) {
    evaluation.nuisance_values = adjustment->values();
    adjustment->tell_residuals(evaluation);
  }
  if (found && moves()) tell_path(model, layout_of(groups), evaluation);
  for (size_t frame = 0; frame < data_.rows_of_frame.size() && still && found; ++frame) {
    const auto& rows = data_.rows_of_frame[frame];
    if (!groups[facts_.group_of_row[rows.front()]]) continue;
    Pose X_CW;
    evaluation.nuisances += 6;
    if (!stored_pose(evaluation.nuisance_values, frame, X_CW))
      count_as_missed(static_cast<int>(frame), evaluation);
  }
  whiten_diagonal(*this, groups, evaluation);
  if (!found) return nullptr;
  adjustment->whiten(evaluation);
  if (scatter) whiten_all_scattered(*scatter, groups, evaluation);
  return adjustment;
}

DrawsKnown PointsProblem::known_from(const Model& model, const Groups& groups) const {
  DrawsKnown known;
  Evaluation evaluation;
  const auto adjustment = adjusted(model, groups, nullptr, nullptr, evaluation);
  if (!adjustment) return known;
  for (const Vec3& d : adjustment->displaced_m()) known.mean_m.emplace_back(d.x, d.y, d.z);
  for (const Eigen::Matrix3d& covariance : adjustment->covariances())
    known.precision.emplace_back(floored_inverse(covariance, 0));
  return known;
}

Evaluation PointsProblem::evaluate_held_out(const Model& model, const Groups& groups) const {
  if (!(effects::target_of(model).scatter_sigma_m > 0)) return evaluate(model, groups, nullptr);
  // Asked for several times of each model that is compared, and dear.
  std::vector<double> key = key_of(model);
  key.insert(key.end(), groups.begin(), groups.end());
  for (size_t i = 0; i < facts_.scalars(); ++i) key.push_back(left_out(i));
  {
    const std::lock_guard lock(recent_mutex_);
    for (const auto& [known, evaluation] : recent_) {
      if (known == key) return evaluation;
    }
  }
  Evaluation evaluation = predict_held_out(model, groups);
  constexpr size_t kKept = 24;
  const std::lock_guard lock(recent_mutex_);
  if (recent_.size() == kKept) recent_.pop_front();
  recent_.emplace_back(std::move(key), evaluation);
  return evaluation;
}

Evaluation PointsProblem::predict_held_out(const Model& model, const Groups& groups) const {
  const Groups others = complement(groups);
  const bool any = std::any_of(others.begin(), others.end(), [](char used) { return used != 0; });
  if (!any) return evaluate(model, groups, nullptr);
  const DrawsKnown known = known_from(model, others);
  Evaluation evaluation = blank();
  if (known.precision.size() != data_.target.names.size()) {
    evaluation.valid = false;
    whiten_diagonal(*this, groups, evaluation);
    return evaluation;
  }
  adjusted(model, groups, nullptr, &known, evaluation);
  return evaluation;
}

Score PointsProblem::score_held_out(const Model& model, const Groups& groups) const {
  return score_of(*this, evaluate_held_out(model, groups));
}

std::vector<std::vector<double>> PointsProblem::jacobian_draws(const Model& model,
                                                               const std::vector<Unknown>& unknowns,
                                                               const Groups& groups,
                                                               const Evaluation& here) const {
  const MovedModels moved(model, unknowns);
  const bool unknown = data_.rig.type() == Rig::Type::unknown;
  const std::optional<FewErrors> scatter = unknown ? scatter_of(model) : std::nullopt;
  const std::vector<double> sigma = scatter ? counted_sigma(*scatter, here) : std::vector<double>();
  const auto adjustment = adjustment_at(model, groups, nullptr, here.nuisance_values, sigma);
  auto columns = adjustment ? adjustment->columns(moved.models, moved.steps)
                            : std::vector<std::vector<double>>();
  // What takes the place of a scattered residual costs half its square: its slope is that of the
  // cost over itself.
  for (size_t i = 0; i < sigma.size() && !columns.empty(); ++i) {
    constexpr double kFlat = 1e-3;
    if (!here.used[i] || std::abs(here.whitened[i]) < kFlat) continue;
    const double slope = here.residual[i] / (sigma[i] * here.whitened[i]);
    for (auto& column : columns) column[i] *= slope;
  }
  columns.resize(unknowns.size());
  for (auto& column : columns) column.resize(here.whitened.size(), 0);
  return columns;
}

}  // namespace seam::measurement
