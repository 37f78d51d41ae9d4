// Makes a set of landmarks: what the model would report by a protocol's stamps.
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "measurement/kinds/kinds.h"
#include "measurement/kinds/landmarks/landmark_noise.h"
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
  const std::vector<std::string> measured(kLandmarkColumns.begin(), kLandmarkColumns.end());
  std::array<std::vector<char>, 2> blank;
  for (size_t c = 0; c < 2; ++c) {
    if (!table.has(measured[c])) columns.push_back(measured[c]);
    blank[c] = left_blank(table, measured[c], measured);
  }
  std::vector<uint64_t> frame_of_row(data.stamp_s.size());
  for (size_t frame = 0; frame < data.rows_of_frame.size(); ++frame) {
    for (const int row : data.rows_of_frame[frame]) frame_of_row[row] = frame;
  }
  const LandmarkErrors errors =
      draw_landmark_errors(data, effects::noise_of(truth), stream.child("noise"));
  std::vector<std::array<double, 2>> places;
  const double place_sigma_m = std::sqrt(effects::noise_of(truth).place_variance);
  for (size_t k = 0; k < data.landmarks.size(); ++k)
    places.push_back({place_sigma_m * normal(stream.child("place"), 2 * k),
                      place_sigma_m * normal(stream.child("place"), 2 * k + 1)});
  std::vector<double> delays_m;
  const double delay_sigma_m = std::sqrt(effects::noise_of(truth).delay_variance);
  for (size_t k = 0; k < data.landmarks.size(); ++k)
    delays_m.push_back(delay_sigma_m * normal(stream.child("delay"), k));
  CsvWriter out(columns);
  for (size_t row = 0; row < data.stamp_s.size(); ++row) {
    const double late =
        options.noise ? predictor.timing().own_latency_s(stream, frame_of_row[row]) : 0;
    effects::Detection seen = predictor.detect(
        row, late, options.noise ? places[data.landmark_of_row[row]] : std::array<double, 2>{});
    if (options.noise) {
      const auto stated = [&](const char* name) {
        return protocol.noise.contains(name) ? protocol.noise.at(name) : 0.0;
      };
      seen.range_m += std::hypot(stated("range_m"), std::sqrt(seen.range_variance)) *
                      normal(stream.child("noise"), 2 * row);
      seen.bearing_rad += std::hypot(stated("bearing_rad"), std::sqrt(seen.bearing_variance)) *
                          normal(stream.child("noise"), 2 * row + 1);
      seen.range_m += errors.range_m[row] + delays_m[data.landmark_of_row[row]];
      seen.bearing_rad += errors.bearing_rad[row];
    }
    // No detector reports a range that is none.
    const bool in_front = seen.range_m > 0;
    std::vector<std::string> cells;
    for (const std::string& name : columns) {
      if (name == measured[0])
        cells.push_back(blank[0][row] || !in_front ? "" : fmt::format("{:.7f}", seen.range_m));
      else if (name == measured[1])
        cells.push_back(blank[1][row] ? ""
                                      : fmt::format("{:.8f}", maths::wrap_angle(seen.bearing_rad)));
      else
        cells.emplace_back(table.cell(row, name));
    }
    out.row(cells);
  }
  copy_protocol(protocol, options.out, {"observations"});
  out.write(written_path(options.out, protocol.files.at("observations")));
}

}  // namespace seam::measurement
