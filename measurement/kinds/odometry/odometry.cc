#include "measurement/kinds/odometry/odometry.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "measurement/kinds/series_facts.h"
#include "measurement/numerics/linear_algebra.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

constexpr const char* kChannels[3] = {"x_m", "y_m", "theta_rad"};

// A pose that starts at `start` and has moved to `moved` in the start's own frame.
std::array<double, 3> placed(const std::array<double, 3>& start, const effects::WalkState& moved) {
  const double c = maths::cos(start[2]), s = maths::sin(start[2]);
  return {start[0] + c * moved.x_m - s * moved.y_m, start[1] + s * moved.x_m + c * moved.y_m,
          start[2] + moved.theta_rad};
}

std::array<double, 3> missed(const std::array<double, 3>& seen,
                             const std::array<double, 3>& predicted) {
  return {seen[0] - predicted[0], seen[1] - predicted[1],
          maths::wrap_angle(seen[2] - predicted[2])};
}

// The motion from one state to the next, in the first one's body frame.
effects::WalkState between(const effects::WalkState& from, const effects::WalkState& to) {
  const double c = maths::cos(from.theta_rad), s = maths::sin(from.theta_rad);
  const double dx = to.x_m - from.x_m, dy = to.y_m - from.y_m;
  return {
      .x_m = c * dx + s * dy, .y_m = -s * dx + c * dy, .theta_rad = to.theta_rad - from.theta_rad};
}

}  // namespace

OdometryProblem::OdometryProblem(const MeasurementSet& set) {
  const CsvTable table = set.table("odometry");
  if (table.rows() == 0)
    throw InputError(fmt::format("{}: no rows, expected observations", table.file()));
  runs_ = read_walk_runs(table, set.group, true);
  describe(set, table);
  add_covariates(table, set.group);
  facts_.set.lacks = lacks();
}

void OdometryProblem::describe(const MeasurementSet& set, const CsvTable& table) {
  facts_.set.kind = effects::kOdometry;
  describe_rows(set, table, 3, facts_);
  for (size_t i = 0; i < runs_.size(); ++i)
    add_series(set, table, i, runs_[i].rows, runs_[i].time_s, facts_);
  std::array<double, 3> estimated{};
  bool have_estimate = false;
  for (int channel = 0; channel < 3; ++channel) {
    const auto given = set.noise.find(kChannels[channel]);
    Channel c{.name = kChannels[channel], .estimated = given == set.noise.end()};
    if (c.estimated && !have_estimate) estimated = noise_of_walks(runs_), have_estimate = true;
    c.noise = c.estimated ? estimated[channel] : given->second;
    noise_[channel] = c.noise;
    facts_.channels.push_back(c);
  }
}

void OdometryProblem::add_covariates(const CsvTable& table, const std::string& group_column) {
  const size_t rows = facts_.rows();
  std::vector<double> time(rows), distance(rows), heading(rows), turn(rows), x(rows), y(rows),
      change(rows, 0);
  for (const WalkRun& run : runs_) {
    // By the commands alone, so that no pose's noise is in its covariates.
    const auto path = predict_walk({}, run);
    double changed_s = 0;
    for (size_t k = 0; k < run.rows.size(); ++k) {
      const size_t row = run.rows[k];
      const auto pose = placed(run.pose.front(), path[k]);
      time[row] = run.time_s[k];
      distance[row] = path[k].path_m;
      turn[row] = path[k].theta_rad;
      heading[row] = maths::wrap_angle(pose[2]);
      x[row] = pose[0] - run.pose.front()[0];
      y[row] = pose[1] - run.pose.front()[1];
      change[row] = run.time_s[k] - changed_s;
      const bool changes = k == 0 || run.command[k].vx_mps != run.command[k - 1].vx_mps ||
                           run.command[k].vy_mps != run.command[k - 1].vy_mps ||
                           run.command[k].omega_radps != run.command[k - 1].omega_radps;
      if (changes) changed_s = run.time_s[k];
    }
  }
  // Errors of a step are along or across the body, whatever its heading in the room.
  CombinedChannel along{.name = "along_m", .channel_a = 0, .channel_b = 1};
  CombinedChannel across{.name = "across_m", .channel_a = 0, .channel_b = 1};
  for (const double h : heading) {
    along.weight_a.push_back(maths::cos(h)), along.weight_b.push_back(maths::sin(h));
    across.weight_a.push_back(-maths::sin(h)), across.weight_b.push_back(maths::cos(h));
  }
  facts_.combined = {along, across};
  const auto add = [&](const char* name, Covariate::Type type, std::vector<double> values,
                       bool products) {
    facts_.covariates.push_back({name, type, std::move(values), products});
  };
  add("time", Covariate::Type::smooth, std::move(time), true);
  add("distance", Covariate::Type::smooth, std::move(distance), true);
  add("turn", Covariate::Type::smooth, std::move(turn), true);
  add("heading", Covariate::Type::cyclic, std::move(heading), true);
  add("x_moved", Covariate::Type::smooth, std::move(x), false);
  add("y_moved", Covariate::Type::smooth, std::move(y), false);
  add("time_since_change", Covariate::Type::smooth, std::move(change), false);
  for (const char* name : {"vx_cmd_mps", "vy_cmd_mps", "omega_cmd_radps"}) {
    add(name, Covariate::Type::smooth, table.numbers(name), false);
  }
  for (const std::string& name :
       table.extra_numeric_columns({"run", "time_s", "vx_cmd_mps", "vy_cmd_mps", "omega_cmd_radps",
                                    "x_m", "y_m", "theta_rad", group_column})) {
    facts_.covariates.push_back({name, Covariate::Type::smooth, table.numbers(name), true});
  }
}

