#include "measurement/kinds/odometry/odometry.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "effects/questions.h"
#include "measurement/kinds/series_facts.h"
#include "measurement/numerics/parallel_for.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {

From::From(const WalkPose& start)
    : start_(start), cosine_(maths::cos(start[2])), sine_(maths::sin(start[2])) {}

WalkPose From::operator()(const WalkPose& moved) const {
  return {start_[0] + cosine_ * moved[0] - sine_ * moved[1],
          start_[1] + sine_ * moved[0] + cosine_ * moved[1], start_[2] + moved[2]};
}

WalkPose missed(const WalkPose& seen, const WalkPose& predicted) {
  return {seen[0] - predicted[0], seen[1] - predicted[1],
          std::isnan(seen[2]) ? seen[2] : maths::wrap_angle(seen[2] - predicted[2])};
}

effects::WalkState between(const effects::WalkState& from, const effects::WalkState& to) {
  const double c = maths::cos(from.theta_rad), s = maths::sin(from.theta_rad);
  const double dx = to.x_m - from.x_m, dy = to.y_m - from.y_m;
  return {{.x_m = c * dx + s * dy,
           .y_m = -s * dx + c * dy,
           .theta_rad = to.theta_rad - from.theta_rad}};
}

OdometryProblem::OdometryProblem(const MeasurementSet& set) {
  const CsvTable table = set.table("odometry");
  if (table.rows() == 0)
    throw InputError(fmt::format("{}: no rows, expected observations", table.file()));
  ticks_ = has_ticks(table);
  size_t repeated = 0;
  runs_ = read_walk_runs(table, set.group, true, &repeated);
  check_ticks(table, runs_);
  // So many paths of each run are kept as memory allows.
  constexpr size_t kRowsKept = 1'000'000;
  paths_.emplace(runs_.size(), std::clamp<size_t>(kRowsKept / table.rows(), 2, 8));
  starts_.emplace(runs_.size());
  describe(set, table);
  if (repeated > 0)
    facts_.notes.push_back(
        fmt::format("{} of {} rows say the time of the row before them again: the first counts",
                    repeated, table.rows()));
  // Ticks mean nothing without a model: their covariates follow with it.
  if (!ticks_) add_covariates({});
  facts_.set.lacks = lacks({});
}

void OdometryProblem::describe(const MeasurementSet& set, const CsvTable& table) {
  facts_.set.kind = effects::kOdometry;
  describe_rows(set, table, 0, facts_);
  for (size_t i = 0; i < runs_.size(); ++i)
    add_series(set, table, i, runs_[i].rows, runs_[i].time_s, facts_);
  scalars_.assign(table.rows(), {-1, -1, -1});
  std::array<double, 3> estimated{};
  bool have_estimate = false;
  for (int channel = 0; channel < 3; ++channel) {
    const bool any = std::any_of(runs_.begin(), runs_.end(), [&](const WalkRun& run) {
      return std::any_of(run.pose.begin(), run.pose.end(),
                         [&](const WalkPose& pose) { return !std::isnan(pose[channel]); });
    });
    if (!any) continue;
    const auto given = set.noise.find(kPoseColumns[channel]);
    const bool estimated_here = given == set.noise.end();
    Channel c{
        .name = kPoseColumns[channel], .estimated = estimated_here, .correctable = estimated_here};
    if (c.estimated && !have_estimate) estimated = noise_of_walks(runs_), have_estimate = true;
    c.noise = c.estimated ? estimated[channel] : given->second;
    channel_of_pose_[channel] = static_cast<int>(facts_.channels.size());
    facts_.channels.push_back(c);
  }
  std::vector<const WalkPose*> pose_of_row(table.rows(), nullptr);
  for (const WalkRun& run : runs_) {
    for (size_t k = 0; k < run.rows.size(); ++k) pose_of_row[run.rows[k]] = &run.pose[k];
  }
  for (size_t row = 0; row < table.rows(); ++row) {
    for (int channel = 0; channel < 3 && pose_of_row[row] != nullptr; ++channel) {
      if (std::isnan((*pose_of_row[row])[channel])) continue;
      scalars_[row][channel] = static_cast<int>(facts_.scalars());
      facts_.row_of.push_back(static_cast<int>(row));
      facts_.channel_of.push_back(channel_of_pose_[channel]);
    }
  }
  for (const char* name : kCommandColumns) {
    if (!ticks_) columns_.push_back({name, Covariate::Type::smooth, table.numbers(name), false});
  }
  std::ranges::move(table.incomplete_columns(walk_columns(set.group)),
                    std::back_inserter(facts_.notes));
  const effects::FurtherColumns& further = *runs_.front().further;
  for (size_t c = 0; c < further.names.size(); ++c)
    columns_.push_back({further.names[c], Covariate::Type::smooth, further.values[c], true});
}

