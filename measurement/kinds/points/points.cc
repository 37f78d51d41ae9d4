// Kind `points`: image positions of known points.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "effects/stages/lens_domain.h"
#include "measurement/fitting/assess.h"
#include "measurement/kinds/kinds.h"
#include "measurement/kinds/points/data/points_gross.h"
#include "measurement/kinds/points/points_predictor.h"
#include "measurement/kinds/points/points_problem.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

// Fewer views tell a lens from their own shapes badly.
constexpr size_t kFewestViewsOfLens = 3;

size_t median_views(const Target& target) {
  std::vector<size_t> views = target.views;
  std::nth_element(views.begin(), views.begin() + views.size() / 2, views.end());
  return views[views.size() / 2];
}

// Whether the camera is known to stand still at every stamp, so that no time of a frame can show.
bool stands_still(const PointsData& data) {
  if (data.rig.type() == Rig::Type::unknown) return false;
  constexpr double kSoon_s = 1e-3, kSame = 1e-9;
  const Rig::Motion motion = data.rig.motion(Model());
  return std::all_of(data.stamp_s.begin(), data.stamp_s.end(), [&](double t) {
    const Pose change = motion.X_WC(t).inverse() * motion.X_WC(t + kSoon_s);
    // The place of a point far away turns with the camera.
    const Vec3 moved = change * Vec3(1.0, 1.0, 1.0) - Vec3(1.0, 1.0, 1.0);
    return glm::length(moved) < kSame && glm::length(change.p) < kSame;
  });
}

std::vector<effects::Lack> lacks_of(const PointsData& data) {
  using effects::Need;
  const Rig& rig = data.rig;
  std::vector<effects::Lack> lacks = {{Need::colour, "points have no colour"}};
  if (rig.type() == Rig::Type::unknown && rig.path() == Rig::Path::still)
    lacks.push_back({Need::known_pose, "the pose of each frame is estimated, which absorbs it"});
  if (rig.type() == Rig::Type::unknown && rig.path() == Rig::Path::constant_velocity)
    lacks.push_back({Need::known_pose,
                     "each frame has a velocity of its own, of which only the product with a "
                     "read-out time shows; motion: spline tells them apart"});
  if (rig.type() == Rig::Type::unknown)
    lacks.push_back({Need::known_scale,
                     "the pose of each frame is estimated: one scale of the whole target is that "
                     "of its distances"});
  if (rig.type() != Rig::Type::chain)
    lacks.push_back({Need::joints, "the camera hangs on no joint"});
  if (rig.cycle_s() == 0)
    lacks.push_back({Need::repeating_motion, "the head's motion does not repeat"});
  if (rig.type() != Rig::Type::unknown) lacks.push_back({Need::unknown_poses, ""});
  if (data.cameras.size() < 2 || rig.type() != Rig::Type::unknown)
    lacks.push_back({Need::several_cameras, ""});
  if (stands_still(data))
    lacks.push_back({Need::moving_view, "the camera stands still while every frame is taken"});
  if (!data.target.flat) lacks.push_back({Need::flat_target, "the points lie in no plane"});
  constexpr size_t kSeveral = 3;
  if (rig.type() == Rig::Type::unknown && rig.path() != Rig::Path::still)
    lacks.push_back(
        {Need::still_views, "how a target bends from view to view is told of still views only"});
  if (median_views(data.target) < kSeveral)
    lacks.push_back({Need::several_views, "most points are seen in fewer than three views"});
  const auto without = [&](const std::string& joint, std::initializer_list<Need> needs) {
    const auto& joints = rig.joint_names();
    if (std::find(joints.begin(), joints.end(), joint) != joints.end()) return;
    for (const Need need : needs) lacks.push_back({need, "the rig has no joint " + joint});
  };
  without("tilt", {Need::tilt_joint, Need::tilt_reversals});
  without("roll", {Need::roll_joint, Need::roll_reversals});
  without("pan", {Need::pan_joint, Need::pan_reversals, Need::pan_turn});
  return lacks;
}

}  // namespace

