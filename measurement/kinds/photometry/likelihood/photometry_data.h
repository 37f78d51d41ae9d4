// Stacks of flat fields and dark frames: the images of a photometry set and what they say about
// each level of light, reduced to sums that the likelihood needs (photometry_likelihood.h).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "measurement/problem/problem.h"
#include "measurement/sets/set.h"
#include "sim_core/base/image.h"

namespace seam::measurement {

// Frames of one level see the same scene with the same exposure and gain.
struct PhotometryLevel {
  double illumination = 0;  // NaN where the set leaves it blank: then it is a nuisance.
  double exposure_s = 0;
  double exposure_ratio = 1;  // To the first frame of the set.
  double gain = 1;
  std::vector<int> frames;
};

struct PhotometryFrame {
  int level = 0;
  double time_s = 0;
};

// Images of a set, interleaved as in the files; sample = (v * width + u) * channels + channel.
struct PhotometryData {
  int width_px = 0;
  int height_px = 0;
  int channels = 1;
  int file_bits = 8;
  int fewest_bits = 1;  // Of a converter that can have made the values.
  double frame_period_s = 0;
  std::vector<PhotometryFrame> frames;
  std::vector<PhotometryLevel> levels;
  std::vector<std::vector<uint16_t>> images;  // By frame.
  std::vector<std::vector<double>> row_mean;  // By frame, then row * channels + channel.

  size_t samples() const { return static_cast<size_t>(width_px) * height_px * channels; }
  size_t rows() const { return static_cast<size_t>(height_px) * channels; }
  // 1 (green) for grey images.
  int colour(int channel) const { return channels == 1 ? 1 : channel; }
};

// The frames and levels of a set without its images (a protocol).
PhotometryData read_photometry_frames(const MeasurementSet& set, const CsvTable& table);
PhotometryData read_photometry(const MeasurementSet& set, Facts& facts);

// Sums over some of a level's frames.
struct LevelSums {
  std::vector<int> frames;
  std::vector<double> mean;      // By sample: mean over the frames.
  std::vector<double> row_mean;  // By row * channels + channel: the mean of `mean` over the row.
  // By sample: sum over frames of (dn - mean - (row mean of the frame - row mean))^2.
  std::vector<double> scatter;
};

struct PhotometrySums {
  std::vector<LevelSums> levels;  // Those without frames here have an empty `frames`.
  int64_t values = 0;             // dn values that were summed.
  uint64_t id = 0;                // The same for the same frames of a set.
};

// Whether row noise and column offsets are the same in all channels, as far as the images tell;
// true for grey images and where there is neither.
bool channels_share_offsets(const PhotometryData& data, const PhotometrySums& all);

PhotometrySums sum_frames(const PhotometryData& data, const Groups& groups,
                          const std::vector<int>& group_of_frame);

}  // namespace seam::measurement
