// `seam import ranges`: distances to beacons at known places from a robot on a known path, as the
// Plaza data sets' MAT-files or as CSV.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "app/import/draft/checks.h"
#include "app/import/files/mat_file.h"
#include "app/import/files/text_table.h"
#include "app/import/kinds/kinds.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

struct Beacon {
  std::string name;
  double x_m = 0, y_m = 0;
};
struct PathPoint {
  int64_t ns = 0;
  double x_m = 0, y_m = 0, theta_rad = std::numeric_limits<double>::quiet_NaN();
};
struct Range {
  int64_t ns = 0;
  std::string beacon;
  double range_m = 0;
  std::string place;
};

class RangesImport {
 public:
  RangesImport(const ImportRequest& request, SetDraft& draft)
      : request_(request),
        draft_(draft),
        metres_(request.length_unit.empty() ? 1 : metres_in(request.length_unit)) {}

  void run();

 private:
  void read_mat(const std::filesystem::path& path);
  double metres_of(const TextTable& table, size_t column) const;
  void leave_out_blanks();
  void read_csv(const std::filesystem::path& path);
  int column(const TextTable& table, const std::string& quantity,
             std::vector<std::string> usual) const;
  void read_ranges(const TextTable& table, int time, int beacon, int range);
  void read_beacons(const TextTable& table, int name, int x, int y);
  void read_path(const TextTable& table, int time, int x, int y);
  void check();
  double misses(bool exchanged, double scale) const;
  PathPoint at(int64_t ns) const;
  void write();

  const ImportRequest& request_;
  SetDraft& draft_;
  double metres_;
  std::vector<Beacon> beacons_;
  std::vector<PathPoint> path_;
  std::vector<Range> ranges_;
  std::vector<std::string> path_places_;
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
    PathPoint point{ns_of(path_array->at(row, 0), mat, of_path, row),
                    metres_ * path_array->at(row, 1), metres_ * path_array->at(row, 2)};
    if (path_array->columns > 3) point.theta_rad = path_array->at(row, 3);
    path_.push_back(point);
    path_places_.push_back(fmt::format("{}: {}({}, 1)", mat.file(), of_path, row + 1));
  }
  // Time, [who asked,] the beacon, the range.
  const size_t last = std::min<size_t>(ranges_array->columns, 4) - 1;
  for (size_t row = 0; row < ranges_array->rows; ++row)
    ranges_.push_back({ns_of(ranges_array->at(row, 0), mat, of_ranges, row),
                       beacon_name(ranges_array->at(row, last - 1)),
                       metres_ * ranges_array->at(row, last),
                       fmt::format("{}: {}({}, {})", mat.file(), of_ranges, row + 1, last + 1)});
  for (size_t row = 0; row < beacons_array->rows; ++row)
    beacons_.push_back({beacon_name(beacons_array->at(row, 0)), metres_ * beacons_array->at(row, 1),
                        metres_ * beacons_array->at(row, 2)});
}

int RangesImport::column(const TextTable& table, const std::string& quantity,
                         std::vector<std::string> usual) const {
  const std::string mapped = request_.name_of(quantity);
  if (!mapped.empty()) usual.insert(usual.begin(), mapped);
  return table.find(usual);
}

// What a table is follows from its columns.
void RangesImport::read_csv(const std::filesystem::path& path) {
  const TextTable table = TextTable::read(path);
  const int time = column(table, "time",
                          {"time_s", "time", "timestamp", "t", "stamp", "time_ms", "time_ns",
                           "timestamp_ms", "timestamp_ns"});
  const int beacon =
      column(table, "beacon",
             {"landmark", "beacon", "anchor", "tag", "id", "node", "beacon_id", "anchor_id"});
  const int range = column(
      table, "range",
      {"range_m", "range", "distance", "distance_m", "dist", "r", "range_mm", "distance_mm"});
  const int x = column(table, "x", {"x_m", "x", "px", "pos_x", "tx"});
  const int y = column(table, "y", {"y_m", "y", "py", "pos_y", "ty"});
  if (time >= 0 && beacon >= 0 && range >= 0) return read_ranges(table, time, beacon, range);
  if (time >= 0 && x >= 0 && y >= 0) return read_path(table, time, x, y);
  if (beacon >= 0 && x >= 0 && y >= 0) return read_beacons(table, beacon, x, y);
  throw InputError(
      fmt::format("{}:1: expected columns time, beacon and range (ranges), time, x and y (the "
                  "path), or beacon, "
                  "x and y (where the beacons are); say theirs with --map",
                  table.file()));
}

// By the user's word, else by the column's.
double RangesImport::metres_of(const TextTable& table, size_t column) const {
  const std::string unit = length_unit_in(table.full_name(column));
  return request_.length_unit.empty() && !unit.empty() ? metres_in(unit) : metres_;
}