PointsProblem::PointsProblem(const MeasurementSet& set) : data_(read_points(set, true, facts_)) {
  facts_.fingerprint = set.fingerprint();
  facts_.set.lacks = lacks_of(data_);
  facts_.figures.title = "Camera";
  join_few_views();
  gross_ = gross_errors(data_, facts_);
  state_noise(set);
  state_motion();
}

// One view of a flat target tells two of a camera's numbers and two views four, so that a camera
// fitted to one of two says nothing of the other: parts of both are held out in turn.
void PointsProblem::join_few_views() {
  constexpr size_t kTooFew = 3;
  if (data_.rig.type() != Rig::Type::unknown || data_.rows_of_frame.size() >= kTooFew ||
      facts_.groups.size() < 2)
    return;
  facts_.groups = {"all views"};
  std::fill(facts_.group_of_row.begin(), facts_.group_of_row.end(), 0);
  facts_.notes.push_back(
      "two views: parts of both are held out in turn, since a camera fitted to one of them says "
      "little of the other");
}

void PointsProblem::state_noise(const MeasurementSet& set) {
  const std::array<const char*, 2> names = {"u_px", "v_px"};
  const bool stated =
      data_.sigma_px > 0 || (set.noise.contains("u_px") && set.noise.contains("v_px"));
  for (const char* name : names) {
    const auto known = set.noise.find(name);
    Channel channel{.name = name, .noise = 1, .estimated = !stated};
    if (known != set.noise.end()) channel.noise = known->second, channel.estimated = false;
    if (data_.sigma_px > 0) channel.noise = data_.sigma_px;
    facts_.channels.push_back(channel);
  }
  if (stated) return;
  if (data_.rig.type() == Rig::Type::unknown) {
    take_noise_of_views();
  } else {
    take_noise(estimate_noise_by_directions(data_));
  }
}

void PointsProblem::take_noise(const std::array<double, 2>& sigma) {
  for (size_t c = 0; c < 2; ++c) {
    if (facts_.channels[c].estimated) facts_.channels[c].noise = sigma[c];
  }
}

void PointsProblem::weigh_views(const std::vector<double>& of_view) {
  data_.spread.resize(data_.p_W.size(), 1);
  for (size_t row = 0; row < data_.p_W.size(); ++row) {
    const auto view = static_cast<size_t>(data_.view_of_row[row]);
    const double before = data_.spread_of_view.empty() ? 1 : data_.spread_of_view[view];
    data_.spread[row] *= of_view[view] / before;
  }
  data_.spread_of_view = of_view;
}

// Which views scatter least and most, of these shares of the typical scatter.
std::string PointsProblem::least_and_most(const std::vector<double>& of_view) const {
  const auto [least, most] = std::minmax_element(of_view.begin(), of_view.end());
  const auto told = [&](auto view) {
    const std::vector<int>& rows = data_.rows_of_view[static_cast<size_t>(view - of_view.begin())];
    const int row = rows.front();
    const std::string& camera = data_.cameras[data_.camera_of_row[row]].name;
    return fmt::format("{:.3g} times as much in frame {}{}", *view,
                       data_.frames[data_.frame_of_row[row]],
                       camera.empty() ? "" : " of " + camera);
  };
  return fmt::format("{}, {}", told(least), told(most));
}

// The lesser of two estimates: of the image itself, and of what a camera leaves. Where views
// scatter unlike each counts by its own noise, and both are had again.
void PointsProblem::take_noise_of_views() {
  const auto estimate = [&] {
    PointsNoise least = estimate_views_noise(data_, gross_);
    take_noise(least.sigma);
    const auto seen = seen_by_wide_camera();
    if (!seen) return least;
    PointsNoise better = estimate_views_noise(data_, gross_, &*seen);
    if (better.sigma[0] * better.sigma[1] > least.sigma[0] * least.sigma[1]) return least;
    take_noise(better.sigma);
    return better;
  };
  PointsNoise noise = estimate();
  if (noise.of_view.empty() || !facts_.channels[0].estimated || !facts_.channels[1].estimated)
    return;
  // A view that scatters moves what is told of displaced points, and with it what others leave: the
  // second time it no longer does.
  constexpr int kRounds = 2;
  for (int round = 0; round < kRounds && !noise.of_view.empty(); ++round) {
    weigh_views(noise.of_view);
    noise = estimate();
  }
  facts_.notes.push_back(fmt::format(
      "views scatter unlike, and each counts by its own noise: {}, where {:.3g} and {:.3g} px are "
      "typical",
      least_and_most(data_.spread_of_view), noise.sigma[0], noise.sigma[1]));
}

