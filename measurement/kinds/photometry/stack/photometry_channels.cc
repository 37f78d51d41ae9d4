// Do the channels of a colour sensor share their row noise and column offsets?
#include <cmath>

#include "measurement/kinds/photometry/stack/photometry_data.h"

namespace seam::measurement {
namespace {

// Products of what should be equal within a channel, and between channels.
struct Agreement {
  double own = 0, across = 0, own_square = 0, count = 0;

  // The channels' own offsets are there, and do not go together.
  bool independent() const {
    if (count < 2) return false;
    const double error = std::sqrt(own_square / count) / std::sqrt(count);
    return own / count > 5 * error && across < 0.5 * own;
  }
};

// Means of a column over the upper or lower half of the rows, less those of its two neighbours:
// smooth fields vanish, offsets are the same in both halves.
double roughness(const PhotometryData& data, const std::vector<double>& mean, int u, int channel,
                 bool lower) {
  const int middle = data.height_px / 2;
  const int first = lower ? middle : 0, last = lower ? data.height_px : middle;
  const auto column = [&](int x) {
    double sum = 0;
    for (int v = first; v < last; ++v) {
      sum += mean[(static_cast<size_t>(v) * data.width_px + x) * data.channels + channel];
    }
    return sum / (last - first);
  };
  return column(u) - 0.5 * (column(u - 1) + column(u + 1));
}

Agreement columns(const PhotometryData& data, const LevelSums& level) {
  Agreement out;
  const int channels = data.channels;
  for (int u = 1; u + 1 < data.width_px; u += 2) {
    for (int c = 0; c < channels; ++c) {
      const double upper = roughness(data, level.mean, u, c, false);
      const double own = upper * roughness(data, level.mean, u, c, true);
      out.own += own, out.own_square += own * own, out.count += 1;
      out.across += upper * roughness(data, level.mean, u, (c + 1) % channels, true);
    }
  }
  return out;
}

// Changes of rows from frame to frame beyond what their samples' noise explains.
Agreement rows(const PhotometryData& data, const LevelSums& level) {
  Agreement out;
  const auto frames = static_cast<double>(level.frames.size());
  if (frames < 2) return out;
  double noise = 0;
  for (const double scatter : level.scatter)
    noise += scatter / (frames - 1) / static_cast<double>(level.scatter.size());
  const auto change = [&](int frame, size_t row) {
    return data.row_mean[frame][row] - level.row_mean[row];
  };
  for (const int frame : level.frames) {
    for (size_t row = 0; row < data.rows(); ++row) {
      const size_t other = row / data.channels * data.channels + (row + 1) % data.channels;
      const double d = change(frame, row);
      const double own = d * d - noise / data.width_px * (frames - 1) / frames;
      out.own += own, out.own_square += own * own, out.count += 1;
      out.across += d * change(frame, other);
    }
  }
  return out;
}

}  // namespace

bool channels_share_offsets(const PhotometryData& data, const PhotometrySums& all) {
  if (data.channels == 1 || data.width_px < 5 || data.height_px < 2) return true;
  Agreement total_columns, total_rows;
  const auto pool = [](Agreement& into, const Agreement& part) {
    into.own += part.own, into.across += part.across, into.own_square += part.own_square,
        into.count += part.count;
  };
  for (const LevelSums& level : all.levels) {
    if (level.frames.empty()) continue;
    pool(total_columns, columns(data, level));
    pool(total_rows, rows(data, level));
  }
  return !total_columns.independent() && !total_rows.independent();
}

}  // namespace seam::measurement
