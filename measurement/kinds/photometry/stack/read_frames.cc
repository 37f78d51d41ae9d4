// Reads the images of a set level by level: what is kept of each, and what all samples say.
#include <algorithm>
#include <cmath>

#include "measurement/imaging/converter_steps.h"
#include "measurement/imaging/image_file.h"
#include "measurement/kinds/photometry/stack/emva.h"
#include "measurement/kinds/photometry/stack/photometry_data.h"
#include "measurement/kinds/photometry/stack/stated_light.h"
#include "sim_core/base/error.h"
#include "sim_core/base/hash.h"

namespace seam::measurement {
namespace {

// Sample values of all levels that are looked at together: what a search looks at thousands of
// times. A level's mean is then known to a thousandth of its noise, its noise to a percent.
constexpr double kMostPredictions = 1.5e6;
// However many levels there are.
constexpr double kLeastSamples = 8192;

// Of a level's values, as they are read.
class LevelCounter {
 public:
  void add(const Image& image) {
    sum_.resize(image.samples.size(), 0);
    double total = 0;
    for (size_t i = 0; i < image.samples.size(); ++i) {
      const uint32_t value = image.samples[i];
      sum_[i] += value;
      total += value;
      square_ += static_cast<double>(value) * value;
      if (value > top_) top_ = value, at_top_ = 0;
      at_top_ += value == top_;
      at_zero_ += value == 0;
    }
    frame_means_.push_back(total / static_cast<double>(image.samples.size()));
  }

  LevelStatistics result() const {
    const auto n = static_cast<double>(sum_.size()), f = static_cast<double>(frame_means_.size());
    double total = 0, of_sums = 0;
    for (const uint32_t sum : sum_) {
      total += sum;
      of_sums += static_cast<double>(sum) * sum;
    }
    LevelStatistics out{.frames = static_cast<int>(f), .samples = n, .mean = total / (n * f)};
    out.at_top = static_cast<double>(at_top_) / (n * f);
    out.at_zero = static_cast<double>(at_zero_) / (n * f);
    const double mean_sum = total / n;
    out.spatial_variance = (of_sums / n - mean_sum * mean_sum) / (f * f) * n / std::max(1.0, n - 1);
    if (f < 2) return out;
    for (const double mean : frame_means_)
      out.frame_scatter += (mean - out.mean) * (mean - out.mean) / (f - 1);
    out.temporal_variance = (square_ - of_sums / f) / ((f - 1) * n) - out.frame_scatter;
    return out;
  }

 private:
  std::vector<uint32_t> sum_;
  double square_ = 0;
  uint32_t top_ = 0;
  uint64_t at_top_ = 0, at_zero_ = 0;
  std::vector<double> frame_means_;
};

class FrameReader {
 public:
  FrameReader(const MeasurementSet& set, const CsvTable& table, PhotometryData& data)
      : set_(set), table_(table), data_(data) {
    data.images.resize(table.rows());
  }

  void read_all() {
    for (PhotometryLevel& level : data_.levels) {
      LevelCounter counter;
      for (const int frame : level.frames) {
        const Image image = read(static_cast<size_t>(frame));
        hasher_.add_bytes({reinterpret_cast<const uint8_t*>(image.samples.data()),
                           image.samples.size() * sizeof(uint16_t)});
        if (image.channels == 1) counter.add(image);
        data_.images[static_cast<size_t>(frame)] = keep(image);
      }
      if (data_.channels == 1) level.whole = counter.result();
    }
    if (is_thinned()) {
      data_.sensor_width_px = data_.width_px, data_.sensor_height_px = data_.height_px;
      data_.column_px = kept_.column_px, data_.row_px = kept_.row_px;
      data_.width_px = static_cast<int>(kept_.column_px.size());
      data_.height_px = static_cast<int>(kept_.row_px.size());
    }
  }

  std::string fingerprint() {
    hasher_.add(set_.fingerprint());
    return to_hex(hasher_.digest());
  }

