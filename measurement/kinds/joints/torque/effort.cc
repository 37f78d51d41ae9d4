#include "measurement/kinds/joints/torque/effort.h"

#include <algorithm>
#include <cmath>

#include "effects/questions.h"
#include "effects/stages/servo.h"

namespace seam::measurement {
namespace {

// Whether some value differs from another: what a driver fills in shows one.
bool varies(const std::vector<double>& values) {
  double first = NAN;
  return std::any_of(values.begin(), values.end(), [&](double value) {
    if (std::isnan(first)) first = value;
    return std::isfinite(value) && value != first;
  });
}

std::vector<double> checked_efforts(const CsvTable& table) {
  constexpr double kLargest_nm = 1e5;  // No joint's.
  if (!table.has(kEffort)) return {};
  std::vector<double> efforts = table.numbers_or_blank(kEffort);
  for (size_t row = 0; row < efforts.size(); ++row) {
    if (std::abs(efforts[row]) > kLargest_nm) {
      table.fail(row, kEffort, table.cell(row, kEffort),
                 "a torque in N m (one in N mm is to be divided by 1000), or nothing");
    }
  }
  return efforts;
}

}  // namespace

std::vector<double> read_efforts(const CsvTable& table) {
  std::vector<double> efforts = checked_efforts(table);
  return varies(efforts) ? efforts : std::vector<double>();
}

std::string note_of_efforts(const CsvTable& table) {
  const std::vector<double> efforts = checked_efforts(table);
  const auto seen = std::find_if(efforts.begin(), efforts.end(),
                                 [](double effort) { return std::isfinite(effort); });
  if (efforts.empty() || varies(efforts)) return "";
  if (seen == efforts.end())
    return fmt::format("{}: column {} is blank in all rows: no torque is measured", table.file(),
                       kEffort);
  return fmt::format(
      "{}: column {} is {} wherever it is not blank, expected torques that differ: it takes no "
      "part",
      table.file(), kEffort, *seen);
}

bool predicts_efforts(const Model& model) {
  return effects::has_base(model, effects::Base::motor);
}

bool states_inertia(const Model& model) {
  return effects::servo_of(model).effort.inertia_kg_m2 > 0;
}

bool is_of_efforts(const EffectDefinition& effect) {
  return std::find(effect.needs.begin(), effect.needs.end(), effects::Need::motor_torques) !=
         effect.needs.end();
}

bool knows_inertia(const Model& model) {
  if (!states_inertia(model)) return false;
  effects::ServoModel alone;
  for (const effects::ModelEffect& effect : model.effects()) {
    if (!is_of_efforts(*effect.definition)) continue;
    alone.effort.inertia_kg_m2 = 0;
    effect.definition->servo(effect.values(), alone);
    if (alone.effort.inertia_kg_m2 > 0) return !effect.parameters.front().refitted();
  }
  return false;
}

double add_effort_residuals(const Problem& problem, const Model& model, const Groups& groups,
                            const std::vector<double>& efforts_nm,
                            const std::vector<double>& drive_rad_per_s2, Evaluation& evaluation) {
  const Facts& facts = problem.facts();
  const effects::EffortReading effort = effects::servo_of(model).effort;
  std::vector<size_t> scalars;
  double along = 0, norm = 0;
  for (size_t i = 0; i < facts.scalars(); ++i) {
    if (facts.channel_of[i] != 1 || !groups[facts.group_of(i)]) continue;
    scalars.push_back(i);
    const auto row = static_cast<size_t>(facts.row_of[i]);
    if (problem.left_out(i)) continue;
    const double shown = (1 + effort.scale) * drive_rad_per_s2[row];
    along += shown * (efforts_nm[row] - effort.offset_nm), norm += shown * shown;
  }
  double inertia_kg_m2 = effort.inertia_kg_m2;
  // Below 0 the column counts the other way round than the angles: no inertia agrees with it.
  if (!(inertia_kg_m2 > 0)) inertia_kg_m2 = norm > 0 ? std::max(0.0, along / norm) : 0;
  for (const size_t i : scalars) {
    const auto row = static_cast<size_t>(facts.row_of[i]);
    evaluation.residual[i] =
        efforts_nm[row] - effort.of_torque(inertia_kg_m2 * drive_rad_per_s2[row]);
  }
  return inertia_kg_m2;
}

}  // namespace seam::measurement