Evaluation OdometryProblem::evaluate(const Model& model, const Groups& groups,
                                     const Evaluation*) const {
  return evaluate_walks(model, groups, nullptr);
}

Evaluation OdometryProblem::evaluate_walks(const Model& model, const Groups& groups,
                                           const Stretch* stretch) const {
  const effects::Locomotion walk = effects::locomotion_of(model);
  const effects::Timing timing = effects::timing_of(model);
  Evaluation evaluation;
  const size_t n = facts_.scalars();
  evaluation.used.assign(n, 0);
  evaluation.residual.assign(n, 0);
  evaluation.whitened.assign(n, 0);
  evaluation.sigma.assign(n, 1);
  evaluation.log_det.assign(facts_.groups.size(), 0);
  const bool noisy = walk.xy_sigma > 0 || walk.theta_sigma > 0;
  const std::vector<effects::MovingNoise> noise = effects::noise_of(model).pose;
  const std::vector<double> mean = mean_parameters(model);
  // What a run's start is fitted by, beside the path: sigmas and rows that are left out.
  std::vector<double> key = mean;
  key.push_back(static_cast<double>(times_marked()));
  for (const effects::MovingNoise& pose : noise)
    key.insert(key.end(), {pose.xy_sigma_m, pose.theta_sigma_rad, pose.per_mps, pose.per_radps});
  // Runs may be an hour long: each is a job of its own, and adds to its group in their order.
  struct Share {
    bool valid = true;
    double log_det = 0;
    int unknowns = 0;
  };
  std::vector<Share> shares(runs_.size());
  const auto walk_run = [&](size_t i) {
    const WalkRun& run = runs_[i];
    if (!groups[facts_.group_of_row[run.rows[0]]]) return;
    auto kept = paths_->of(i, mean, [&] { return walked_by(walk, run, timing); });
    if (stretch != nullptr) kept = std::make_shared<const Walked>(stretched(*kept, run, *stretch));
    const std::vector<effects::WalkState>& path = kept->path;
    for (const effects::WalkState& state : path) {
      shares[i].valid &=
          std::isfinite(state.x_m) && std::isfinite(state.y_m) && std::isfinite(state.theta_rad);
    }
    if (!shares[i].valid) return;
    const PoseSigmas sigma = pose_sigmas(noise, noise_of_set(), run, path);
    // A filter begins at the first pose, and needs a start only where that is not whole.
    const bool filtered = noisy || !kept->counted.empty();
    const auto fitted = [&] { return fit_start(run, run.rows.size(), path, sigma); };
    const Start start = filtered && is_whole(run, 0) ? Start{.unknowns = 3}
                        : stretch != nullptr         ? fitted()
                                                     : *starts_->of(i, key, fitted);
    shares[i].unknowns = start.unknowns;
    if (filtered) {
      shares[i].log_det = filter(walk, run, start, *kept, sigma, evaluation);
    } else {
      take_start(run, start.pose, path, sigma, evaluation);
      shares[i].log_det = start.log_det;
    }
  };
  constexpr size_t kWorthThreads = 10'000;
  parallel_for(runs_.size(), walk_run, facts_.rows() > kWorthThreads);
  for (size_t i = 0; i < runs_.size(); ++i) {
    evaluation.valid &= shares[i].valid;
    evaluation.log_det[facts_.group_of_row[runs_[i].rows[0]]] += shares[i].log_det;
    evaluation.nuisances += shares[i].unknowns;
  }
  return evaluation;
}

OdometryProblem::Walked OdometryProblem::walked_by(const effects::Locomotion& walk,
                                                   const WalkRun& run,
                                                   const effects::Timing& timing) const {
  Walked walked{.path = predict_walk(walk, run, timing, ticks_as(walk))};
  walked.steps.resize(walked.path.size());
  for (size_t k = 1; k < walked.path.size(); ++k) {
    const effects::WalkState step = between(walked.path[k - 1], walked.path[k]);
    walked.steps[k] = {step.x_m, step.y_m, step.theta_rad};
  }
  if (ticks_as(walk) == Ticks::rolled) walked.counted = count_errors(run, timing);
  return walked;
}