 private:
  Image decoded(size_t row) const {
    const auto path = set_.inside(table_, row, "file");
    try {
      return read_image(path);
    } catch (const InputError& error) {
      throw InputError(
          fmt::format("{}:{}: column file: {}", table_.file(), table_.line(row), error.what()));
    }
  }

  Image read(size_t row) {
    Image image = decoded(row);
    if (image.width_px != data_.width_px || image.height_px != data_.height_px) {
      table_.fail(row, "file", fmt::format("an image of {} x {}", image.width_px, image.height_px),
                  fmt::format("{} x {} as the camera has", data_.width_px, data_.height_px));
    }
    if (first_) {
      first_ = false;
      data_.channels = image.channels, data_.stored_bits = image.bits;
      data_.file_bits = bits_of_set(set_, image.bits);
      kept_ = thinning_of(
          image.width_px, image.height_px, image.channels,
          std::max(kLeastSamples, kMostPredictions / static_cast<double>(data_.levels.size())));
      const bool is_rgb = set_.camera.channels == "rgb";
      if (set_.root.at("camera").has("channels") && is_rgb != (data_.channels == 3)) {
        table_.fail(row, "file", data_.channels == 3 ? "an RGB image" : "a grey image",
                    "channels: " + set_.camera.channels + " as measurement.yaml says");
      }
    }
    if (image.channels != data_.channels || image.bits != data_.stored_bits) {
      table_.fail(row, "file", fmt::format("{} channels of {} bits", image.channels, image.bits),
                  fmt::format("{} of {} as in the first image", data_.channels, data_.stored_bits));
    }
    check_values(row, image);
    return image;
  }

  void check_values(size_t row, const Image& image) const {
    const uint32_t top = (1u << data_.file_bits) - 1;
    const auto above = std::find_if(image.samples.begin(), image.samples.end(),
                                    [top](uint16_t value) { return value > top; });
    if (above == image.samples.end()) return;
    const auto pixel = static_cast<int>((above - image.samples.begin()) / image.channels);
    table_.fail(row, "file",
                fmt::format("{}: {} at row {}, column {}", table_.cell(row, "file"), *above,
                            pixel / image.width_px, pixel % image.width_px),
                fmt::format("0 to {}, as camera: {{bits: {}}} says (values that fill {} bits from "
                            "the left: bits: {} and quantisation)",
                            top, data_.file_bits, data_.stored_bits, data_.stored_bits));
  }

  bool is_thinned() const {
    return static_cast<int>(kept_.column_px.size()) < data_.width_px ||
           static_cast<int>(kept_.row_px.size()) < data_.height_px;
  }

  std::vector<uint16_t> keep(const Image& image) const {
    if (!is_thinned()) return image.samples;
    std::vector<uint16_t> part;
    for (const int v : kept_.row_px) {
      for (const int u : kept_.column_px) {
        for (int c = 0; c < image.channels; ++c) part.push_back(image.at(u, v, c));
      }
    }
    return part;
  }

