// `seam import ranges`: distances and bearings to beacons at known places from a robot on a known
// path, as the Plaza data sets' MAT-files or as CSV.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "app/import/draft/checks.h"
#include "app/import/files/mat_file.h"
#include "app/import/files/text_table.h"
#include "app/import/kinds/kinds.h"
#include "app/import/tracks/beacons.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

class RangesImport {
 public:
  RangesImport(const ImportRequest& request, SetDraft& draft)
      : request_(request),
        draft_(draft),
        metres_(request.length_unit.empty() ? 1 : metres_in(request.length_unit)) {}

  void run();

 private:
  void read_mat(const std::filesystem::path& path);
  void read_table(const TextTable& table);
  void read_sightings(const TextTable& table, int time, int beacon, int range, int bearing);
  void read_beacons(const TextTable& table, int name, const TrackColumns& columns);
  void leave_out_blanks();
  bool any(double Sighting::*measured) const;
  void lay_in_plane();
  void check_order();
  void check_sightings();
  void check_ranges();
  double misses(bool exchanged, double scale) const;
  TrackPose at(int64_t ns) const;

  const ImportRequest& request_;
  SetDraft& draft_;
  double metres_;
  std::vector<TextTable> tables_;
  BeaconLog log_;
};

std::string beacon_name(double number) {
  const bool whole = number == std::floor(number) && std::abs(number) < 1e15;
  return whole ? fmt::format("{}", static_cast<int64_t>(number)) : fmt::format("{}", number);
}

// 9 in one table is 9.0 in another.
std::string beacon_name(std::string_view cell) {
  double number = 0;
  return parse_number(cell, number) ? beacon_name(number) : std::string(cell);
}

// Seconds of a MAT-file as nanoseconds.
int64_t ns_of(double seconds, const MatFile& mat, const std::string& array, size_t row) {
  if (!(std::abs(seconds) < 9e9))
    throw InputError(fmt::format("{}: {}({}, 1): found {}, expected a time in seconds", mat.file(),
                                 array, row + 1, seconds));
  return std::llround(seconds * 1e9);
}

void RangesImport::read_mat(const std::filesystem::path& path) {
  const MatFile mat = MatFile::read(path);
  const auto table = [&](const std::string& quantity, const std::string& usual, size_t columns) {
    const std::string mapped = request_.name_of(quantity);
    const std::string name = mapped.empty() ? usual : mapped;
    const MatArray& array = mat.at(name);
    if (array.columns < columns || array.rows == 0)
      throw InputError(fmt::format("{}: {}: found {} x {}, expected rows of {} numbers", mat.file(),
                                   name, array.rows, array.columns, columns));
    for (size_t c = 0; c < array.columns; ++c) {
      for (size_t row = 0; row < array.rows; ++row) {
        if (!std::isfinite(array.at(row, c)))
          throw InputError(fmt::format("{}: {}({}, {}): found {}, expected a finite number",
                                       mat.file(), name, row + 1, c + 1, array.at(row, c)));
      }
    }
    return std::pair<std::string, const MatArray*>(name, &array);
  };
  const auto [of_path, path_array] = table("path", "GT", 3);
  const auto [of_ranges, ranges_array] = table("ranges", "TD", 3);
  const auto [of_beacons, beacons_array] = table("beacons", "TL", 3);
  for (size_t row = 0; row < path_array->rows; ++row) {
    TrackPose pose{.ns = ns_of(path_array->at(row, 0), mat, of_path, row),
                   .x_m = metres_ * path_array->at(row, 1),
                   .y_m = metres_ * path_array->at(row, 2),
                   .place = fmt::format("{}: {}({}, 1)", mat.file(), of_path, row + 1)};
    if (path_array->columns > 3) pose.theta_rad = path_array->at(row, 3);
    log_.path.poses.push_back(std::move(pose));
  }
  log_.path.has_headings = path_array->columns > 3;
  // Time, [who asked,] the beacon, the range.
  const size_t last = std::min<size_t>(ranges_array->columns, 4) - 1;
  for (size_t row = 0; row < ranges_array->rows; ++row)
    log_.seen.push_back(
        {.ns = ns_of(ranges_array->at(row, 0), mat, of_ranges, row),
         .beacon = beacon_name(ranges_array->at(row, last - 1)),
         .range_m = metres_ * ranges_array->at(row, last),
         .place = fmt::format("{}: {}({}, {})", mat.file(), of_ranges, row + 1, last + 1)});
  for (size_t row = 0; row < beacons_array->rows; ++row)
    log_.beacons.push_back({beacon_name(beacons_array->at(row, 0)),
                            metres_ * beacons_array->at(row, 1),
                            metres_ * beacons_array->at(row, 2)});
}

