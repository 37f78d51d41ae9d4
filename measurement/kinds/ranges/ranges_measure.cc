// Makes a set of ranges: what the robot would measure with this model's camera.
#include <filesystem>

#include "effects/stages/sensor/sensor.h"
#include "measurement/kinds/ranges/ranges.h"
#include "sim_core/base/error.h"

namespace seam::measurement {

// Each line is one frame; where no ball is seen in it, the line is left out.
void measure_ranges(const Model& truth, const MeasurementSet& protocol,
                    const MeasureOptions& options, const Instruments& instruments) {
  const CsvTable table = protocol.table("ranges");
  table.texts("trial");
  std::vector<BallPlace> places;
  const std::vector<size_t> place_of_line = read_places(table, places);
  const RangeSimulation simulation(protocol, places, instruments);
  copy_protocol(protocol, options.out, {"ranges"});
  for (const char* key : {"scene", "colour_table"}) {
    if (!protocol.root.find(key)) continue;
    copy_into(options.out, protocol, protocol.root.at(key).text());
  }
  const RandomStream camera = RandomStream{.seed = options.seed}.child("ranges");
  const auto pattern = effects::fixed_pattern(effects::sensor_of(truth), simulation.width_px(),
                                              simulation.height_px(), 3, camera);
  const double noise = options.noise ? protocol.noise_of("measured_m") : 0;
  std::vector<std::string> columns = table.columns();
  if (!table.has("measured_m")) columns.push_back("measured_m");
  CsvWriter out(columns);
  size_t seen = 0;
  for (size_t row = 0; row < table.rows(); ++row) {
    const auto sighting = simulation.measure_once(truth, place_of_line[row], pattern,
                                                  camera.child("frame").child(row), options.noise);
    if (!sighting) continue;
    ++seen;
    const double measured = sighting->distance_m + noise * normal(camera.child("noise"), row);
    std::vector<std::string> cells;
    for (const std::string& column : columns)
      cells.push_back(column == "measured_m" ? fmt::format("{:.6f}", measured)
                                             : std::string(table.cell(row, column)));
    out.row(cells);
  }
  if (seen == 0) {
    throw InputError(
        fmt::format("{}: with model '{}' the detector sees the ball in none of {} frames",
                    table.file(), truth.name(), table.rows()));
  }
  out.write(written_path(options.out, protocol.files.at("ranges")));
}

}  // namespace seam::measurement
