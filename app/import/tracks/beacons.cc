#include "app/import/tracks/beacons.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace seam::app {
namespace {

constexpr std::array kOfSightings = {"block", "time_s", "landmark", "range_m", "bearing_rad"};

// Further columns that every row has; those whose names mean something else in a set are not kept.
std::vector<std::string> kept_beside(const BeaconLog& log) {
  std::vector<std::string> kept;
  for (const auto& [name, value] : log.seen.front().beside) {
    const bool ours = name == "run" || std::find(kOfSightings.begin(), kOfSightings.end(), name) !=
                                           kOfSightings.end();
    const bool whole = std::all_of(log.seen.begin(), log.seen.end(),
                                   [&](const Sighting& one) { return one.beside.contains(name); });
    if (whole && !ours) kept.push_back(name);
  }
  return kept;
}

void write_places(const BeaconLog& log, SetDraft& draft) {
  measurement::CsvWriter landmarks(log.has_heights
                                       ? std::vector<std::string>{"landmark", "x_m", "y_m", "z_m"}
                                       : std::vector<std::string>{"landmark", "x_m", "y_m"});
  for (const Beacon& beacon : log.beacons) {
    std::vector<std::string> cells = {beacon.name, exact(beacon.x_m), exact(beacon.y_m)};
    if (log.has_heights) cells.push_back(exact(beacon.z_m));
    landmarks.row(cells);
  }
  draft.add_table("landmarks", landmarks);
}

void write_poses(const BeaconLog& log, SetDraft& draft) {
  const std::vector<TrackPose>& path = log.path.poses;
  const bool heights = log.has_heights && log.path.has_heights;
  std::vector<std::string> columns = {"time_s", "x_m", "y_m", "theta_rad"};
  if (heights) columns.emplace_back("z_m");
  measurement::CsvWriter poses(columns);
  const bool needs_headings = log.any(&Sighting::bearing_rad);
  double heading = 0;
  bool warned = false;
  for (size_t i = 0; i < path.size(); ++i) {
    const TrackPose& p = path[i];
    if (i > 0 && p.ns == path[i - 1].ns) continue;
    // Bearings need a heading, not a guess.
    if (std::isnan(p.theta_rad) && needs_headings) continue;
    if (std::isnan(p.theta_rad)) {
      warned = true;
      if (i + 1 < path.size() && (path[i + 1].x_m != p.x_m || path[i + 1].y_m != p.y_m))
        heading = std::atan2(path[i + 1].y_m - p.y_m, path[i + 1].x_m - p.x_m);
    }
    std::vector<std::string> cells = {seconds_text(p.ns - path.front().ns), exact(p.x_m),
                                      exact(p.y_m),
                                      exact(std::isnan(p.theta_rad) ? heading : p.theta_rad)};
    if (heights) cells.push_back(exact(p.z_m));
    poses.row(cells);
  }
  draft.add_table("poses", poses);
  if (warned)
    draft.could_not_know("where the robot looked: taken along its path, ranges need it not");
}

}  // namespace

bool BeaconLog::any(double Sighting::*measured) const {
  return std::any_of(seen.begin(), seen.end(),
                     [&](const Sighting& one) { return !std::isnan(one.*measured); });
}

void draft_beacons(const BeaconLog& log, SetDraft& draft) {
  const int64_t start = log.path.poses.front().ns;
  // Blocks of time are held out whole: some twenty.
  const int64_t block = std::max<int64_t>(1, (log.seen.back().ns - start) / 20 + 1);
  const auto cell = [](double value) { return std::isnan(value) ? "" : exact(value); };
  const std::vector<std::string> beside = kept_beside(log);
  std::vector<std::string> columns = {kOfSightings.begin(), kOfSightings.end()};
  columns.insert(columns.end(), beside.begin(), beside.end());
  measurement::CsvWriter observations(columns);
  size_t ranges = 0, bearings = 0;
  for (const Sighting& one : log.seen) {
    std::vector<std::string> cells = {fmt::format("{}", (one.ns - start) / block),
                                      seconds_text(one.ns - start), one.beacon, cell(one.range_m),
                                      cell(one.bearing_rad)};
    for (const std::string& name : beside) cells.push_back(exact(one.beside.at(name)));
    observations.row(cells);
    ranges += !std::isnan(one.range_m), bearings += !std::isnan(one.bearing_rad);
  }
  draft.kind = "landmarks";
  draft.group = "block";
  draft.effects = "  ideal_detector: {}\n";
  write_places(log, draft);
  write_poses(log, draft);
  draft.add_table("observations", observations);
  draft.did(
      fmt::format("{} to {} beacons from {} places of the path, times from {} s on, in "
                  "blocks of {:.3g} s that are held out whole",
                  bearings == 0 ? fmt::format("{} ranges", ranges)
                  : ranges == 0 ? fmt::format("{} bearings", bearings)
                                : fmt::format("{} ranges and {} bearings", ranges, bearings),
                  log.beacons.size(), log.path.poses.size(), seconds_text(start),
                  1e-9 * static_cast<double>(block)));
  if (!beside.empty()) draft.did(fmt::format("kept beside them: {}", fmt::join(beside, ", ")));
  draft.could_not_know("the noise of what was measured: it is estimated");
  if (ranges == 0) return;
  if (!log.has_heights)
    draft.could_not_know(
        "the height of the beacons: all lies in a plane (a column z of the "
        "beacons, and of the path, says it)");
  else if (!log.path.has_heights)
    draft.could_not_know(
        "the height of what measures: taken at z = 0 of the beacons' heights (a "
        "column z of the path says it)");
}

}  // namespace seam::app