// What a table is follows from its columns.
void RangesImport::read_table(const TextTable& table) {
  const TrackColumns columns = track_columns(table, request_);
  const int beacon = column_of(table, request_, "beacon",
                               {"landmark", "beacon", "anchor", "tag", "id", "node", "beacon_id",
                                "anchor_id", "landmark_id", "marker", "station"});
  const int range = column_of(
      table, request_, "range",
      {"range_m", "range", "distance", "distance_m", "dist", "r", "range_mm", "distance_mm"});
  const int bearing = column_of(table, request_, "bearing",
                                {"bearing_rad", "bearing", "bearing_deg", "azimuth", "aoa",
                                 "angle_of_arrival", "direction", "angle"});
  if (columns.time >= 0 && beacon >= 0 && (range >= 0 || bearing >= 0))
    return read_sightings(table, columns.time, beacon, range, bearing);
  if (columns.are_poses()) return read_track(table, columns, request_, "time", log_.path);
  if (beacon >= 0 && columns.x >= 0 && columns.y >= 0) return read_beacons(table, beacon, columns);
  throw InputError(fmt::format(
      "{}:1: expected columns time, beacon and range or bearing (what was measured), time, x and y "
      "(the path), or beacon, x and y (where the beacons are); say theirs with --map",
      table.file()));
}

void RangesImport::read_sightings(const TextTable& table, int time, int beacon, int range,
                                  int bearing) {
  const auto of = [](int column) { return static_cast<size_t>(column); };
  const int64_t unit = time_unit_of(request_, "time", table.full_name(of(time)));
  const double metres = range < 0 ? 0 : metres_of(request_, "range", table.full_name(of(range)));
  const double radians =
      bearing < 0 ? 0 : radians_of(request_, "bearing", table.full_name(of(bearing)));
  const std::vector<size_t> beside = numbers_beside(table, {time, beacon, range, bearing});
  for (size_t row = 0; row < table.rows(); ++row) {
    Sighting one{.ns = time_in(table, row, time, unit),
                 .beacon = beacon_name(table.cell(row, of(beacon))),
                 .place = fmt::format("{}:{}", table.file(), table.line(row))};
    if (range >= 0) one.range_m = metres * table.number_or_blank(row, of(range));
    if (bearing >= 0) one.bearing_rad = radians * table.number_or_blank(row, of(bearing));
    for (const size_t column : beside)
      one.beside[csv_word(table.column_name(column))] = table.number(row, column);
    log_.seen.push_back(std::move(one));
  }
}

void RangesImport::read_beacons(const TextTable& table, int name, const TrackColumns& columns) {
  const auto place = [&](size_t row, const char* axis, int column) {
    const auto at = static_cast<size_t>(column);
    return metres_of(request_, axis, table.full_name(at)) * table.number(row, at);
  };
  log_.has_heights = log_.has_heights || columns.z >= 0;
  for (size_t row = 0; row < table.rows(); ++row)
    log_.beacons.push_back({beacon_name(table.cell(row, static_cast<size_t>(name))),
                            place(row, "x", columns.x), place(row, "y", columns.y),
                            columns.z < 0 ? 0 : place(row, "z", columns.z)});
}

TrackPose RangesImport::at(int64_t ns) const {
  const std::vector<TrackPose>& path = log_.path.poses;
  const auto after = std::upper_bound(path.begin(), path.end(), ns,
                                      [](int64_t t, const TrackPose& p) { return t < p.ns; });
  if (after == path.begin()) return path.front();
  if (after == path.end()) return path.back();
  const TrackPose &a = *(after - 1), &b = *after;
  const double share = static_cast<double>(ns - a.ns) / static_cast<double>(b.ns - a.ns);
  return {.ns = ns,
          .x_m = a.x_m + share * (b.x_m - a.x_m),
          .y_m = a.y_m + share * (b.y_m - a.y_m),
          .z_m = a.z_m + share * (b.z_m - a.z_m)};
}

// The median of |range * scale - distance| with the beacons as they stand or x and y exchanged,
// once ranges that are all a little too long or short are put right.
double RangesImport::misses(bool exchanged, double scale) const {
  std::map<std::string, const Beacon*> place;
  for (const Beacon& beacon : log_.beacons) place[beacon.name] = &beacon;
  std::vector<double> ratios, distances, ranges;
  for (const Sighting& one : log_.seen) {
    if (std::isnan(one.range_m)) continue;
    const Beacon& b = *place.at(one.beacon);
    const TrackPose p = at(one.ns);
    distances.push_back(std::hypot(p.x_m - (exchanged ? b.y_m : b.x_m),
                                   p.y_m - (exchanged ? b.x_m : b.y_m),
                                   log_.has_heights ? p.z_m - b.z_m : 0));
    ranges.push_back(one.range_m);
    ratios.push_back(one.range_m * scale / std::max(distances.back(), 1e-9));
  }
  const double ratio = std::clamp(measurement::median_of(ratios), 0.8, 1.25);
  std::vector<double> found;
  for (size_t i = 0; i < ranges.size(); ++i)
    found.push_back(std::abs(ranges[i] * scale / ratio - distances[i]));
  return measurement::median_of(found);
}

// A path that flies among beacons is kept where their heights are known; bearings are angles in
// the plane, whatever the heights.
void RangesImport::lay_in_plane() {
  Track asked = log_.path;
  if (log_.has_heights) {
    for (TrackPose& pose : asked.poses) pose.z_m = 0;
  }
  if (!log_.any(&Sighting::bearing_rad)) asked.has_tilts = false;
  const std::string lost = laid_on_plane(
      asked, log_.has_heights
                 ? "bearings are angles in the plane: expected a body that stays upright"
                 : "expected the beacons' heights, too: a column z of the beacons");
  if (!lost.empty()) draft_.did(lost);
}

