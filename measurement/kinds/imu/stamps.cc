#include "measurement/kinds/imu/stamps.h"

#include <algorithm>
#include <cmath>

namespace seam::measurement {
namespace {

constexpr size_t kBlocks = 20;        // Of a part.
constexpr double kClosest_ppm = 0.1;  // By which a clock changes when it warms up by a kelvin.

struct Line {
  double count = 0, slope = 0, square = 0;  // Of samples' numbers about their mean.
};

Line line_through(const std::vector<double>& number, const std::vector<double>& late_s) {
  Line line{.count = static_cast<double>(number.size())};
  double mean = 0, mean_late = 0;
  for (size_t i = 0; i < number.size(); ++i) mean += number[i], mean_late += late_s[i];
  mean /= line.count, mean_late /= line.count;
  for (size_t i = 0; i < number.size(); ++i) {
    line.square += (number[i] - mean) * (number[i] - mean);
    line.slope += (number[i] - mean) * (late_s[i] - mean_late);
  }
  line.slope /= line.square;
  return line;
}

}  // namespace

std::vector<StampPart> stamps_of(const ImuStretch& stretch, size_t parts, double rate_hz) {
  const std::vector<double>& stamp_s = stretch.stamp_s;
  const size_t n = stamp_s.size(), blocks = parts * std::min(kBlocks, n / (3 * parts));
  std::vector<std::vector<double>> number(parts), late_s(parts);
  std::vector<StampPart> out(parts);
  double all = 0, count = 0;
  for (size_t b = 0; b < blocks; ++b) {
    const size_t part = b % parts, to = (b + 1) * n / blocks;
    for (size_t i = b * n / blocks; i < to; ++i) {
      number[part].push_back(static_cast<double>(i));
      late_s[part].push_back(stamp_s[i] - static_cast<double>(i) / rate_hz);
    }
    // The second difference of three stamps shows neither when they began nor how fast they go.
    for (size_t i = b * n / blocks; i + 3 <= to; i += 3) {
      const double bent = stamp_s[i] - 2 * stamp_s[i + 1] + stamp_s[i + 2];
      out[part].variance_s2 += bent * bent / 6, ++out[part].freedom;
    }
  }
  for (StampPart& part : out) {
    all += part.variance_s2, count += part.freedom;
    part.variance_s2 /= part.freedom;
  }
  const double scatter = std::max(kEvenStamps_s * kEvenStamps_s, all / count);
  for (size_t part = 0; part < parts; ++part) {
    const Line line = line_through(number[part], late_s[part]);
    const double slower = line.slope * rate_hz;  // Of the distance of samples, relative.
    out[part].drift_ppm = 1e6 * (1 / (1 + slower) - 1);
    out[part].drift_variance =
        1e12 * scatter * rate_hz * rate_hz / line.square + kClosest_ppm * kClosest_ppm;
    if (!(all / count > kEvenStamps_s * kEvenStamps_s)) out[part].freedom = 0;
  }
  return out;
}

}  // namespace seam::measurement
