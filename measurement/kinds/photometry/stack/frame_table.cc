// frames.csv: which frames there are, and what light each level of them had.
#include <cmath>
#include <map>
#include <tuple>

#include "measurement/kinds/photometry/stack/photometry_data.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

// The columns of frames.csv; those that a set may leave out are filled.
struct FrameColumns {
  explicit FrameColumns(const CsvTable& table)
      : time_s(table.numbers("time_s")),
        exposure_s(table.numbers("exposure_s")),
        gain(table.has("gain") ? table.numbers("gain") : std::vector<double>(table.rows(), 1)),
        photons(table.has("photons") ? table.numbers_or_blank("photons")
                                     : std::vector<double>(table.rows(), std::nan(""))),
        level(table.has("level") ? table.texts("level") : std::vector<std::string>(table.rows())) {
    // Where photons are counted they say how much light there was.
    if (table.has("illumination") || !table.has("photons")) {
      illumination = table.numbers_or_blank("illumination");
      return;
    }
    for (size_t row = 0; row < table.rows(); ++row) {
      const double ratio = exposure_s[0] > 0 ? exposure_s[row] / exposure_s[0] : 1;
      illumination.push_back(photons[row] == 0 ? 0 : photons[row] / ratio);
    }
  }

  std::vector<double> time_s, exposure_s, gain, photons, illumination;
  std::vector<std::string> level;
};

void check_row(const CsvTable& table, const FrameColumns& columns, size_t row) {
  const auto refuse_negative = [&](const char* column, double value) {
    if (value < 0) table.fail(row, column, table.cell(row, column), "0 or more");
  };
  refuse_negative("exposure_s", columns.exposure_s[row]);
  if (columns.exposure_s[row] > 0 && columns.exposure_s[0] == 0)
    table.fail(0, "exposure_s", "0", "the exposure of the first frame, to which others relate");
  if (columns.gain[row] <= 0) table.fail(row, "gain", table.cell(row, "gain"), "more than 0");
  if (std::isnan(columns.illumination[row])) {
    if (columns.level[row].empty()) {
      table.fail(row, table.has("illumination") ? "illumination" : "photons", "a blank",
                 "a number, or a level in a column 'level'");
    }
  } else if (table.has("illumination")) {
    refuse_negative("illumination", columns.illumination[row]);
  }
  if (table.has("photons")) refuse_negative("photons", columns.photons[row]);
  if (columns.photons[row] > 0 && columns.illumination[row] == 0)
    table.fail(row, "photons", table.cell(row, "photons"), "0 where the illumination is 0");
}

}  // namespace

PhotometryData read_photometry_frames(const MeasurementSet& set, const CsvTable& table) {
  if (set.camera.width_px == 0)
    set.root.fail("camera: is missing: a photometry set needs width_px and height_px");
  if (table.rows() == 0)
    throw InputError(fmt::format("{}: no frames, expected at least one", table.file()));
  PhotometryData data{.width_px = set.camera.width_px,
                      .height_px = set.camera.height_px,
                      .frame_period_s = set.camera.frame_period_s};
  const FrameColumns columns(table);
  std::map<std::tuple<std::string, double, double, double>, int> places;
  std::map<std::string, size_t> first_row;  // Of each named level.
  for (size_t row = 0; row < table.rows(); ++row) {
    check_row(table, columns, row);
    const double illumination = columns.illumination[row], exposure = columns.exposure_s[row];
    if (const std::string& name = columns.level[row]; !name.empty()) {
      const size_t first = first_row.try_emplace(name, row).first->second;
      if (exposure != columns.exposure_s[first]) {
        table.fail(row, "exposure_s", table.cell(row, "exposure_s"),
                   fmt::format("{} as line {} has for the same level '{}'",
                               table.cell(first, "exposure_s"), table.line(first), name));
      }
    }
    const auto key =
        std::make_tuple(columns.level[row], std::isnan(illumination) ? -1.0 : illumination,
                        exposure, columns.gain[row]);
    const auto [place, is_new] = places.try_emplace(key, static_cast<int>(data.levels.size()));
    if (is_new) {
      const double first = columns.exposure_s[0];
      data.levels.push_back({.illumination = illumination,
                             .exposure_s = exposure,
                             .exposure_ratio = first > 0 ? exposure / first : 1,
                             .gain = columns.gain[row],
                             .photons = columns.photons[row]});
    }
    data.levels[place->second].frames.push_back(static_cast<int>(row));
    data.frames.push_back({.level = place->second, .time_s = columns.time_s[row]});
  }
  return data;
}

int bits_of_set(const MeasurementSet& set, int stored_bits) {
  const ConfigNode camera = set.root.at("camera");
  if (!camera.has("bits")) return stored_bits;
  if (set.camera.bits > stored_bits) {
    camera.at("bits").fail(fmt::format("{} bits, but the files have {} a sample: expected no more",
                                       set.camera.bits, stored_bits));
  }
  return set.camera.bits;
}

}  // namespace seam::measurement