  const MeasurementSet& set_;
  const CsvTable& table_;
  PhotometryData& data_;
  Thinning kept_;
  Hasher hasher_;
  bool first_ = true;
};

// What the values say of the converter, where measurement.yaml says something else.
void note_bits(const PhotometryData& data, Facts& facts) {
  uint32_t top = 0;
  for (const auto& image : data.images)
    for (const uint16_t value : image) top = std::max<uint32_t>(top, value);
  const int bits = data.fewest_bits;
  if (data.file_bits == 16 && bits >= 8 && bits <= 14) {
    facts.notes.push_back(fmt::format(
        "all values are multiples of {}: a converter of {} bits whose values were shifted to the "
        "left; quantisation: {{bits: {}}} says so, or divide them and say camera: {{bits: {}}}",
        1 << (16 - bits), bits, bits, bits));
  }
  for (const int own : {10, 12, 14}) {
    if (data.file_bits != 16 || top != (1u << own) - 1) continue;
    facts.notes.push_back(fmt::format(
        "no value is above {}, where many stand: a converter of {} bits; camera: {{bits: {}}} says "
        "so, saturation: {{full_dn: {}}} does the same",
        top, own, own, top));
  }
}

void note_lights(const CsvTable& table, PhotometryData& data, Facts& facts) {
  if (const auto odd = odd_frames(data); !odd.empty()) {
    const OddFrame& first = odd.front();
    facts.notes.push_back(fmt::format(
        "{}:{}: this frame is {:.4g} DN above dark, that of line {} with the same light and "
        "exposure {:.4g} ({} frames are so): exposure_s or illumination is not its own, unless the "
        "lamp flickers",
        table.file(), table.line(first.frame), first.above_dark, table.line(first.other),
        first.as_the_level, odd.size()));
  }
  for (const BrightDark& bright : bright_darks(data)) {
    const auto frame = static_cast<size_t>(data.levels[bright.level].frames.front());
    facts.notes.push_back(fmt::format(
        "{}:{}: no light by illumination {:g} and exposure {:g} s, and {:.4g} DN more than other "
        "frames without light: exposure_s or illumination is not its own",
        table.file(), table.line(frame), data.levels[bright.level].illumination,
        data.levels[bright.level].exposure_s, bright.above_dark));
  }
  if (const auto fall = falling_lights(data)) {
    const auto line = [&](size_t level) {
      return table.line(static_cast<size_t>(data.levels[level].frames.front()));
    };
    facts.notes.push_back(fmt::format(
        "{}:{}: {:.4g} DN above dark, where line {} with less light stated has {:.4g} DN: "
        "more than a quarter of the levels fall so: exposure_s or illumination belongs to other "
        "pictures",
        table.file(), line(fall->level), fall->above_dark, line(fall->other), fall->other_above));
  }
  for (const WrongLight& wrong : wrong_lights(data)) {
    PhotometryLevel& level = data.levels[wrong.level];
    facts.notes.push_back(fmt::format(
        "{}:{}: illumination {:g} at exposure {:g} s: this level had {:.3g} % {} light (+- {:.1g} "
        "%) than stated, if the other levels are right; its light is estimated instead",
        table.file(), table.line(static_cast<size_t>(level.frames.front())), level.illumination,
        level.exposure_s, 100 * std::abs(wrong.ratio - 1), wrong.ratio > 1 ? "more" : "less",
        100 * wrong.sigma));
    level.illumination = std::nan("");
  }
}

}  // namespace

PhotometryData read_photometry(const MeasurementSet& set, Facts& facts) {
  const CsvTable table = set.table("frames");
  PhotometryData data = read_photometry_frames(set, table);
  FrameReader reader(set, table, data);
  reader.read_all();
  sum_rows(data);
  data.fewest_bits = fewest_bits(data.images, data.file_bits);
  facts.set.kind = effects::kPhotometry;
  facts.title = set.title;
  facts.fingerprint = reader.fingerprint();
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
  if (data.sensor_width_px > 0) {
    facts.notes.push_back(fmt::format(
        "{} of {} rows and {} of {} columns, spread over the image, stand for all in the fits",
        data.height_px, data.sensor_height_px, data.width_px, data.sensor_width_px));
  }
  facts.figures = emva_figures(data);
  if (const double share = darks_cut_off(data); share > 0 && !facts.figures.figures.empty()) {
    facts.notes.push_back(fmt::format(
        "{}: {:.0f} % of the values of dark frames are 0, where they are cut off: what rests on "
        "dark frames is left out, and the gain K is that of the lit ones alone; raise the black "
        "level of the camera",
        facts.figures.title, 100 * share));
  }
  note_bits(data, facts);
  note_lights(table, data, facts);
  return data;
}

}  // namespace seam::measurement