// Gauss-Newton for the run's true start (x, y, theta), from its first measured pose.
void OdometryProblem::fit_start(const WalkRun& run, const std::vector<effects::WalkState>& path,
                                Evaluation& evaluation) const {
  std::array<double, 3> start = run.pose.front();
  for (int step = 0; step < 12; ++step) {
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (size_t k = 0; k < run.rows.size(); ++k) {
      const auto here = placed(start, path[k]);
      const auto r = missed(run.pose[k], here);
      for (int channel = 0; channel < 3; ++channel) {
        if (left_out(3 * run.rows[k] + channel)) continue;
        Eigen::Vector3d slope(channel == 0, channel == 1, 1);
        if (channel == 0) slope[2] = -(here[1] - start[1]);
        if (channel == 1) slope[2] = here[0] - start[0];
        const double weight = 1 / (noise_[channel] * noise_[channel]);
        information += weight * slope * slope.transpose();
        right += weight * slope * r[channel];
      }
    }
    const Eigen::Vector3d move = solve_symmetric(information, right);
    if (!move.allFinite()) break;
    for (int i = 0; i < 3; ++i) start[i] += move[i];
    if (move.squaredNorm() < 1e-20) break;
  }
  for (size_t k = 0; k < run.rows.size(); ++k) {
    const auto r = missed(run.pose[k], placed(start, path[k]));
    for (int channel = 0; channel < 3; ++channel) {
      const size_t scalar = 3 * run.rows[k] + channel;
      // Outliers keep their residuals, so that the next look for outliers finds them again.
      evaluation.residual[scalar] = r[channel];
      evaluation.sigma[scalar] = noise_[channel];
      if (left_out(scalar)) continue;
      evaluation.used[scalar] = 1;
      evaluation.whitened[scalar] = r[channel] / noise_[channel];
    }
  }
}

