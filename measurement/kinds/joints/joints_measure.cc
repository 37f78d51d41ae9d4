// `seam measure` for servo logs: the protocol's commands through the model's own solvers.
#include <cmath>

#include "measurement/kinds/joints/joints.h"
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
  std::vector<double> measured(table.rows(), 0);
  for (const JointLog& log : set.logs) {
    const auto angles = predict_joint_log(truth, set, log, log.command_rad.front());
    for (size_t k = 0; k < angles.size(); ++k) {
      double angle = angles[k];
      if (options.noise) angle += sigma * normal(random, log.rows[k]);
      if (step > 0) angle = step * std::round(angle / step);
      measured[log.rows[k]] = angle;
    }
  }
  copy_protocol(protocol, options.out, {"joints"});
  write_table_with(table, {"measured_rad"}, {measured},
                   written_path(options.out, protocol.files.at("joints")));
}

}  // namespace seam::measurement