void RangesImport::read_ranges(const TextTable& table, int time, int beacon, int range) {
  const auto t = static_cast<size_t>(time), r = static_cast<size_t>(range);
  const int64_t unit = time_unit_ns(request_, table.full_name(t));
  const double metres = metres_of(table, r);
  for (size_t row = 0; row < table.rows(); ++row)
    ranges_.push_back({table.time_ns(row, t, unit),
                       beacon_name(table.cell(row, static_cast<size_t>(beacon))),
                       metres * table.number_or_blank(row, r),
                       fmt::format("{}:{}", table.file(), table.line(row))});
}

void RangesImport::read_beacons(const TextTable& table, int name, int x, int y) {
  for (size_t row = 0; row < table.rows(); ++row)
    beacons_.push_back(
        {beacon_name(table.cell(row, static_cast<size_t>(name))),
         metres_of(table, static_cast<size_t>(x)) * table.number(row, static_cast<size_t>(x)),
         metres_of(table, static_cast<size_t>(y)) * table.number(row, static_cast<size_t>(y))});
}

void RangesImport::read_path(const TextTable& table, int time, int x, int y) {
  const auto t = static_cast<size_t>(time);
  const int64_t unit = time_unit_ns(request_, table.full_name(t));
  const int theta = column(table, "theta", {"theta_rad", "theta", "yaw", "heading", "yaw_rad"});
  std::vector<double> angles;
  for (size_t row = 0; row < table.rows(); ++row) {
    path_.push_back(
        {table.time_ns(row, t, unit),
         metres_of(table, static_cast<size_t>(x)) * table.number(row, static_cast<size_t>(x)),
         metres_of(table, static_cast<size_t>(y)) * table.number(row, static_cast<size_t>(y))});
    path_places_.push_back(fmt::format("{}:{}", table.file(), table.line(row)));
    if (theta >= 0) angles.push_back(table.number(row, static_cast<size_t>(theta)));
  }
  // A heading that was never wrapped grows beyond any bound: the user alone knows its unit.
  const std::string unit_of_name =
      theta < 0 ? "" : angle_unit_in(table.full_name(static_cast<size_t>(theta)));
  const double radians = !request_.unit.empty() ? radians_in(request_.unit)
                         : unit_of_name.empty() ? 1
                                                : radians_in(unit_of_name);
  for (size_t i = 0; i < angles.size(); ++i)
    path_[path_.size() - angles.size() + i].theta_rad = radians * angles[i];
}

PathPoint RangesImport::at(int64_t ns) const {
  const auto after = std::upper_bound(path_.begin(), path_.end(), ns,
                                      [](int64_t t, const PathPoint& p) { return t < p.ns; });
  if (after == path_.begin()) return path_.front();
  if (after == path_.end()) return path_.back();
  const PathPoint &a = *(after - 1), &b = *after;
  const double share = static_cast<double>(ns - a.ns) / static_cast<double>(b.ns - a.ns);
  return {ns, a.x_m + share * (b.x_m - a.x_m), a.y_m + share * (b.y_m - a.y_m)};
}

// The median of |range * scale - distance| with the beacons as they stand or x and y exchanged,
// once ranges that are all a little too long or short are put right.
double RangesImport::misses(bool exchanged, double scale) const {
  std::map<std::string, const Beacon*> place;
  for (const Beacon& beacon : beacons_) place[beacon.name] = &beacon;
  std::vector<double> ratios, distances;
  for (const Range& range : ranges_) {
    const Beacon& b = *place.at(range.beacon);
    const PathPoint p = at(range.ns);
    distances.push_back(
        std::hypot(p.x_m - (exchanged ? b.y_m : b.x_m), p.y_m - (exchanged ? b.x_m : b.y_m)));
    ratios.push_back(range.range_m * scale / std::max(distances.back(), 1e-9));
  }
  const double ratio = std::clamp(measurement::median_of(ratios), 0.8, 1.25);
  std::vector<double> found;
  for (size_t i = 0; i < ranges_.size(); ++i)
    found.push_back(std::abs(ranges_[i].range_m * scale / ratio - distances[i]));
  return measurement::median_of(found);
}

