// `seam measure` for servo logs: the protocol's commands through the model's own solvers.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "measurement/kinds/joints/joints.h"
#include "measurement/kinds/joints/torque/effort.h"
#include "measurement/noise/draw.h"
#include "sim_core/base/error.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

// Torques of the drives, by row: where the model says what they are, and the protocol asks for them
// by a column, or by their noise.
class MadeEfforts {
 public:
  MadeEfforts(const Model& truth, const MeasurementSet& protocol, const CsvTable& table)
      : effort_(effects::servo_of(truth).effort),
        sigma_nm_(protocol.noise_of(kEffort)),
        asked_(table.has(kEffort) || sigma_nm_ > 0),
        predicted_(predicts_efforts(truth) && states_inertia(truth)),
        blank_(left_blank(table, kEffort, {kEffort})),
        values_(table.rows(), NAN) {}

  void add(const JointLog& log, const std::vector<double>& drives, const RandomStream* noise) {
    for (size_t k = 0; predicted_ && k < log.rows.size(); ++k) {
      const size_t row = log.rows[k];
      if (blank_[row]) continue;
      values_[row] = effort_.of_torque(effort_.inertia_kg_m2 * drives[k]);
      if (noise != nullptr) values_[row] += sigma_nm_ * normal(*noise, row);
    }
  }
  bool asked() const { return asked_; }
  const std::vector<double>& values() const { return values_; }

 private:
  effects::EffortReading effort_;
  double sigma_nm_;
  bool asked_, predicted_;
  std::vector<char> blank_;
  std::vector<double> values_;
};

// A log whose commands act early or late, in their order, and none before it is given.
JointLog with_late_commands(JointLog log, double sigma_s, double latency_s,
                            const RandomStream& random) {
  double last_s = -std::numeric_limits<double>::infinity();
  for (size_t k = 0; k < log.rows.size(); ++k) {
    const double late_s = std::max(-latency_s, sigma_s * normal(random, log.rows[k]));
    last_s = std::max(last_s, log.time_s[k] + late_s);
    log.late_s.push_back(last_s - log.time_s[k]);
  }
  return log;
}

}  // namespace

void measure_joints(const Model& truth, const MeasurementSet& protocol,
                    const MeasureOptions& options) {
  const CsvTable table = protocol.table("joints");
  const JointLogs set = read_joint_logs(table, protocol.group, false);
  expect_no_pause(pause_too_long(table, set), truth);
  effects::JointTrack track;
  effects::apply_encoder_effects(truth, track);
  const double step = track.quantisation_step_rad, sigma = protocol.noise_of("measured_rad");
  const RandomStream random = RandomStream{options.seed, 0}.child("joints");
  const std::vector<effects::Wander> wanders = effects::noise_of(truth).joint;
  const RandomStream of_efforts = random.child("effort");
  MadeEfforts efforts(truth, protocol, table);
  std::vector<double> measured(table.rows(), 0), drives;
  const double late_s = options.noise ? effects::noise_of(truth).command_sigma_s : 0;
  const double latency_s = effects::servo_of(truth).latency_s;
  bool late_shows = false;
  for (const JointLog& given : set.logs) {
    const JointLog log =
        late_s > 0 ? with_late_commands(given, late_s, latency_s, random.child("late")) : given;
    const auto angles = predict_joint_log(truth, set, log, log.command_rad.front(), 0, {}, &drives);
    efforts.add(log, drives, options.noise ? &of_efforts : nullptr);
    late_shows |=
        late_s > 0 && angles != predict_joint_log(truth, set, given, given.command_rad.front());
    std::vector<double> wander(options.noise ? angles.size() : 0, 0);
    std::vector<size_t> order(wander.size());
    std::iota(order.begin(), order.end(), 0);
    for (size_t w = 0; w < wanders.size(); ++w)
      add_wander(wanders[w], log.time_s, order,
                 random.child("wander").child(w).child(log.rows.front()), wander);
    for (size_t k = 0; k < angles.size(); ++k) {
      double angle = angles[k];
      if (!std::isfinite(angle))
        throw InputError(fmt::format(
            "{}:{}: the model gives joint {} no angle here: a motor that is stiffer, or swings "
            "faster, than can be followed from row to row",
            table.file(), table.line(log.rows[k]), log.joint));
      if (options.noise) angle += wander[k] + sigma * normal(random, log.rows[k]);
      if (step > 0) angle = step * std::round(angle / step);
      measured[log.rows[k]] = angle;
    }
  }
  // Where commands are so late that some act behind the next row, even such a servo shows it.
  if (const std::string hidden = why_late_commands_hide(truth);
      late_s > 0 && !late_shows && !hidden.empty() && options.warnings != nullptr)
    options.warnings->push_back(hidden);
  copy_protocol(protocol, options.out, {"joints"});
  std::vector<std::string> names = {"measured_rad"};
  std::vector<std::vector<double>> made = {measured};
  if (efforts.asked()) names.emplace_back(kEffort), made.push_back(efforts.values());
  write_table_with(table, names, made, written_path(options.out, protocol.files.at("joints")));
}

}  // namespace seam::measurement
