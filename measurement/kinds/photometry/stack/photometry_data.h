// Stacks of flat fields and dark frames: the images of a photometry set and what they say about
// each level of light, reduced to sums that the likelihood needs (photometry_likelihood.h).
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "effects/stages/sensor/mixing.h"
#include "measurement/problem/problem.h"
#include "measurement/sets/set.h"
#include "sim_core/base/image.h"

namespace seam::measurement {

// What all samples of a level's frames say, as EMVA 1288 counts it; grey images alone.
struct LevelStatistics {
  int frames = 0;
  double samples = 0;
  double mean = 0;               // DN.
  double temporal_variance = 0;  // Of a sample in time beside the frames' own means, DN^2.
  double spatial_variance = 0;   // Of the samples' means over the frames, as measured, DN^2.
  double frame_scatter = 0;      // Variance of the frames' means, DN^2.
  double at_top = 0;             // Share of the values that stand at the file's highest.
  double at_zero = 0;            // Share of those that are 0.
};

// Frames of one level see the same scene with the same exposure and gain.
struct PhotometryLevel {
  double illumination = 0;  // NaN where the set leaves it blank: then it is a nuisance.
  double exposure_s = 0;
  double exposure_ratio = 1;  // To the first frame of the set.
  double gain = 1;
  // Photons that fall on a pixel during the exposure; NaN where the set does not say.
  double photons = std::numeric_limits<double>::quiet_NaN();
  std::vector<int> frames;
  LevelStatistics whole;  // Of all samples, kept or not.

  // Light that the sensor saw, in units of the illumination at the first frame's exposure.
  double light() const { return illumination * exposure_ratio * gain; }
  // Seconds for which a pixel's dark current counts, at gain 1.
  double dark_s() const { return exposure_s * gain; }
};

struct PhotometryFrame {
  int level = 0;
  double time_s = 0;
};

// Images of a set, interleaved as in the files; sample = (v * width + u) * channels + channel.
// Of large images some rows and columns are kept (`thinned`): a smaller sensor whose samples stand
// apart, for which every formula holds as it does for the whole.
struct PhotometryData {
  int width_px = 0;  // Columns and rows that are kept.
  int height_px = 0;
  int channels = 1;
  int file_bits = 8;    // Values are 0 to 2^file_bits - 1,
  int stored_bits = 8;  // in files of so many bits a sample.
  int fewest_bits = 1;  // Of a converter that can have made the values.
  // Least variances of clipped values (SetNoise), DN^2.
  double least_at_top_dn2 = 0, least_at_bottom_dn2 = 0;
  double frame_period_s = 0;
  std::vector<PhotometryFrame> frames;
  std::vector<PhotometryLevel> levels;
  std::vector<std::vector<uint16_t>> images;  // By frame.
  // The same without this filter over neighbours (`unmixed`); empty: as they are.
  effects::Mixing mixing;
  std::vector<std::vector<float>> unmixed_images;
  std::vector<std::vector<double>> row_mean;  // By frame, then row * channels + channel.
  // Where the kept columns and rows stand on the sensor; empty: all are kept.
  std::vector<int> column_px, row_px;
  int sensor_width_px = 0, sensor_height_px = 0;  // 0: that of the kept ones.

  size_t frame_count() const { return std::max(images.size(), unmixed_images.size()); }
  double value(size_t frame, size_t sample) const {
    return unmixed_images.empty() ? images[frame][sample] : unmixed_images[frame][sample];
  }
  size_t samples() const { return static_cast<size_t>(width_px) * height_px * channels; }
  size_t rows() const { return static_cast<size_t>(height_px) * channels; }
  // 1 (green) for grey images.
  int colour(int channel) const { return channels == 1 ? 1 : channel; }
  int column(int u) const { return column_px.empty() ? u : column_px[static_cast<size_t>(u)]; }
  int row(int v) const { return row_px.empty() ? v : row_px[static_cast<size_t>(v)]; }
  int sensor_width() const { return sensor_width_px > 0 ? sensor_width_px : width_px; }
  int sensor_height() const { return sensor_height_px > 0 ? sensor_height_px : height_px; }
};

// The frames and levels of a set without its images (a protocol).
PhotometryData read_photometry_frames(const MeasurementSet& set, const CsvTable& table);
// Where the camera's bits are not those of the files, `bits` of measurement.yaml counts.
int bits_of_set(const MeasurementSet& set, int stored_bits);
PhotometryData read_photometry(const MeasurementSet& set, Facts& facts);

// Rows and columns of at most so many samples a frame, spread over the image at uneven steps, so
// that no wave looks like another.
struct Thinning {
  std::vector<int> column_px, row_px;
};
Thinning thinning_of(int width_px, int height_px, int channels, double most_samples);
// The frames with those rows and columns alone (indices of `data`'s own).
PhotometryData thinned(const PhotometryData& data, const Thinning& kept);
// The frames as they were before this filter over neighbours.
PhotometryData unmixed(const PhotometryData& data, const effects::Mixing& mixing);
// Means of the rows of every image, into `row_mean`.
void sum_rows(PhotometryData& data);

// Sums over some of a level's frames.
struct LevelSums {
  std::vector<int> frames;
  std::vector<double> mean;      // By sample: mean over the frames.
  std::vector<double> row_mean;  // By row * channels + channel: the mean of the frames' rows.
  // By sample: sum over frames of (dn - mean - (row mean of the frame - row mean))^2.
  std::vector<double> scatter;
};

struct PhotometrySums {
  std::vector<LevelSums> levels;  // Those without frames here have an empty `frames`.
  int64_t values = 0;             // dn values that were summed.
  uint64_t id = 0;                // The same for the same frames of a set.
  // The means again, all levels of a sample side by side: cells of samples are summed so
  // (likelihood/photometry_cells.h).
  std::vector<size_t> present;    // The levels (k) that have frames.
  std::vector<double> reference;  // By k: what `by_sample` is taken from, the mean over samples.
  std::vector<double> by_sample;  // By sample * present levels + k.
};

// Fills `present`, `reference` and `by_sample`; once more where the levels' means have changed.
void set_side_by_side(PhotometrySums& sums);

// A part of the largest variance in time of any level.
double least_at_top(const PhotometryData& data, const PhotometrySums& all);
// A part of the largest variance in time of the brightest pixels of any dark level: those that are
// not cut off at 0.
double least_at_bottom(const PhotometryData& data, const PhotometrySums& all);

// Whether row noise and column offsets are the same in all channels, as far as the images tell;
// true for grey images and where there is neither.
bool channels_share_offsets(const PhotometryData& data, const PhotometrySums& all);

PhotometrySums sum_frames(const PhotometryData& data, const Groups& groups,
                          const std::vector<int>& group_of_frame);

}  // namespace seam::measurement
