#include "measurement/kinds/photometry/likelihood/photometry_data.h"

#include <cmath>
#include <map>
#include <tuple>

#include "measurement/imaging/converter_steps.h"
#include "sim_core/base/error.h"
#include "sim_core/base/hash.h"

namespace seam::measurement {
namespace {

void read_images(const MeasurementSet& set, const CsvTable& table, PhotometryData& data) {
  for (size_t row = 0; row < table.rows(); ++row) {
    Image image = read_png(set.inside(table, row, "file"));
    if (image.width_px != data.width_px || image.height_px != data.height_px) {
      table.fail(row, "file", fmt::format("an image of {} x {}", image.width_px, image.height_px),
                 fmt::format("{} x {} as the camera has", data.width_px, data.height_px));
    }
    if (row == 0) data.channels = image.channels, data.file_bits = image.bits;
    if (image.channels != data.channels || image.bits != data.file_bits) {
      table.fail(row, "file", fmt::format("{} channels of {} bits", image.channels, image.bits),
                 fmt::format("{} of {} as in the first image", data.channels, data.file_bits));
    }
    data.images.push_back(std::move(image.samples));
  }
}

void sort_into_levels(const CsvTable& table, PhotometryData& data) {
  const auto times = table.numbers("time_s");
  const auto exposure = table.numbers("exposure_s");
  const auto illumination = table.numbers_or_blank("illumination");
  const bool has_level = table.has("level");
  const auto level = has_level ? table.texts("level") : std::vector<std::string>(table.rows());
  const auto gain =
      table.has("gain") ? table.numbers("gain") : std::vector<double>(table.rows(), 1);
  std::map<std::tuple<std::string, double, double, double>, int> places;
  for (size_t row = 0; row < table.rows(); ++row) {
    if (exposure[row] < 0) {
      table.fail(row, "exposure_s", table.cell(row, "exposure_s"), "0 or more");
    }
    if (exposure[row] > 0 && exposure[0] == 0) {
      table.fail(0, "exposure_s", "0", "the exposure of the first frame, to which others relate");
    }
    if (gain[row] <= 0) table.fail(row, "gain", table.cell(row, "gain"), "more than 0");
    const bool blank = std::isnan(illumination[row]);
    if (blank && (!has_level || level[row].empty())) {
      table.fail(row, "illumination", "a blank", "a number, or a level in a column 'level'");
    }
    if (!blank && illumination[row] < 0) {
      table.fail(row, "illumination", table.cell(row, "illumination"), "0 or more");
    }
    const auto key =
        std::make_tuple(level[row], blank ? -1.0 : illumination[row], exposure[row], gain[row]);
    const auto [place, is_new] = places.try_emplace(key, static_cast<int>(data.levels.size()));
    if (is_new) {
      data.levels.push_back({.illumination = illumination[row],
                             .exposure_s = exposure[row],
                             .exposure_ratio = exposure[0] > 0 ? exposure[row] / exposure[0] : 1,
                             .gain = gain[row]});
    }
    data.levels[place->second].frames.push_back(static_cast<int>(row));
    data.frames.push_back({.level = place->second, .time_s = times[row]});
  }
}

void sum_rows(PhotometryData& data) {
  const int width = data.width_px, channels = data.channels;
  for (const auto& image : data.images) {
    std::vector<double> means(data.rows(), 0);
    size_t i = 0;
    for (int v = 0; v < data.height_px; ++v) {
      for (int u = 0; u < width; ++u) {
        for (int c = 0; c < channels; ++c)
          means[static_cast<size_t>(v) * channels + c] += image[i++];
      }
    }
    for (double& mean : means) mean /= width;
    data.row_mean.push_back(std::move(means));
  }
}

std::string fingerprint_of(const MeasurementSet& set, const PhotometryData& data) {
  Hasher hasher;
  hasher.add(set.fingerprint());
  for (const auto& image : data.images) {
    hasher.add_bytes({reinterpret_cast<const uint8_t*>(image.data()), image.size() * 2});
  }
  return to_hex(hasher.digest());
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
  sort_into_levels(table, data);
  return data;
}

PhotometryData read_photometry(const MeasurementSet& set, Facts& facts) {
  const CsvTable table = set.table("frames");
  PhotometryData data = read_photometry_frames(set, table);
  read_images(set, table, data);
  const auto is_rgb = set.camera.channels == "rgb";
  if (set.root.at("camera").has("channels") && is_rgb != (data.channels == 3)) {
    table.fail(0, "file", data.channels == 3 ? "an RGB image" : "a grey image",
               "channels: " + set.camera.channels + " as measurement.yaml says");
  }
  sum_rows(data);
  data.fewest_bits = fewest_bits(data.images, data.file_bits);
  facts.set.kind = effects::kPhotometry;
  facts.title = set.title;
  facts.fingerprint = fingerprint_of(set, data);
  facts.file = table.file();
  facts.channels = {{.name = "dn", .noise = set.noise_of("dn")}};
  const std::string group = table.has(set.group) ? set.group : "frame";
  facts.group_of_row = number_groups(table.texts(group), facts.groups);
  for (size_t row = 0; row < table.rows(); ++row) {
    facts.line_of_row.push_back(table.line(row));
    facts.time_of_row.push_back(data.frames[row].time_s - data.frames[0].time_s);
  }
  const size_t values = data.samples() * data.frames.size();
  facts.channel_of.assign(values, 0);
  facts.row_of.reserve(values);
  for (size_t row = 0; row < table.rows(); ++row) {
    facts.row_of.insert(facts.row_of.end(), data.samples(), static_cast<int>(row));
  }
  return data;
}

PhotometrySums sum_frames(const PhotometryData& data, const Groups& groups,
                          const std::vector<int>& group_of_frame) {
  Hasher chosen;
  chosen.add(std::string_view(groups.data(), groups.size()));
  PhotometrySums sums{.id = chosen.digest()};
  const size_t samples = data.samples();
  const int width = data.width_px, channels = data.channels;
  for (const PhotometryLevel& level : data.levels) {
    LevelSums sum;
    for (const int frame : level.frames) {
      if (groups[group_of_frame[frame]]) sum.frames.push_back(frame);
    }
    if (!sum.frames.empty()) {
      sum.mean.assign(samples, 0);
      sum.row_mean.assign(data.rows(), 0);
      sum.scatter.assign(samples, 0);
      for (const int frame : sum.frames) {
        for (size_t i = 0; i < samples; ++i) sum.mean[i] += data.images[frame][i];
        for (size_t row = 0; row < data.rows(); ++row)
          sum.row_mean[row] += data.row_mean[frame][row];
      }
      const double scale = 1.0 / static_cast<double>(sum.frames.size());
      for (double& mean : sum.mean) mean *= scale;
      for (double& mean : sum.row_mean) mean *= scale;
      for (const int frame : sum.frames) {
        const auto& image = data.images[frame];
        size_t i = 0;
        for (int v = 0; v < data.height_px; ++v) {
          double shift[3];
          for (int c = 0; c < channels; ++c) {
            const size_t row = static_cast<size_t>(v) * channels + c;
            shift[c] = data.row_mean[frame][row] - sum.row_mean[row];
          }
          for (int u = 0; u < width; ++u) {
            for (int c = 0; c < channels; ++c, ++i) {
              const double rest = image[i] - sum.mean[i] - shift[c];
              sum.scatter[i] += rest * rest;
            }
          }
        }
      }
      sums.values += static_cast<int64_t>(sum.frames.size() * samples);
    }
    sums.levels.push_back(std::move(sum));
  }
  return sums;
}

}  // namespace seam::measurement