// An extended Kalman filter over the run, one scalar at a time: innovations are white where the
// model is right. The first pose starts it (a flat prior), so that its own innovations are zero.
// Without walk noise it is the same least squares as fit_start, and gives only log det S.
void OdometryProblem::filter(const effects::Locomotion& walk, const WalkRun& run,
                             const std::vector<effects::WalkState>& path,
                             Evaluation& evaluation) const {
  const bool noisy = walk.xy_sigma > 0 || walk.theta_sigma > 0;
  const double q_xy = walk.xy_sigma * walk.xy_sigma, q_theta = walk.theta_sigma * walk.theta_sigma;
  std::array<double, 3> pose = run.pose.front();
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) {
    // A gross first pose tells nothing of the start.
    P(i, i) = left_out(3 * run.rows[0] + i) ? 1e4 : noise_[i] * noise_[i];
  }
  double& log_det = evaluation.log_det[facts_.group_of_row[run.rows[0]]];
  for (size_t k = 0; k < run.rows.size(); ++k) {
    if (k > 0) {
      const auto before = pose;
      pose = placed(pose, between(path[k - 1], path[k]));
      Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
      F(0, 2) = -(pose[1] - before[1]);
      F(1, 2) = pose[0] - before[0];
      const double metres = path[k].path_m - path[k - 1].path_m;
      P = F * P * F.transpose();
      P(0, 0) += q_xy * metres;
      P(1, 1) += q_xy * metres;
      P(2, 2) += q_theta * metres;
    }
    for (int channel = 0; channel < 3; ++channel) {
      const size_t scalar = 3 * run.rows[k] + channel;
      double innovation = run.pose[k][channel] - pose[channel];
      if (channel == 2) innovation = maths::wrap_angle(innovation);
      const double variance = P(channel, channel) + noise_[channel] * noise_[channel];
      if (left_out(scalar)) {
        if (noisy)
          evaluation.residual[scalar] = innovation, evaluation.sigma[scalar] = std::sqrt(variance);
        continue;
      }
      if (k > 0) log_det += std::log(variance);
      if (noisy) {
        evaluation.used[scalar] = 1;
        evaluation.residual[scalar] = k == 0 ? 0 : innovation;
        evaluation.sigma[scalar] = std::sqrt(variance);
        evaluation.whitened[scalar] = k == 0 ? 0 : innovation / std::sqrt(variance);
      }
      if (k == 0) continue;
      const Eigen::Vector3d gain = P.col(channel) / variance;
      for (int i = 0; i < 3; ++i) pose[i] += gain[i] * innovation;
      P -= gain * P.row(channel);
      P = 0.5 * (P + P.transpose().eval());
    }
  }
}

Evaluation OdometryProblem::evaluate(const Model& model, const Groups& groups,
                                     const Evaluation*) const {
  const effects::Locomotion walk = effects::locomotion_of(model);
  Evaluation evaluation;
  const size_t n = facts_.scalars();
  evaluation.used.assign(n, 0);
  evaluation.residual.assign(n, 0);
  evaluation.whitened.assign(n, 0);
  evaluation.sigma.assign(n, 1);
  evaluation.log_det.assign(facts_.groups.size(), 0);
  const bool noisy = walk.xy_sigma > 0 || walk.theta_sigma > 0;
  for (const WalkRun& run : runs_) {
    if (!groups[facts_.group_of_row[run.rows[0]]]) continue;
    const auto path = predict_walk(walk, run);
    for (const effects::WalkState& state : path) {
      evaluation.valid &=
          std::isfinite(state.x_m) && std::isfinite(state.y_m) && std::isfinite(state.theta_rad);
    }
    if (!evaluation.valid) return evaluation;
    if (!noisy) fit_start(run, path, evaluation);
    filter(walk, run, path, evaluation);
    evaluation.nuisances += 3;
  }
  return evaluation;
}

std::vector<effects::Lack> OdometryProblem::lacks() const {
  using effects::Need;
  const auto ever = [&](auto quantity) {
    for (const WalkRun& run : runs_) {
      for (const auto& command : run.command) {
        if (quantity(command) != 0) return true;
      }
    }
    return false;
  };
  std::vector<effects::Lack> lacks;
  if (!ever([](const BodyVelocity& v) { return v.vx_mps; }))
    lacks.push_back({Need::forward_walk, "the body never walks forward"});
  if (!ever([](const BodyVelocity& v) { return v.vy_mps; }))
    lacks.push_back({Need::sideways_walk, "the body never walks sideways"});
  if (!ever([](const BodyVelocity& v) { return v.omega_radps; }))
    lacks.push_back({Need::turning, "the body never turns"});
  if (!ever([](const BodyVelocity& v) { return std::abs(v.vx_mps) + std::abs(v.vy_mps); }))
    lacks.push_back({Need::path, "the body never walks"});
  return lacks;
}

void OdometryProblem::check_model(const Model&) const {}

Kind odometry_kind() {
  return {.bit = effects::kOdometry,
          .observations = {.file = "odometry",
                           .keys = {"run", "time_s"},
                           .measured = {"x_m", "y_m", "theta_rad"}},
          .open = [](const MeasurementSet& set, const Instruments&) -> std::unique_ptr<Problem> {
            return std::make_unique<OdometryProblem>(set);
          },
          .measure = [](const Model& truth, const MeasurementSet& protocol,
                        const MeasureOptions& options,
                        const Instruments&) { measure_odometry(truth, protocol, options); }};
}

}  // namespace seam::measurement