void RangesImport::check_order() {
  if (log_.seen.empty() || log_.beacons.empty() || log_.path.poses.empty())
    throw InputError(fmt::format(
        "{}: found {} ranges or bearings, {} beacons and {} places of the path, expected some of "
        "each",
        request_.sources.front().string(), log_.seen.size(), log_.beacons.size(),
        log_.path.poses.size()));
  std::vector<int64_t> times;
  for (const TrackPose& pose : log_.path.poses) times.push_back(pose.ns);
  check_times(
      times, [&](size_t i) { return log_.path.poses[i].place; }, request_, 30, draft_);
  std::stable_sort(log_.seen.begin(), log_.seen.end(),
                   [](const Sighting& a, const Sighting& b) { return a.ns < b.ns; });
  const size_t all = log_.seen.size();
  std::erase_if(log_.seen, [&](const Sighting& one) {
    return one.ns < times.front() || one.ns > times.back();
  });
  if (log_.seen.size() < all)
    draft_.warn(fmt::format("{} rows were measured before or after the path: left out",
                            all - log_.seen.size()));
  if (log_.seen.empty())
    throw InputError(fmt::format(
        "{}: nothing was measured while the robot was on its path, from {} to {} s: other clocks?",
        request_.sources.front().string(), seconds_text(times.front()),
        seconds_text(times.back())));
}

void RangesImport::check_sightings() {
  std::map<std::string, int> known;
  for (const Beacon& beacon : log_.beacons) {
    if (++known[beacon.name] > 1)
      throw InputError(fmt::format("{}: beacon '{}' stands twice",
                                   request_.sources.front().string(), beacon.name));
  }
  const bool unit_is_said = request_.unit_of("bearing", request_.unit) != "";
  for (const Sighting& one : log_.seen) {
    if (!known.contains(one.beacon))
      throw InputError(fmt::format("{}: beacon '{}' has no known place", one.place, one.beacon));
    if (one.range_m < 0)
      throw InputError(
          fmt::format("{}: found {}, expected a range of 0 or more", one.place, one.range_m));
    if (!unit_is_said && std::abs(one.bearing_rad) > 2 * std::numbers::pi)
      throw InputError(fmt::format(
          "{}: found a bearing of {}, more than a turn: degrees? Say it, --unit bearing=deg (or "
          "--unit bearing=rad)",
          one.place, one.bearing_rad));
  }
  if (log_.any(&Sighting::bearing_rad) && !log_.path.has_headings)
    throw InputError(fmt::format(
        "{}: bearings count from where the robot looks, and its path says no heading: expected a "
        "column theta (or a quaternion qw, qx, qy, qz) beside x and y",
        log_.path.poses.front().place));
}

void RangesImport::check_ranges() {
  if (!log_.any(&Sighting::range_m)) return;
  const double miss = misses(false, 1);
  if (misses(false, 1e-3) < 0.1 * miss && request_.unit_of("range", request_.length_unit).empty())
    throw InputError(fmt::format(
        "{}: ranges fit the places of the beacons when divided by 1000: millimetres beside metres; "
        "name the column range_mm, or bring all to one unit (--length-unit)",
        log_.seen.front().place));
  if (misses(true, 1) < 0.3 * miss)
    draft_.warn(
        fmt::format("with x and y of the beacons exchanged the ranges fit {:.1f} times "
                    "better: are the columns exchanged?",
                    miss / misses(true, 1)));
  draft_.did(fmt::format(
      "the ranges are off the known places by {:.3g} m (median, beside a common scale)", miss));
}

// Where nothing answered, loggers write nothing, nan or 0 for a range.
void RangesImport::leave_out_blanks() {
  const size_t all = log_.seen.size();
  for (Sighting& one : log_.seen) {
    if (one.range_m == 0) one.range_m = std::numeric_limits<double>::quiet_NaN();
  }
  std::erase_if(log_.seen, [](const Sighting& one) {
    return std::isnan(one.range_m) && std::isnan(one.bearing_rad);
  });
  const size_t blank = all - log_.seen.size();
  if (blank > 0)
    draft_.did(
        fmt::format("{} of {} rows are blank, nan or a range of 0: nothing was measured, left out",
                    blank, all));
}

void RangesImport::run() {
  for (const auto& source : request_.sources) {
    if (source.extension() == ".mat") {
      read_mat(source);
    } else {
      tables_.push_back(TextTable::read(source));
    }
  }
  if (!tables_.empty()) check_columns_met(request_, tables_);
  for (const TextTable& table : tables_) read_table(table);
  leave_out_blanks();
  check_order();
  check_sightings();
  lay_in_plane();
  check_ranges();
  draft_beacons(log_, draft_);
}

}  // namespace

void import_ranges(const ImportRequest& request, SetDraft& draft) {
  RangesImport(request, draft).run();
}

}  // namespace seam::app