// What the most flexible lens leaves of still views. What else the user's model may lack only
// bends the image a little.
std::optional<SeenByCamera> PointsProblem::seen_by_wide_camera() const {
  if (data_.rig.type() != Rig::Type::unknown || moves() || data_.cameras.size() > 1 ||
      data_.rows_of_frame.size() < kFewestViewsOfLens)
    return std::nullopt;
  std::vector<std::vector<int>> taken = data_.rows_of_view;
  for (std::vector<int>& rows : taken)
    std::erase_if(rows, [&](int row) { return !takes_part(row); });
  const auto rough = camera_of_views(data_, taken);
  if (!rough) return std::nullopt;
  Model start = rough->model;
  const Model wide = plain_lens(1, /*wide=*/true, data_.camera.width_px, data_.camera.height_px);
  std::vector<Unknown> unknowns;
  for (const effects::ModelEffect& effect : wide.effects()) {
    if (!start.has(effect.definition->name)) start.set(effect.definition, effect.parameters);
    for (size_t i = 0; i < effect.parameters.size(); ++i)
      unknowns.push_back({effect.definition->name, i});
  }
  const Fit found = fit(start, unknowns, all_groups());
  const Evaluation left = evaluate(found.model, all_groups(), nullptr);
  if (!left.valid) return std::nullopt;
  SeenByCamera seen{
      .camera = {.model = found.model,
                 .projection = {found.model, data_.camera.width_px, data_.camera.height_px}},
      .residual_px = left.residual};
  for (const std::vector<int>& rows : data_.rows_of_view) {
    Pose X_CW;
    const bool stored = stored_pose(left.nuisance_values,
                                    static_cast<size_t>(data_.frame_of_row[rows.front()]), X_CW);
    seen.camera.X_CW.push_back(stored ? std::optional(X_CW) : std::nullopt);
  }
  return seen;
}

void PointsProblem::place(const Model& given) {
  const Model model = with_cameras_placed(given, refitted_unknowns(given), all_groups());
  if (on_path() && data_.rig.knot_s() == 0) choose_knots(model);
  const Evaluation evaluation = evaluate(model, all_groups(), nullptr);
  if (evaluation.valid) place_covariates(data_, evaluation.residual, facts_);
}

void PointsProblem::check_model(const Model& model) const {
  check_columns(model, {effects::Stage::geometry, effects::Stage::corner_detector});
  check_cameras(model);
  if (data_.gyroscope) check_offset(model);
  const effects::TargetShape target = effects::target_of(model);
  if (target.motion_sigma_rad > 0 && data_.rig.type() != Rig::Type::unknown)
    throw InputError(
        "the model has a motion of each view of its own (view_motion), and the set says how the "
        "camera moves: expected rig: {pose: unknown}, or rolling_shutter in the place of it");
  if (moves() && (target.flex_sigma_m > 0 || target.focus_sigma > 0 ||
                  target.motion_sigma_rad > 0 || target.has_sway()))
    throw InputError(
        "the model bends, moves or sways the target, or changes the focal length, otherwise in "
        "each view, which only still views show: expected rig: {pose: unknown} without motion, or "
        "a model "
        "without that");
}

bool PointsProblem::groups_are_independent(const Model& model) const {
  return !(effects::target_of(model).scatter_sigma_m > 0) && !on_path();
}

Evaluation PointsProblem::evaluate_plain(const Model& model, const Groups& groups,
                                         const Evaluation* warm) const {
  if (moves()) return evaluate_moving(model, groups, warm);
  return data_.rig.type() == Rig::Type::unknown ? evaluate_unknown(model, groups, warm)
                                                : evaluate_rig(model, groups, warm);
}

