// `seam measure` for servo logs: the protocol's commands through the model's own solvers.
#include <cmath>
#include <numeric>

#include "measurement/kinds/joints/joints.h"
#include "measurement/noise/draw.h"
#include "sim_core/base/random.h"

namespace seam::measurement {

void measure_joints(const Model& truth, const MeasurementSet& protocol,
                    const MeasureOptions& options) {
  const CsvTable table = protocol.table("joints");
  const JointLogs set = read_joint_logs(table, protocol.group, false);
  effects::JointTrack track;
  effects::apply_encoder_effects(truth, track);
  const double step = track.quantisation_step_rad, sigma = protocol.noise_of("measured_rad");
  const RandomStream random = RandomStream{options.seed, 0}.child("joints");
  const std::vector<effects::Wander> wanders = effects::noise_of(truth).joint;
  std::vector<double> measured(table.rows(), 0);
  for (const JointLog& log : set.logs) {
    const auto angles = predict_joint_log(truth, set, log, log.command_rad.front());
    std::vector<double> wander(options.noise ? angles.size() : 0, 0);
    std::vector<size_t> order(wander.size());
    std::iota(order.begin(), order.end(), 0);
    for (size_t w = 0; w < wanders.size(); ++w)
      add_wander(wanders[w], log.time_s, order,
                 random.child("wander").child(w).child(log.rows.front()), wander);
    for (size_t k = 0; k < angles.size(); ++k) {
      double angle = angles[k];
      if (options.noise) angle += wander[k] + sigma * normal(random, log.rows[k]);
      if (step > 0) angle = step * std::round(angle / step);
      measured[log.rows[k]] = angle;
    }
  }
  copy_protocol(protocol, options.out, {"joints"});
  write_table_with(table, {"measured_rad"}, {measured},
                   written_path(options.out, protocol.files.at("joints")));
}

}  // namespace seam::measurement
