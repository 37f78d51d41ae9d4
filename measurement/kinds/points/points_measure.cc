// Makes a set of points: what the model would show by a protocol's frames.
#include <algorithm>

#include "effects/stages/joint_track.h"
#include "measurement/kinds/kinds.h"
#include "measurement/kinds/points/points_predictor.h"
#include "sim_core/base/error.h"

namespace seam::measurement {

void measure_points(const Model& truth, const MeasurementSet& protocol,
                    const MeasureOptions& options) {
  Facts facts;
  PointsData data = read_points(protocol, false, facts);
  if (data.rig.type() == Rig::Type::unknown) {
    protocol.root.at("rig").fail(
        "found an unknown pose, expected a chain or poses: a protocol must say where the camera "
        "is");
  }
  const CsvTable table = protocol.table("points");
  std::fill(data.v_px.begin(), data.v_px.end(), 0.5 * data.camera.height_px);
  const effects::Timing timing = effects::timing_of(truth);
  const RandomStream stream = RandomStream{.seed = options.seed}.child("measure").child("points");
  // Spreads of whole frames are drawn: a latency a frame, an error at each sample of the log.
  const PointsPredictor predictor(data, truth);
  const double step = options.noise ? predictor.motion().quantisation_step_rad : 0;
  std::vector<std::string> columns = table.columns();
  for (const char* name : {"u_px", "v_px"}) {
    if (!table.has(name)) columns.push_back(name);
  }
  CsvWriter out(columns);
  for (size_t row = 0; row < data.p_W.size(); ++row) {
    const uint64_t frame = static_cast<uint64_t>(data.frame_of_row[row]);
    const double late = options.noise ? timing.own_latency_s(stream, frame) : 0;
    std::vector<double> errors(data.rig.joint_names().size(), 0);
    if (step > 0) {
      for (size_t j = 0; j < errors.size(); ++j) {
        // The logged angle is the true one rounded; the true one lies within half a step of it.
        const auto& log = data.rig.log_times();
        const double t = predictor.instant(data.stamp_s[row], 0.5 * data.camera.height_px);
        const size_t node = std::min<size_t>(
            std::upper_bound(log.begin(), log.end(), t) - log.begin(), log.size() - 1);
        errors[j] = step * (uniform(effects::rounding_stream(stream).child(j), node) - 0.5);
      }
    }
    const effects::ImagePoint point =
        predictor.image(row, late, errors.empty() ? nullptr : errors.data());
    double u = point.u, v = point.v;
    if (options.noise) {
      const auto sigma = [&](const char* name) {
        return protocol.noise.contains(name) ? protocol.noise.at(name) : 0.0;
      };
      u += sigma("u_px") * normal(stream.child("noise"), 2 * row);
      v += sigma("v_px") * normal(stream.child("noise"), 2 * row + 1);
    }
    const bool inside =
        u > -0.5 && v > -0.5 && u < data.camera.width_px - 0.5 && v < data.camera.height_px - 0.5;
    if (!point.visible || !inside) continue;
    std::vector<std::string> cells;
    for (const std::string& name : columns) {
      cells.push_back(name == "u_px"   ? fmt::format("{:.6f}", u)
                      : name == "v_px" ? fmt::format("{:.6f}", v)
                                       : std::string(table.cell(row, name)));
    }
    out.row(cells);
  }
  copy_protocol(protocol, options.out, {"points"});
  out.write(written_path(options.out, protocol.files.at("points")));
}

}  // namespace seam::measurement
