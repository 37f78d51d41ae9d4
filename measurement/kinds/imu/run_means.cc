#include "measurement/kinds/imu/run_means.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "measurement/kinds/imu/imu.h"
#include "measurement/numerics/regression.h"
#include "measurement/problem/neighbour.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

// A walk goes on between runs, and the power of flicker noise grows by as much with each octave.
double variance_of(const RunMean& run, const SlowNoise& slow, double middle_s) {
  const double apart_s = std::abs(run.middle_s - middle_s);
  const double longer = run.lasts_s > 0 ? std::log1p(apart_s / run.lasts_s) : 0;
  return run.variance + slow.walk * slow.walk * apart_s +
         slow.flicker * slow.flicker / maths::kPi * longer;
}

}  // namespace

RunsApart runs_apart(const std::vector<RunMean>& means, const SlowNoise& slow, double lines) {
  const auto n = static_cast<double>(means.size());
  if (means.size() < 2) return {};
  double middle_s = 0;
  for (const RunMean& run : means) middle_s += run.middle_s / n;
  double weights = 0, mean = 0;
  for (const RunMean& run : means) {
    const double weight = 1 / variance_of(run, slow, middle_s);
    weights += weight, mean += weight * run.value;
  }
  mean /= weights;
  double chi2 = 0, square = 0, noise = 0;
  for (const RunMean& run : means) {
    const double off = run.value - mean, variance = variance_of(run, slow, middle_s);
    chi2 += off * off / variance;
    square += off * off / (n - 1), noise += variance / n;
  }
  return {.p_value = f_tail(chi2 / (n - 1), n - 1, n * lines),
          .rms = std::sqrt(std::max(0.0, square - noise))};
}

// Seen along one direction, gravity says nothing of bias and scale: the size of the force is
// compared from run to run alone.
void ImuProblem::compare_forces(const Groups& groups, Evaluation& evaluation) const {
  double weights = 0, mean = 0;
  const auto takes_part = [&](size_t i) {
    return rows_[i].what == Row::What::gravity && !left_out(i) &&
           groups[static_cast<size_t>(facts_.group_of_row[i])];
  };
  for (size_t i = 0; i < rows_.size(); ++i) {
    if (!takes_part(i)) continue;
    const double weight = 1 / (rows_[i].sigma * rows_[i].sigma);
    weights += weight, mean += weight * evaluation.residual[i];
  }
  if (!(weights > 0)) return;
  for (size_t i = 0; i < rows_.size(); ++i)
    if (takes_part(i)) evaluation.residual[i] -= mean / weights;
}

// Runs in which the sensor turns or lies otherwise say first what that makes of its means.
bool ImuProblem::compares_runs(const Row& row) const {
  if (row.what == Row::What::gravity) return !attitudes_;
  return row.what == Row::What::mean && (row.axis < 3 ? !turns() : !attitudes_);
}

// By channel: residuals of each run as one mean.
std::map<int, ImuProblem::ChannelOfRuns> ImuProblem::means_of_runs(const Evaluation& here) const {
  std::map<int, ChannelOfRuns> channels;
  for (size_t i = 0; i < rows_.size(); ++i) {
    if (!here.used[i] || !compares_runs(rows_[i])) continue;
    const ImuStretch& stretch = data_.stretches[rows_[i].stretch];
    const double lasts_s = stretch.dt_s * static_cast<double>(stretch.rows.size());
    const double weight = 1 / (rows_[i].sigma * rows_[i].sigma);
    ChannelOfRuns& channel = channels[facts_.channel_of[i]];
    channel.axis = rows_[i].axis;
    channel.rows += 1, channel.squares += here.residual[i] * here.residual[i];
    RunMean& run = channel.runs[stretch.group];
    const double before = run.variance > 0 ? 1 / run.variance : 0, sum = before + weight;
    run.value = (before * run.value + weight * here.residual[i]) / sum;
    run.middle_s = (before * run.middle_s + weight * (stretch.start_s + 0.5 * lasts_s)) / sum;
    run.variance = 1 / sum;
    run.lasts_s = std::max(run.lasts_s, lasts_s);
  }
  return channels;
}

std::vector<Structure> ImuProblem::runs_that_differ(const Model& model,
                                                    const Evaluation& here) const {
  const effects::Inertial inertial = effects::inertial_of(model);
  const std::map<int, ChannelOfRuns> channels = means_of_runs(here);
  std::vector<Structure> found;
  for (const auto& [number, channel] : channels) {
    std::vector<RunMean> means;
    for (const auto& [name, run] : channel.runs) means.push_back(run);
    const effects::InertialSensor& by = sensor(inertial, channel.axis);
    const SlowNoise slow = {by.walk[channel.axis % 3], by.flicker[channel.axis % 3]};
    const RunsApart apart = runs_apart(means, slow, static_cast<double>(kLeastLines));
    const double p = corrected(apart.p_value, static_cast<double>(channels.size()));
    if (p > kLeastSure || !(apart.rms > 0)) continue;
    found.push_back(
        {.residual = facts_.channels[static_cast<size_t>(number)].name,
         .moment = "mean",
         .covariate = kEachRun,
         .strength = apart.rms,
         .p_value = std::max(p, kLeastP),
         .explained = std::min(1.0, channel.rows * apart.rms * apart.rms / channel.squares)});
  }
  return found;
}

std::vector<Structure> ImuProblem::structure(const Model& model, const Groups& groups,
                                             int fitted) const {
  std::vector<Structure> all = Problem::structure(model, groups, fitted);
  const std::vector<Structure> apart = runs_that_differ(model, evaluate(model, groups));
  const auto with_more_reason = [&](const Structure& run) {
    constexpr double kMost = 0.5;  // Of the residual: what explains more is the cause itself.
    return many_runs() && std::any_of(all.begin(), all.end(), [&](const Structure& s) {
             return s.residual == run.residual && s.moment == "mean" && s.explained > kMost;
           });
  };
  std::vector<Structure> named;
  std::copy_if(apart.begin(), apart.end(), std::back_inserter(named),
               [&](const Structure& run) { return !with_more_reason(run); });
  // A few means lie on many functions.
  std::erase_if(all, [&](const Structure& s) {
    return std::any_of(named.begin(), named.end(),
                       [&](const Structure& run) { return run.residual == s.residual; });
  });
  all.insert(all.end(), named.begin(), named.end());
  strongest_first(facts_, all);
  return all;
}

}  // namespace seam::measurement
