// Makes a set of landmarks: what the model would report by a protocol's stamps.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "measurement/kinds/kinds.h"
#include "measurement/kinds/landmarks/landmark_predictor.h"

namespace seam::measurement {

void measure_landmarks(const Model& truth, const MeasurementSet& protocol,
                       const MeasureOptions& options) {
  Facts facts;
  const LandmarkData data = read_landmarks(protocol, false, facts);
  const CsvTable table = protocol.table("observations");
  const LandmarkPredictor predictor(data, truth);
  const RandomStream stream =
      RandomStream{.seed = options.seed}.child("measure").child("landmarks");
  std::vector<std::string> columns = table.columns();
  for (const char* name : {"range_m", "bearing_rad"}) {
    if (!table.has(name)) columns.push_back(name);
  }
  std::vector<uint64_t> frame_of_row(data.stamp_s.size());
  for (size_t frame = 0; frame < data.rows_of_frame.size(); ++frame) {
    for (const int row : data.rows_of_frame[frame]) frame_of_row[row] = frame;
  }
  CsvWriter out(columns);
  for (size_t row = 0; row < data.stamp_s.size(); ++row) {
    const double late =
        options.noise ? predictor.timing().own_latency_s(stream, frame_of_row[row]) : 0;
    effects::Detection seen = predictor.detect(row, late);
    if (options.noise) {
      const auto stated = [&](const char* name) {
        return protocol.noise.contains(name) ? protocol.noise.at(name) : 0.0;
      };
      seen.range_m += std::hypot(stated("range_m"), std::sqrt(seen.range_variance)) *
                      normal(stream.child("noise"), 2 * row);
      seen.bearing_rad += std::hypot(stated("bearing_rad"), std::sqrt(seen.bearing_variance)) *
                          normal(stream.child("noise"), 2 * row + 1);
    }
    std::vector<std::string> cells;
    for (const std::string& name : columns) {
      cells.push_back(name == "range_m" ? fmt::format("{:.7f}", std::max(0.0, seen.range_m))
                      : name == "bearing_rad"
                          ? fmt::format("{:.8f}", maths::wrap_angle(seen.bearing_rad))
                          : std::string(table.cell(row, name)));
    }
    out.row(cells);
  }
  copy_protocol(protocol, options.out, {"observations"});
  out.write(written_path(options.out, protocol.files.at("observations")));
}

}  // namespace seam::measurement
