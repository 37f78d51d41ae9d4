// Makes a photometry set: what the model would give by a protocol's exposures.
#include <cmath>
#include <filesystem>

#include "effects/questions.h"
#include "measurement/kinds/photometry/photometry_problem.h"
#include "sim_core/base/error.h"

namespace seam::measurement {

void measure_photometry(const Model& truth, const MeasurementSet& protocol,
                        const MeasureOptions& options) {
  const CsvTable table = protocol.table("frames");
  PhotometryData data = read_photometry_frames(protocol, table);
  if (!effects::has_base(truth, effects::Base::response)) {
    throw InputError(
        fmt::format("model '{}': {} is missing: a photometry set needs gain_dn and black_dn",
                    truth.name(), effects::base_name(effects::Base::response)));
  }
  data.channels = protocol.camera.channels == "rgb" ? 3 : 1;
  data.file_bits = protocol.camera.bits;
  data.stored_bits = protocol.camera.bits <= 8 ? 8 : 16;
  for (size_t row = 0; row < table.rows(); ++row) {
    if (std::isnan(data.levels[data.frames[row].level].illumination)) {
      table.fail(row, "illumination", "a blank",
                 "a number: a protocol says how much light there is");
    }
  }
  const auto files = table.texts("file");
  copy_protocol(protocol, options.out, {});
  const effects::SensorChain chain = effects::sensor_of(truth);
  const RandomStream camera = RandomStream{.seed = options.seed}.child("photometry");
  const auto pattern =
      effects::fixed_pattern(chain, data.width_px, data.height_px, data.channels, camera);
  const std::vector<double> own = own_light(data, truth);
  std::vector<double> light;
  std::vector<float> illumination(data.samples());
  for (size_t row = 0; row < table.rows(); ++row) {
    const PhotometryFrame& frame = data.frames[row];
    const PhotometryLevel& level = data.levels[frame.level];
    const double t = frame.time_s - data.frames[0].time_s;
    light = relative_light(data, truth, t);
    const auto lamps = lamp_rows(data, static_cast<int>(row), level.exposure_s, truth);
    const size_t row_samples = static_cast<size_t>(data.width_px) * data.channels;
    for (size_t i = 0; i < illumination.size(); ++i) {
      illumination[i] = static_cast<float>(level.illumination * light[i] * lamps[i / row_samples] +
                                           (own.empty() ? 0 : own[i]));
    }
    const effects::SensorExposure exposure{.exposure_s = level.exposure_s,
                                           .exposure_ratio = level.exposure_ratio,
                                           .gain = level.gain,
                                           .t_s = t,
                                           .file_bits = data.file_bits};
    Image image = effects::expose(chain, pattern, illumination, exposure,
                                  camera.child("frame").child(row), options.noise);
    image.bits = data.stored_bits;
    protocol.inside(table, row, "file");
    write_png(written_path(options.out, files[row]), image);
  }
}

}  // namespace seam::measurement