void RangesImport::check() {
  if (ranges_.empty() || beacons_.empty() || path_.empty())
    throw InputError(fmt::format(
        "{}: found {} ranges, {} beacons and {} places of the path, expected some of each",
        request_.sources.front().string(), ranges_.size(), beacons_.size(), path_.size()));
  std::vector<int64_t> times;
  for (const PathPoint& point : path_) times.push_back(point.ns);
  check_times(
      times, [&](size_t i) { return path_places_[i]; }, request_, 30, draft_);
  std::stable_sort(ranges_.begin(), ranges_.end(),
                   [](const Range& a, const Range& b) { return a.ns < b.ns; });
  std::map<std::string, int> known;
  for (const Beacon& beacon : beacons_) {
    if (++known[beacon.name] > 1)
      throw InputError(fmt::format("{}: beacon '{}' stands twice",
                                   request_.sources.front().string(), beacon.name));
  }
  size_t away = 0;
  std::erase_if(ranges_, [&](const Range& range) {
    const bool outside = range.ns < times.front() || range.ns > times.back();
    away += outside;
    return outside;
  });
  if (away > 0)
    draft_.warn(fmt::format("{} ranges were taken before or after the path: left out", away));
  if (ranges_.empty())
    throw InputError(fmt::format(
        "{}: no range was taken while the robot was on its path, from {} to {} s: other clocks?",
        request_.sources.front().string(), seconds_text(times.front()),
        seconds_text(times.back())));
  for (const Range& range : ranges_) {
    if (!known.contains(range.beacon))
      throw InputError(
          fmt::format("{}: beacon '{}' has no known place", range.place, range.beacon));
    if (!(range.range_m >= 0))
      throw InputError(
          fmt::format("{}: found {}, expected a range of 0 or more", range.place, range.range_m));
  }
  const double miss = misses(false, 1);
  if (misses(false, 1e-3) < 0.1 * miss && request_.length_unit.empty())
    throw InputError(fmt::format(
        "{}: ranges fit the places of the beacons when divided by 1000: millimetres beside metres; "
        "name the column range_mm, or bring all to one unit (--length-unit)",
        ranges_.front().place));
  if (misses(true, 1) < 0.3 * miss)
    draft_.warn(
        fmt::format("with x and y of the beacons exchanged the ranges fit {:.1f} times "
                    "better: are the columns exchanged?",
                    miss / misses(true, 1)));
  draft_.did(fmt::format(
      "the ranges are off the known places by {:.3g} m (median, beside a common scale)", miss));
}

void RangesImport::write() {
  const int64_t start = path_.front().ns;
  measurement::CsvWriter landmarks({"landmark", "x_m", "y_m"});
  for (const Beacon& beacon : beacons_)
    landmarks.row({beacon.name, exact(beacon.x_m), exact(beacon.y_m)});
  measurement::CsvWriter poses({"time_s", "x_m", "y_m", "theta_rad"});
  double heading = 0;
  bool told = false;
  for (size_t i = 0; i < path_.size(); ++i) {
    const PathPoint& p = path_[i];
    if (i > 0 && p.ns == path_[i - 1].ns) continue;
    if (std::isnan(p.theta_rad)) {
      told = true;
      if (i + 1 < path_.size() && (path_[i + 1].x_m != p.x_m || path_[i + 1].y_m != p.y_m))
        heading = std::atan2(path_[i + 1].y_m - p.y_m, path_[i + 1].x_m - p.x_m);
    }
    poses.row({seconds_text(p.ns - start), exact(p.x_m), exact(p.y_m),
               exact(std::isnan(p.theta_rad) ? heading : p.theta_rad)});
  }
  // Blocks of time are held out whole: some twenty.
  const int64_t block = std::max<int64_t>(1, (ranges_.back().ns - start) / 20 + 1);
  measurement::CsvWriter observations({"block", "time_s", "landmark", "range_m", "bearing_rad"});
  for (const Range& range : ranges_)
    observations.row({fmt::format("{}", (range.ns - start) / block), seconds_text(range.ns - start),
                      range.beacon, exact(range.range_m), ""});
  draft_.kind = "landmarks";
  draft_.group = "block";
  draft_.effects = "  ideal_detector: {}\n";
  draft_.add_table("landmarks", landmarks);
  draft_.add_table("poses", poses);
  draft_.add_table("observations", observations);
  draft_.did(
      fmt::format("{} ranges to {} beacons from {} places of the path, times from {} s on, in "
                  "blocks of {:.3g} s that are held out whole",
                  ranges_.size(), beacons_.size(), path_.size(), seconds_text(start),
                  1e-9 * static_cast<double>(block)));
  if (told)
    draft_.could_not_know("where the robot looked: taken along its path, ranges need it not");
  draft_.could_not_know(
      "the noise of the ranges, and the height of the beacons: all lies in a plane");
}

// Where nothing answered, loggers write nothing, nan or 0.
void RangesImport::leave_out_blanks() {
  const size_t all = ranges_.size();
  std::erase_if(ranges_,
                [](const Range& range) { return range.range_m == 0 || std::isnan(range.range_m); });
  const size_t blank = all - ranges_.size();
  if (blank > 0)
    draft_.did(fmt::format("{} of {} ranges are blank, nan or 0: nothing was measured, left out",
                           blank, all));
}

void RangesImport::run() {
  for (const auto& source : request_.sources) {
    if (source.extension() == ".mat") {
      read_mat(source);
    } else {
      read_csv(source);
    }
  }
  leave_out_blanks();
  check();
  write();
}

}  // namespace

void import_ranges(const ImportRequest& request, SetDraft& draft) {
  RangesImport(request, draft).run();
}

}  // namespace seam::app