std::vector<effects::Lack> OdometryProblem::lacks(const effects::Wheels& wheels) const {
  using effects::Need;
  const auto ever = [&](auto quantity) {
    return std::any_of(runs_.begin(), runs_.end(), [&](const WalkRun& run) {
      return std::any_of(run.command.begin(), run.command.end(),
                         [&](const BodyVelocity& v) { return quantity(v) != 0; }) ||
             std::any_of(run.ticks.begin(), run.ticks.end(), [&](const auto& ticks) {
               const effects::Wheels unit{.metres_per_tick = 1};
               return quantity(unit.velocity_of_ticks(ticks[0], ticks[1], 1)) != 0;
             });
    });
  };
  std::vector<effects::Lack> lacks;
  // Without a reason: what has no wheels needs no word of them.
  if (ticks_) {
    lacks.push_back({Need::commanded_walk, ""});
  } else if (!wheels.driven) {
    lacks.push_back({Need::wheels, ""});
  }
  const bool forward = ever([](const BodyVelocity& v) { return v.vx_mps; });
  const bool turns = ever([](const BodyVelocity& v) { return v.omega_radps; });
  const bool moves =
      ever([](const BodyVelocity& v) { return std::abs(v.vx_mps) + std::abs(v.vy_mps); });
  if (!forward) lacks.push_back({Need::forward_walk, "the body never walks forward"});
  if (!ever([](const BodyVelocity& v) { return v.vy_mps; }))
    lacks.push_back({Need::sideways_walk, "the body never walks sideways"});
  if (!turns) lacks.push_back({Need::turning, "the body never turns"});
  const bool both_ways = ever([](const BodyVelocity& v) { return v.omega_radps > 0; }) &&
                         ever([](const BodyVelocity& v) { return v.omega_radps < 0; });
  if (!both_ways)
    lacks.push_back({Need::both_turns, "the body never turns to the left and to the right"});
  if (!moves) lacks.push_back({Need::path, "the body never walks"});
  if (!moves && !turns) lacks.push_back({Need::moving_view, "the body never moves"});
  return lacks;
}

void OdometryProblem::place(const Model& given) {
  const effects::Locomotion walk = effects::locomotion_of(given);
  facts_.set.lacks = lacks(walk.wheels);
  if (ticks_) add_covariates(walk);
}

std::vector<Groups> OdometryProblem::regimes() const {
  std::vector<Groups> regimes = Problem::regimes();
  std::array<Groups, 8> shown;
  shown.fill(Groups(facts_.groups.size(), 0));
  for (const WalkRun& run : runs_) {
    const auto group = static_cast<size_t>(facts_.group_of_row[run.rows.front()]);
    const auto show = [&](size_t which, double value) {
      if (value != 0) shown[2 * which + (value < 0)][group] = 1;
    };
    for (const BodyVelocity& command : run.command)
      show(0, command.vx_mps), show(1, command.vy_mps), show(2, command.omega_radps);
    double turn_ticks = 0;
    for (const auto& [left, right] : run.ticks) turn_ticks += right - left;
    show(3, turn_ticks);
  }
  regimes.insert(regimes.end(), shown.begin(), shown.end());
  return regimes;
}

void OdometryProblem::check_model(const Model& model) const {
  check_columns(model, {effects::Stage::locomotion});
  using effects::Base;
  const effects::ModelEffect* wheels = effects::base_of(model, Base::wheels);
  if (ticks_ && wheels == nullptr)
    throw InputError(fmt::format(
        "{} counts ticks of wheels (columns {} and {}), expected a model with {}: "
        "{{metres_per_tick: ..., base_m: ...}}",
        facts_.file, kTickColumns[0], kTickColumns[1], effects::base_name(Base::wheels)));
  if (const effects::ModelEffect* walk = effects::base_of(model, Base::walk);
      wheels != nullptr && walk != nullptr)
    throw InputError(
        fmt::format("model '{}' has {} and {}, expected one of them: each says how "
                    "the body moves",
                    model.name(), walk->definition->name, wheels->definition->name));
}

Kind odometry_kind() {
  return {.bit = effects::kOdometry,
          .observations = {.file = "odometry",
                           .keys = {"run", "time_s"},
                           .measured = {"x_m", "y_m", "theta_rad"}},
          .rows_follow_time = true,
          .open = [](const MeasurementSet& set, const Instruments&) -> std::unique_ptr<Problem> {
            return std::make_unique<OdometryProblem>(set);
          },
          .measure = [](const Model& truth, const MeasurementSet& protocol,
                        const MeasureOptions& options,
                        const Instruments&) { measure_odometry(truth, protocol, options); }};
}

}  // namespace seam::measurement
