// Faults of ranges and bearings: units, axes exchanged.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "measurement/check/fault_parts.h"
#include "measurement/numerics/robust.h"

namespace seam::measurement {
namespace {

struct Ranges {
  Numbers range, bearing;  // Not a number where blank.
  Numbers x, y, theta;     // Where the robot was.
  Numbers beacon_x, beacon_y;
  Numbers above;  // The beacon's height over the robot; 0 where the set states none.
  Rows beacon;    // Its row in the table of places.

  // The median of | range - distance |, with x and y of the beacons as they stand or exchanged.
  double miss(bool exchanged) const {
    Numbers misses;
    for (size_t i = 0; i < range.size(); ++i) {
      if (!std::isnan(range[i])) misses.push_back(std::abs(range[i] - distance(i, exchanged)));
    }
    return median_of(misses);
  }
  // The same of bearings, with these factors on headings and on what was seen.
  double bearing_miss(double of_heading, double of_bearing) const {
    Numbers misses;
    for (size_t i = 0; i < bearing.size(); ++i) {
      if (std::isnan(bearing[i])) continue;
      const double towards = std::atan2(beacon_y[i] - y[i], beacon_x[i] - x[i]);
      misses.push_back(std::abs(std::remainder(
          of_bearing * bearing[i] - (towards - of_heading * theta[i]), 2 * std::numbers::pi)));
    }
    return misses.empty() ? 0 : median_of(misses);
  }
  double distance(size_t i, bool exchanged) const {
    const double bx = exchanged ? beacon_y[i] : beacon_x[i];
    const double by = exchanged ? beacon_x[i] : beacon_y[i];
    return std::hypot(std::hypot(bx - x[i], by - y[i]), above[i]);
  }
};

Ranges ranges_of(const MeasurementSet& set, const CsvTable& seen) {
  const CsvTable places = set.table("landmarks"), poses = set.table("poses");
  std::map<std::string, size_t, std::less<>> beacon;
  for (size_t row = 0; row < places.rows(); ++row)
    beacon[std::string(places.cell(row, "landmark"))] = row;
  const Numbers bx = places.numbers("x_m"), by = places.numbers("y_m");
  const auto heights = [&](const CsvTable& table) {
    return places.has("z_m") && table.has("z_m") ? table.numbers("z_m") : Numbers(table.rows(), 0);
  };
  const Numbers bz = heights(places), pz = heights(poses);
  const Numbers px = poses.numbers("x_m"), py = poses.numbers("y_m");
  const auto pose_times = poses.times_ns("time_s"), times = seen.times_ns("time_s");
  const auto column = [&](const char* name) {
    return seen.has(name) ? seen.numbers_or_blank(name) : Numbers(seen.rows(), NAN);
  };
  const Numbers range = column("range_m"), bearing = column("bearing_rad");
  const Numbers ptheta = poses.numbers("theta_rad");
  const auto tracks = rows_by(poses, {"run"});
  Ranges found;
  for (size_t row = 0; row < seen.rows(); ++row) {
    const auto known = beacon.find(seen.cell(row, "landmark"));
    if (known == beacon.end()) continue;
    const auto track = tracks.find(
        seen.has("run") && poses.has("run") ? fmt::format("run {}", seen.cell(row, "run")) : "");
    if (track == tracks.end()) continue;
    const Rows& rows = track->second;
    auto next = std::lower_bound(rows.begin(), rows.end(), times[row],
                                 [&](size_t r, int64_t t) { return pose_times[r] < t; });
    if (next == rows.end()) --next;
    found.range.push_back(range[row]), found.bearing.push_back(bearing[row]);
    found.theta.push_back(ptheta[*next]);
    found.x.push_back(px[*next]), found.y.push_back(py[*next]);
    found.beacon_x.push_back(bx[known->second]), found.beacon_y.push_back(by[known->second]);
    found.above.push_back(bz[known->second] - pz[*next]);
    found.beacon.push_back(known->second);
  }
  return found;
}

constexpr size_t kFewest = 20;

// Headings or bearings in another unit, or counted to the other side.
void tell_bearings(const Ranges& ranges, const MeasurementSet& set,
                   std::vector<std::string>& found) {
  constexpr double kMost_rad = 0.1, kBetter = 3;
  const auto known = std::count_if(ranges.bearing.begin(), ranges.bearing.end(),
                                   [](double bearing) { return !std::isnan(bearing); });
  const double as_it_stands = ranges.bearing_miss(1, 1);
  if (known < static_cast<std::ptrdiff_t>(kFewest) || as_it_stands < kMost_rad) return;
  struct Reading {
    double of_heading, of_bearing;
    const char* text;
  };
  for (const Reading& reading : {Reading{1 / kDegrees, 1, "theta_rad of the poses read as degrees"},
                                 {1, 1 / kDegrees, "bearing_rad read as degrees"},
                                 {1, -1, "bearing_rad counted to the other side (expected: left)"},
                                 {-1, 1, "theta_rad of the poses counted to the other side"}}) {
    const double miss = ranges.bearing_miss(reading.of_heading, reading.of_bearing);
    if (kBetter * miss > as_it_stands) continue;
    found.push_back(fmt::format("{}: bearings miss by {:.3g} rad, and by {:.3g} rad with {}",
                                set.table("observations").file(), as_it_stands, miss,
                                reading.text));
    return;
  }
}

// Landmarks at the very place of another: nobody measured where they stand.
void tell_shared_places(const CsvTable& places, std::vector<std::string>& found) {
  const Numbers x = places.numbers("x_m"), y = places.numbers("y_m"),
                z = places.has("z_m") ? places.numbers("z_m") : Numbers(places.rows(), 0);
  std::map<std::array<double, 3>, size_t> first;
  size_t shared = 0;
  std::string told;
  for (size_t row = 0; row < places.rows(); ++row) {
    const auto [other, is_new] = first.try_emplace({x[row], y[row], z[row]}, row);
    if (is_new || shared++ > 0) continue;
    told =
        fmt::format("{}: landmark {} stands at {:g}, {:g}, the very place of landmark {} (line {})",
                    place(places, row), places.cell(row, "landmark"), x[row], y[row],
                    places.cell(other->second, "landmark"), places.line(other->second));
  }
  if (shared > 0)
    found.push_back(
        fmt::format("{}{}: placeholders for places that were not measured?", told,
                    shared > 1 ? fmt::format(", and so do {} others", shared - 1) : ""));
}

// A landmark at the origin whose ranges miss by far more than those of all others: nobody measured
// where it stands.
void tell_placeholders(const Ranges& ranges, const CsvTable& places,
                       std::vector<std::string>& found) {
  constexpr double kFarther = 10;
  const Numbers x = places.numbers("x_m"), y = places.numbers("y_m");
  for (size_t row = 0; row < places.rows(); ++row) {
    if (x[row] != 0 || y[row] != 0) continue;
    Numbers own, others;
    for (size_t i = 0; i < ranges.range.size(); ++i) {
      if (std::isnan(ranges.range[i])) continue;
      (ranges.beacon[i] == row ? own : others)
          .push_back(std::abs(ranges.range[i] - ranges.distance(i, false)));
    }
    if (own.size() < kFewest || others.size() < kFewest) continue;
    const double miss = median_of(own), usual = median_of(others);
    if (miss < kFarther * usual) continue;
    found.push_back(fmt::format(
        "{}: landmark {} stands at 0, 0 and its ranges miss by {:.3g} m, those of the others by "
        "{:.3g} m: a placeholder for a place that was not measured?",
        place(places, row), places.cell(row, "landmark"), miss, usual));
  }
}

}  // namespace

void landmark_faults(const MeasurementSet& set, std::vector<std::string>& found) {
  const CsvTable seen = set.table("observations");
  if (seen.has("bearing_rad")) {
    const Numbers bearings = seen.numbers_or_blank("bearing_rad");
    for (size_t row = 0; row < bearings.size(); ++row) {
      if (!(std::abs(bearings[row]) > 2 * std::numbers::pi)) continue;
      found.push_back(fmt::format("{}: bearing_rad is {:g}, more than a turn: degrees for radians",
                                  place(seen, row), bearings[row]));
      break;
    }
  }
  const Ranges ranges = ranges_of(set, seen);
  const bool in_degrees = !found.empty();
  tell_shared_places(set.table("landmarks"), found);
  if (!in_degrees) tell_bearings(ranges, set, found);
  Numbers ratios, distances;
  for (size_t i = 0; i < ranges.range.size(); ++i) {
    if (std::isnan(ranges.range[i])) continue;
    distances.push_back(ranges.distance(i, false));
    if (distances.back() > 0) ratios.push_back(ranges.range[i] / distances.back());
  }
  if (ratios.size() < kFewest) return;
  const double ratio = median_of(ratios);
  for (const auto& [of, columns] : {std::pair{ratio, "range_m"}, {1 / ratio, "the places"}}) {
    if (const auto unit = unit_of_ratio(of, 1000, "millimetres", "metres"); !unit.empty())
      found.push_back(
          fmt::format("{}: ranges are {:.4g} times the distances of the places: {} in {}",
                      seen.file(), ratio, unit, columns));
  }
  tell_placeholders(ranges, set.table("landmarks"), found);
  const double as_it_stands = ranges.miss(false), exchanged = ranges.miss(true);
  if (as_it_stands > 0.1 * median_of(distances) && 3 * exchanged < as_it_stands)
    found.push_back(fmt::format(
        "{}: ranges miss by {:.3g} m, and by {:.3g} m with x_m and y_m of the landmarks exchanged",
        set.table("landmarks").file(), as_it_stands, exchanged));
}

void range_faults(const MeasurementSet& set, std::vector<std::string>& found) {
  const CsvTable table = set.table("ranges");
  if (!has_all(table, {"true_m", "measured_m"})) return;
  const Numbers truth = table.numbers_or_blank("true_m"),
                seen = table.numbers_or_blank("measured_m");
  Numbers ratios;
  for (size_t row = 0; row < truth.size(); ++row) {
    if (truth[row] > 0 && seen[row] > 0) ratios.push_back(seen[row] / truth[row]);
  }
  if (ratios.empty()) return;
  const double ratio = median_of(ratios);
  for (const auto& [of, column] : {std::pair{ratio, "measured_m"}, {1 / ratio, "true_m"}}) {
    if (const auto unit = unit_of_ratio(of, 1000, "millimetres", "metres"); !unit.empty())
      found.push_back(
          fmt::format("{}: {} is {:.4g} times the other: {}", table.file(), column, of, unit));
  }
}

}  // namespace seam::measurement