Evaluation PointsProblem::evaluate(const Model& model, const Groups& groups,
                                   const Evaluation* warm) const {
  if (!effects::target_of(model).has_draws()) return evaluate_plain(model, groups, warm);
  Evaluation evaluation;
  adjusted(model, groups, warm, nullptr, evaluation);
  return evaluation;
}

std::vector<std::vector<double>> PointsProblem::jacobian(const Model& model,
                                                         const std::vector<Unknown>& unknowns,
                                                         const Groups& groups,
                                                         const Evaluation& here) const {
  if (effects::target_of(model).has_draws()) return jacobian_draws(model, unknowns, groups, here);
  if (moves()) return jacobian_moving(model, unknowns, groups, here);
  if (data_.rig.type() == Rig::Type::unknown)
    return jacobian_unknown(model, unknowns, groups, here);
  return Problem::jacobian(model, unknowns, groups, here);
}

std::vector<std::vector<double>> PointsProblem::following(
    const Model& model, const Groups& groups, const Evaluation& here,
    std::vector<std::vector<double>> columns) const {
  if (effects::target_of(model).has_draws()) return {};
  if (moves()) return following_moving(model, groups, here, std::move(columns));
  if (data_.rig.type() == Rig::Type::unknown)
    return following_unknown(model, groups, here, std::move(columns));
  return Problem::following(model, groups, here, std::move(columns));
}

// Beside the outliers of this model those rows that no model explains. A model that misses most
// points by many times the noise tells nothing of single ones.
std::vector<char> PointsProblem::find_outliers(const Model& model) const {
  constexpr double kUseless = 10;
  std::vector<char> outliers(facts_.scalars(), 0);
  const Evaluation evaluation = evaluate(model, all_groups(), nullptr);
  std::vector<double> sizes;
  for (size_t i = 0; i < facts_.scalars(); ++i)
    sizes.push_back(evaluation.residual[i] / evaluation.sigma[i]);
  if (robust_sigma(std::move(sizes)) < kUseless) outliers = Problem::find_outliers(model);
  for (size_t i = 0; i < outliers.size() && !gross_.empty(); ++i) outliers[i] |= gross_[i];
  return outliers;
}

// The nearest points in the same image.
std::vector<int> PointsProblem::neighbours(size_t row, size_t count) const {
  std::vector<int> near = data_.rows_of_view[data_.view_of_row[row]];
  std::erase(near, static_cast<int>(row));
  const auto distance2 = [&](int other) {
    const double du = data_.u_px[other] - data_.u_px[row], dv = data_.v_px[other] - data_.v_px[row];
    return du * du + dv * dv;
  };
  count = std::min(near.size(), count);
  std::partial_sort(near.begin(), near.begin() + count, near.end(), [&](int a, int b) {
    return std::pair(distance2(a), a) < std::pair(distance2(b), b);
  });
  near.resize(count);
  return near;
}

Evaluation PointsProblem::blank() const {
  Evaluation evaluation;
  evaluation.residual.assign(facts_.scalars(), 0);
  evaluation.sigma.resize(facts_.scalars());
  for (size_t i = 0; i < facts_.scalars(); ++i)
    evaluation.sigma[i] = sigma_of(i / 2, static_cast<int>(i % 2));
  return evaluation;
}

namespace {

std::unique_ptr<Problem> open_points(const MeasurementSet& set) {
  return std::make_unique<PointsProblem>(set);
}

}  // namespace

Kind points_kind() {
  return {.bit = effects::kPoints,
          .observations = {.file = "points",
                           .keys = {"frame", "time_s", "camera", "point"},
                           .measured = {"u_px", "v_px"},
                           .in_image = true},
          .open = [](const MeasurementSet& set, const Instruments&) { return open_points(set); },
          .measure = [](const Model& truth, const MeasurementSet& protocol,
                        const MeasureOptions& options,
                        const Instruments&) { measure_points(truth, protocol, options); },
          .behind_camera = lines_behind_camera};
}

}  // namespace seam::measurement
