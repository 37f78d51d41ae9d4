// Torques of the motor as the second channel of servo logs.
#include <algorithm>
#include <cmath>

#include "measurement/kinds/joints/joints.h"
#include "measurement/kinds/joints/torque/effort.h"
#include "measurement/numerics/robust.h"

namespace seam::measurement {
namespace {

// One sigma of a single torque, from the torques alone.
double noise_of_efforts(const JointLogs& set, const std::vector<double>& efforts_nm) {
  std::vector<std::vector<double>> times, values;
  for (const JointLog& log : set.logs) {
    times.emplace_back(), values.emplace_back();
    for (size_t k = 0; k < log.rows.size(); ++k) {
      if (std::isnan(efforts_nm[log.rows[k]])) continue;
      times.back().push_back(log.time_s[k]);
      values.back().push_back(efforts_nm[log.rows[k]]);
    }
  }
  return noise_from_neighbours(times, values);
}

}  // namespace

// A log's first row shows what held the joint before its first command, of which it says nothing.
void JointsProblem::add_efforts(const CsvTable& table, const MeasurementSet& set) {
  efforts_nm_ = read_efforts(table);
  if (std::string note = note_of_efforts(table); !note.empty()) facts_.notes.push_back(note);
  if (efforts_nm_.empty()) return;
  effort_scalar_.assign(facts_.rows(), -1);
  for (const JointLog& log : set_.logs) {
    for (size_t k = 1; k < log.rows.size(); ++k) {
      if (std::isfinite(efforts_nm_[log.rows[k]])) effort_scalar_[log.rows[k]] = 0;
    }
  }
  for (size_t row = 0; row < facts_.rows(); ++row) {
    if (effort_scalar_[row] < 0) continue;
    effort_scalar_[row] = static_cast<int>(facts_.scalars());
    facts_.row_of.push_back(static_cast<int>(row));
    facts_.channel_of.push_back(1);
  }
  const auto given = set.noise.find(kEffort);
  const bool estimated = given == set.noise.end();
  facts_.channels.push_back(
      {.name = kEffort,
       .noise = estimated ? noise_of_efforts(set_, efforts_nm_) : given->second,
       .estimated = estimated});
}

void JointsProblem::place(const Model& given) {
  facts_.set.lacks = lacks();
  for (effects::Lack& lack : lacks_of_torques(&given)) facts_.set.lacks.push_back(std::move(lack));
  efforts_read_ = has_efforts() && predicts_efforts(given);
  if (!has_efforts()) return;
  gross_.assign(facts_.scalars(), 0);
  if (efforts_read_) return;
  for (const int scalar : effort_scalar_) {
    if (scalar >= 0) gross_[static_cast<size_t>(scalar)] = 1;
  }
}

std::vector<effects::Lack> JointsProblem::lacks_of_torques(const Model* given) const {
  using effects::Need;
  if (!has_efforts() || (given != nullptr && !predicts_efforts(*given)))
    return {{Need::motor_torques, ""}};
  if (given != nullptr && knows_inertia(*given)) return {};
  return {{Need::known_inertia,
           "the joint's inertia is estimated from the same torques; a model that states it "
           "(joint_inertia) shows whether these are too large"}};
}

void JointsProblem::set_sigma(double sigma_rad, Evaluation& evaluation) const {
  evaluation.sigma.assign(facts_.rows(), sigma_rad);
  if (has_efforts()) evaluation.sigma.resize(facts_.scalars(), facts_.channels[1].noise);
}

void JointsProblem::predict_efforts(const Model& model, const Groups& groups,
                                    const std::vector<double>& drives,
                                    Evaluation& evaluation) const {
  const double inertia_kg_m2 =
      add_effort_residuals(*this, model, groups, efforts_nm_, drives, evaluation);
  evaluation.nuisance_values.push_back(inertia_kg_m2);
  if (predicts_efforts(model) && !states_inertia(model)) ++evaluation.nuisances;
}

std::vector<Finding> JointsProblem::findings(const Model& model) const {
  // Torques that took no part say nothing.
  if (!efforts_read_ || !predicts_efforts(model) || states_inertia(model)) return {};
  const double inertia_kg_m2 = evaluate(model, all_groups(), nullptr).nuisance_values.back();
  Finding finding{
      .what = "joint", .name = "inertia", .values = {{"kg_m2", inertia_kg_m2}}, .text = ""};
  finding.text =
      inertia_kg_m2 > 0
          ? fmt::format(
                "The torques in {} agree best with an inertia of {:.4g} kg m^2 (with its "
                "standard error where the model has "
                "joint_inertia: {{kg_m2: {{value: {:.4g}, free: true}}}}).",
                kEffort, inertia_kg_m2, inertia_kg_m2)
          : fmt::format(
                "The torques in {} agree with no inertia: they have the other sign than "
                "what drives the joint to larger angles, or are none of its motor.",
                kEffort);
  return {finding};
}

std::vector<std::string> JointsProblem::remarks(const Model& model) const {
  std::vector<std::string> remarks = Problem::remarks(model);
  if (has_efforts() && !predicts_efforts(model))
    remarks.push_back(
        fmt::format("{}: column {} takes no part: the model predicts no torque (motor_servo does)",
                    facts_.file, kEffort));
  else if (has_efforts() && !efforts_read_)
    remarks.push_back(fmt::format(
        "{}: column {} took no part: the search began with a model that predicts no torque; ask "
        "again with the model found, which does",
        facts_.file, kEffort));
  if (std::string hidden = why_late_commands_hide(model); !hidden.empty())
    remarks.push_back(std::move(hidden));
  return remarks;
}

std::vector<double> JointsProblem::out_of_neighbours(const Evaluation& evaluation) const {
  std::vector<double> distance(facts_.scalars(), 0);
  for (size_t i = 0; i < distance.size(); ++i) {
    const bool torque = facts_.channel_of[i] != 0;
    std::vector<double> around;
    for (const int row : neighbours(static_cast<size_t>(facts_.row_of[i]), kNearRows)) {
      const int other = torque ? effort_scalar_[row] : row;
      if (other >= 0) around.push_back(evaluation.residual[other]);
    }
    distance[i] = std::abs(evaluation.residual[i] - (around.size() < 3 ? 0 : median_of(around)));
  }
  return distance;
}

}  // namespace seam::measurement
