// Where causes without a name may act on a servo: on the angle that its log shows, and on the
// torque that moves it, whose functions reach all later angles.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <tuple>
#include <utility>

#include "effects/questions.h"
#include "effects/stages/noise.h"
#include "measurement/kinds/joints/joints.h"
#include "measurement/numerics/parallel_for.h"

namespace seam::measurement {
namespace {

using Values = std::vector<double>;

// What small changes at a row, of angle and rate, and a push until the next row make of both there.
struct Response {
  double q_of_q = 0, q_of_w = 0, q_of_push = 0;
  double w_of_q = 0, w_of_w = 0, w_of_push = 0;
};
// A log's rows, and the response between each and the next.
struct PushedLog {
  const std::vector<size_t>* rows = nullptr;
  std::vector<Response> responses;
};

// By how much angle and rate at `t_s` differ for a joint that goes on from a nudge.
std::pair<double, double> change_after(const effects::Servo& joint, const effects::Servo& as_it_is,
                                       double t_s, double rad, double radps, double rad_per_s2) {
  effects::Servo nudged = joint;
  nudged.nudge(rad, radps, rad_per_s2);
  nudged.advance_to(t_s);
  const double by = rad + radps + rad_per_s2;  // One of them.
  return {(nudged.state().motor_rad - as_it_is.state().motor_rad) / by,
          (nudged.state().motor_radps - as_it_is.state().motor_radps) / by};
}

Response response_until(const effects::Servo& joint, double dt_s, double t_s, double by_rad) {
  effects::Servo as_it_is = joint;
  as_it_is.advance_to(t_s);
  Response r;
  std::tie(r.q_of_q, r.w_of_q) = change_after(joint, as_it_is, t_s, by_rad, 0, 0);
  std::tie(r.q_of_w, r.w_of_w) = change_after(joint, as_it_is, t_s, 0, by_rad / dt_s, 0);
  std::tie(r.q_of_push, r.w_of_push) =
      change_after(joint, as_it_is, t_s, 0, 0, by_rad / (dt_s * dt_s));
  return r;
}

// The same, and what a command that acts between makes of both if it acts later, by the time and by
// its square.
DrivenStep step_until(const effects::Servo& joint, double dt_s, double t_s, double by_rad) {
  constexpr double kShift = 0.05;  // Of the time between rows.
  effects::Servo as_it_is = joint;
  as_it_is.advance_to(t_s);
  DrivenStep step;
  std::tie(step.q_of_q, step.w_of_q) = change_after(joint, as_it_is, t_s, by_rad, 0, 0);
  std::tie(step.q_of_w, step.w_of_w) = change_after(joint, as_it_is, t_s, 0, by_rad / dt_s, 0);
  const double acts_s = joint.last_acting(t_s);
  if (!std::isfinite(acts_s)) return step;
  // Towards where it still acts before the row.
  const double by_s = acts_s + 2 * kShift * dt_s < t_s ? kShift * dt_s : -kShift * dt_s;
  const auto shifted = [&](double shift_s) {
    effects::Servo moved = joint;
    moved.shift_commands(acts_s, shift_s);
    moved.advance_to(t_s);
    return std::pair(moved.state().motor_rad - as_it_is.state().motor_rad,
                     moved.state().motor_radps - as_it_is.state().motor_radps);
  };
  const auto once = shifted(by_s), twice = shifted(2 * by_s);
  step.q_of_draw = (4 * once.first - twice.first) / (2 * by_s);
  step.w_of_draw = (4 * once.second - twice.second) / (2 * by_s);
  step.q_of_square = (twice.first - 2 * once.first) / (2 * by_s * by_s);
  step.w_of_square = (twice.second - 2 * once.second) / (2 * by_s * by_s);
  return step;
}

// Pushes at the rows become the changes of angle that they make, from where each log starts.
void push(const std::vector<PushedLog>& logs, Values& column) {
  for (const PushedLog& log : logs) {
    double q = 0, w = 0;
    for (size_t k = 0; k < log.rows->size(); ++k) {
      const double here = std::exchange(column[(*log.rows)[k]], q);
      if (k == log.responses.size()) break;
      const Response& r = log.responses[k];
      const double mean = 0.5 * (here + column[(*log.rows)[k + 1]]);
      const double moved = r.q_of_q * q + r.q_of_w * w + r.q_of_push * mean;
      w = r.w_of_q * q + r.w_of_w * w + r.w_of_push * mean;
      q = moved;
    }
  }
}

// The same functions as a torque, which may depend on time, too.
FieldPlace torque_place(const FieldPlace& angle, std::vector<PushedLog> logs,
                        const std::vector<Covariate>& covariates) {
  FieldPlace place = angle;
  std::copy_if(covariates.begin(), covariates.end(), std::back_inserter(place.covariates),
               [](const Covariate& covariate) { return covariate.name == "time"; });
  // A constant one moves the angle by the noise.
  Values constant = place.slopes[0];
  push(logs, constant);
  double sum2 = 0, count = 0;
  for (size_t i = 0; i < constant.size(); ++i)
    sum2 += constant[i] * constant[i], count += place.slopes[0][i];
  if (!(sum2 > 0)) return {};
  const double unit = std::sqrt(count / sum2);
  place.arrives = [logs = std::move(logs), unit](Values& column) {
    push(logs, column);
    for (double& value : column) value *= unit;
  };
  return place;
}

}  // namespace

std::vector<FieldPlace> JointsProblem::field_places(const Model& model,
                                                    const Evaluation& here) const {
  const size_t rows = facts_.rows();
  const effects::ServoModel servo = effects::servo_of(model);
  const bool pushed = servo.torque.present && !servo.elastic.present();
  std::map<std::string, FieldPlace> places;  // By joint.
  std::map<std::string, std::vector<PushedLog>> logs_of;
  std::vector<PushedLog> logs(set_.logs.size());
  const double noise_rad = facts_.channels[0].noise;
  parallel_for(pushed ? logs.size() : 0, [&](size_t i) {
    const JointLog& log = set_.logs[i];
    const double* start = &here.nuisance_values.at(kStartValues * i);
    logs[i].rows = &log.rows;
    predict_joint_log(
        model, set_, log, log.measured_rad.front() + start[0], log.start_radps + start[1],
        [&](size_t k, const effects::Servo& joint) {
          if (k + 1 == log.rows.size()) return;
          logs[i].responses.push_back(response_until(joint, log.time_s[k + 1] - log.time_s[k],
                                                     log.time_s[k + 1], noise_rad));
        });
  });
  for (size_t i = 0; i < set_.logs.size(); ++i) {
    const JointLog& log = set_.logs[i];
    Values predicted_rad;
    for (size_t k = 0; k < log.rows.size(); ++k)
      predicted_rad.push_back(log.measured_rad[k] - here.residual[log.rows[k]]);
    FieldPlace& place = places[log.joint];
    if (place.slopes.empty()) {
      // Rows of other joints, on which it does not act, count with a value within its range.
      place.slopes = {Values(facts_.scalars(), 0)};
      place.covariates = {{.name = log.joint, .values = Values(rows, predicted_rad[0])},
                          {.name = log.joint + "_rate", .values = Values(rows, 0)}};
    }
    for (size_t k = 0; k < log.rows.size(); ++k) {
      const size_t row = log.rows[k];
      const double slope = parabola_around(log.time_s, predicted_rad, k).slope;
      place.slopes[0][row] = 1;
      place.covariates[0].values[row] = predicted_rad[k];
      place.covariates[1].values[row] = std::isfinite(slope) ? slope : 0;
    }
    if (pushed) logs_of[log.joint].push_back(std::move(logs[i]));
  }
  std::vector<FieldPlace> all;
  for (const auto& [joint, place] : places) all.push_back(place);
  for (auto& [joint, pushed_logs] : logs_of) {
    all.push_back(torque_place(places[joint], std::move(pushed_logs), facts_.covariates));
    if (all.back().slopes.empty()) all.pop_back();  // Nothing moves it.
  }
  return all;
}

std::string why_late_commands_hide(const Model& model) {
  if (!(effects::noise_of(model).command_sigma_s > 0)) return "";
  const effects::ServoModel servo = effects::servo_of(model);
  if (servo.elastic.present())
    return "command_jitter takes no part: of an elastic joint angle and rate are not the whole "
           "state";
  const bool at_once = !servo.torque.present && servo.tau_s == 0 && std::isinf(servo.rad_per_s) &&
                       std::isinf(servo.rad_per_s2);
  return at_once ? "command_jitter shows nothing: this servo is at its command at once, and a log "
                   "does not say when between two rows that was (servo_lag, speed_limit, "
                   "acceleration_limit and motor_servo take time)"
                 : "";
}

JointsProblem::LateSteps JointsProblem::late_steps(const Model& model,
                                                   const std::vector<size_t>& used,
                                                   const Evaluation& here) const {
  const double noise_rad = facts_.channels[0].noise;
  LateSteps steps(used.size());
  parallel_for(used.size(), [&](size_t at) {
    const JointLog& log = set_.logs[used[at]];
    const double* start = &here.nuisance_values.at(kStartValues * at);
    Values key = mean_parameters(model);
    key.insert(key.end(), {start[0], start[1]});
    steps[at] = late_steps_->of(used[at], key, [&] {
      std::vector<DrivenStep> made;
      predict_joint_log(model, set_, log, log.measured_rad.front() + start[0],
                        log.start_radps + start[1], [&](size_t k, const effects::Servo& joint) {
                          if (k + 1 < log.rows.size())
                            made.push_back(step_until(joint, log.time_s[k + 1] - log.time_s[k],
                                                      log.time_s[k + 1], noise_rad));
                        });
      return made;
    });
  });
  return steps;
}

// Of an elastic joint angle and rate are not the whole state: there the time of commands shows
// nothing. Where a log starts was fitted as if all errors were white: among these it is one of the
// states, measured by the first row, and known near there.
void JointsProblem::whiten_late_commands(const Model& model, const effects::Noise& noise,
                                         const Groups& groups, Evaluation& evaluation) const {
  if (effects::servo_of(model).elastic.present()) return;
  const double noise_rad = facts_.channels[0].noise;
  const std::vector<size_t> used = used_logs(groups);
  // What a command's time makes of a motor's angle takes six times what the angle does: as the
  // starts of logs, it is that of a fit's last look.
  auto steps = std::static_pointer_cast<const LateSteps>(evaluation.reusable);
  if (!steps || steps->empty())
    steps = std::make_shared<const LateSteps>(late_steps(model, used, evaluation));
  if (evaluation.reusable) evaluation.reusable = steps;
  for (size_t at = 0; at < used.size(); ++at) {
    const JointLog& log = set_.logs[used[at]];
    const double* start = &evaluation.nuisance_values.at(kStartValues * at);
    const DrivenStart off{-start[0], kFarthestStart * kFarthestStart * noise_rad * noise_rad};
    whiten_driven(facts_, log.rows, log.time_s, *(*steps)[at], off, noise.command_sigma_s,
                  noise.joint, evaluation);
    // In place of how often over the rows tell the start.
    evaluation.log_det[facts_.group_of(log.rows[0])] -= start[2] + 2 * std::log(kFarthestStart);
  }
}

// An error that wanders is whitened in a column as it is in the residuals: a function of what the
// joint does is separated from it.
std::vector<std::vector<double>> JointsProblem::following(
    const Model& model, const Groups& groups, const Evaluation& here,
    std::vector<std::vector<double>> columns) const {
  const effects::Noise noise = effects::noise_of(model);
  const auto [sigma, rounded] = reading_of(model);
  if (noise.command_sigma_s > 0) return {};
  if (noise.joint.empty() || rounded)
    return Problem::following(model, groups, here, std::move(columns));
  Evaluation made;
  for (std::vector<double>& column : columns) {
    made.residual = std::move(column);
    for (size_t i = 0; i < made.residual.size(); ++i) made.residual[i] *= here.sigma[i];
    set_sigma(sigma, made);
    whiten_diagonal(*this, groups, made);
    whiten_wander(model, groups, made);
    column = std::move(made.whitened);
  }
  return columns;
}

}  // namespace seam::measurement
