// `seam import wheels`: what the wheels of a body say, or its velocities, beside where it was seen.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "app/import/draft/checks.h"
#include "app/import/draft/wheel_drive.h"
#include "app/import/files/text_table.h"
#include "app/import/kinds/kinds.h"
#include "app/import/tracks/track.h"
#include "app/import/tracks/wheel_columns.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

class WheelsImport {
 public:
  WheelsImport(const ImportRequest& request, SetDraft& draft)
      : request_(request), draft_(draft), of_poses_(request) {
    // Where the poses have columns or units of their own for times.
    for (auto* map : {&of_poses_.names, &of_poses_.own_units}) {
      const auto own = map->find("pose_time");
      if (own != map->end()) (*map)["time"] = own->second;
    }
    // Ticks a turn are the wheels', never headings'.
    if (request.unit.starts_with("ticks:")) of_poses_.unit.clear();
  }

  void run();

 private:
  struct File {
    TextTable table;
    MotionColumns motion;
    TrackColumns track;
    std::string stem;
  };

  void read_files();
  void say_what_is_left_out();
  bool moves(const File& file) const;
  void take_poses();
  void read_motion();
  void read_rows(const File& file);
  void join_clocks();
  void draft_velocities();
  void draft_wheels();
  void find_reading();
  std::vector<WheelReading> readings() const;

  const ImportRequest& request_;
  SetDraft& draft_;
  ImportRequest of_poses_;
  std::vector<File> files_;
  bool of_wheels_ = false, poses_apart_ = false, commands_apart_ = false;
  Track track_;
  Drive drive_;
  std::vector<VelocityCommand> velocities_;
  WheelUnit unit_;
};

// Whether a file says how the body moved: wheels go before velocities.
bool WheelsImport::moves(const File& file) const {
  if (of_wheels_) return file.motion.are_wheels();
  // A motion capture that gives velocities, too, says what happened, not what was commanded.
  return file.motion.are_velocities() && !(commands_apart_ && file.track.are_poses());
}

// Columns of numbers that are neither motion nor poses.
void WheelsImport::say_what_is_left_out() {
  std::set<std::string> names;
  for (const File& file : files_) {
    const MotionColumns& c = file.motion;
    std::set<int> taken = places_of(file.track);
    taken.insert({c.time, c.run, c.left, c.right, c.vx, c.vy, c.omega});
    name_beside(file.table, taken, names);
  }
  say_left_out(names,
               "an error that may depend on such a column shows once it stands in odometry.csv, "
               "with a number in every row",
               draft_);
}

void WheelsImport::read_files() {
  std::vector<TextTable> tables;
  for (const auto& source : request_.sources) tables.push_back(TextTable::read(source));
  check_columns_met(request_, tables);
  for (size_t i = 0; i < tables.size(); ++i) {
    File file{.table = std::move(tables[i]), .stem = csv_word(request_.sources[i].stem().string())};
    file.motion = motion_columns(file.table, request_);
    file.track = track_columns(file.table, of_poses_);
    of_wheels_ = of_wheels_ || file.motion.are_wheels();
    commands_apart_ = commands_apart_ || (file.motion.are_velocities() && !file.track.are_poses());
    files_.push_back(std::move(file));
  }
  // Motion capture in a file of its own goes before what the body thinks where it is.
  poses_apart_ = std::any_of(files_.begin(), files_.end(), [&](const File& file) {
    return file.track.are_poses() && !moves(file);
  });
  const bool any_moves =
      std::any_of(files_.begin(), files_.end(), [&](const File& file) { return moves(file); });
  const bool any_poses = std::any_of(files_.begin(), files_.end(),
                                     [](const File& file) { return file.track.are_poses(); });
  if (!any_moves)
    throw InputError(fmt::format(
        "{}:1: expected columns time, and left and right (what the wheels turned, or how fast) or "
        "vx and omega (the body's velocities); say theirs with --map left=NAME,right=NAME",
        files_.front().table.file()));
  if (!any_poses)
    throw InputError(fmt::format(
        "{}:1: expected columns time, x, y and theta (where the body was seen), here or in a file "
        "of their own; say theirs with --map",
        files_.front().table.file()));
}

void WheelsImport::take_poses() {
  std::vector<int64_t> times;
  std::stable_sort(track_.poses.begin(), track_.poses.end(),
                   [](const TrackPose& a, const TrackPose& b) { return a.ns < b.ns; });
  if (!track_.has_headings)
    throw InputError(fmt::format(
        "{}: the poses say no heading, expected a column theta or a quaternion qw, qx, qy, qz",
        track_.poses.empty() ? files_.front().table.file() : track_.poses.front().place));
  const std::string lost = laid_on_plane(track_, "expected a body on the ground");
  if (!lost.empty()) draft_.did(lost);
  for (const TrackPose& pose : track_.poses) {
    if (std::isnan(pose.theta_rad)) continue;
    if (!times.empty() && pose.ns == times.back()) continue;
    times.push_back(pose.ns);
    drive_.poses.push_back({pose.ns, pose.x_m, pose.y_m, pose.theta_rad});
  }
  if (drive_.poses.size() < 8)
    throw InputError(fmt::format("{}: found {} poses, expected 8 or more",
                                 files_.front().table.file(), drive_.poses.size()));
  std::vector<double> steps;
  for (size_t i = 1; i < times.size(); ++i)
    steps.push_back(static_cast<double>(times[i] - times[i - 1]));
  drive_.longest_gap_ns = std::max<int64_t>(
      drive_.longest_gap_ns, std::llround(std::min(1e18, 3 * measurement::median_of(steps))));
}

// The rows of one file; times that begin anew with a run or a file go on behind those before.
void WheelsImport::read_rows(const File& file) {
  const TextTable& table = file.table;
  const MotionColumns& c = file.motion;
  const auto at = [](int column) { return static_cast<size_t>(column); };
  const int64_t unit = time_unit_of(request_, "time", table.full_name(at(c.time)));
  Track inside;
  if (!poses_apart_) read_track(table, file.track, of_poses_, "time", inside);
  std::map<std::string, const TrackPose*> pose_of_place;
  for (const TrackPose& pose : inside.poses) pose_of_place[pose.place] = &pose;
  track_.has_headings = track_.has_headings || inside.has_headings;
  track_.has_heights = track_.has_heights || inside.has_heights;
  track_.has_tilts = track_.has_tilts || inside.has_tilts;
  std::vector<int64_t> times;
  std::vector<std::string> places;
  const auto check = [&] {
    check_times(
        times, [&](size_t i) { return places[i]; }, request_, 2, draft_);
    times.clear(), places.clear();
  };
  int64_t shift = 0;
  for (size_t row = 0; row < table.rows(); ++row) {
    const std::array<double, 3> values = motion_in(table, c, of_wheels_, row, request_);
    if (std::isnan(values[0] + values[1] + values[2])) continue;
    WheelRow one{.ns = time_in(table, row, c.time, unit),
                 .value = {values[0], values[1]},
                 .run = c.run < 0 ? file.stem : csv_word(std::string(table.cell(row, at(c.run)))),
                 .place = fmt::format("{}:{}", table.file(), table.line(row))};
    const bool begins = drive_.rows.empty() || one.run != drive_.rows.back().run;
    if (begins) {
      check();
      constexpr int64_t kApart_ns = 10'000'000'000;
      const bool back = !drive_.rows.empty() && one.ns <= drive_.rows.back().ns;
      shift = back ? drive_.rows.back().ns + kApart_ns - one.ns : 0;
      constexpr int64_t kMost_ns = 2'000'000'000'000'000'000;
      if (back && drive_.rows.back().ns > kMost_ns)
        throw InputError(fmt::format("{}: found runs of more than 60 years in all", one.place));
    }
    times.push_back(one.ns), places.push_back(one.place);
    // Repeated stamps: what the wheels turned adds up, all else is said twice.
    one.ns += shift;
    if (const auto pose = pose_of_place.find(one.place); pose != pose_of_place.end()) {
      track_.poses.push_back(*pose->second);
      track_.poses.back().ns += shift;
    }
    if (!of_wheels_) {
      velocities_.push_back({one.ns, values[0], values[2], values[1]});
      // Wheels that would move so: by them the clocks are joined.
      constexpr double kHalfBase_m = 0.1;
      one.value = {values[0] - kHalfBase_m * values[1], values[0] + kHalfBase_m * values[1]};
    }
    drive_.rows.push_back(std::move(one));
  }
  check();
}

void WheelsImport::read_motion() {
  std::set<std::string> stems;
  for (File& file : files_) {
    if (!moves(file)) continue;
    if (!stems.insert(file.stem).second) file.stem += fmt::format("-{}", stems.size());
    if (drive_.rows.empty())
      unit_ = of_wheels_ ? wheel_unit(file.table, file.motion, request_)
                         : WheelUnit{.is_speed = true, .is_commanded = true};
    read_rows(file);
  }
  for (const File& file : files_) {
    if (moves(file)) {
      if (poses_apart_ && file.track.are_poses())
        draft_.did(
            fmt::format("poses from the other file, not from {}: there they are taken for "
                        "what the body thinks",
                        file.table.file()));
      continue;
    }
    if (!file.track.are_poses())
      throw InputError(
          fmt::format("{}:1: found neither wheels, velocities nor poses, expected "
                      "columns of one of them; say theirs with --map",
                      file.table.file()));
    Track apart;
    read_track(file.table, file.track, of_poses_, "time", apart);
    std::vector<int64_t> times;
    for (const TrackPose& pose : apart.poses) times.push_back(pose.ns);
    check_times(
        times, [&](size_t i) { return apart.poses[i].place; }, of_poses_, 5, draft_);
    track_.has_headings = track_.has_headings || apart.has_headings;
    track_.has_heights = track_.has_heights || apart.has_heights;
    track_.has_tilts = track_.has_tilts || apart.has_tilts;
    track_.poses.insert(track_.poses.end(), apart.poses.begin(), apart.poses.end());
  }
}

std::vector<WheelReading> WheelsImport::readings() const {
  using enum WheelReading;
  if (unit_.is_speed) return {unit_.is_commanded ? commanded_speed : speed};
  if (unit_.is_counter) return {counter};
  if (unit_.is_each_row) return {each_row};
  return {each_row, counter};
}

// By which the body moves as its wheels say.
void WheelsImport::find_reading() {
  double least = 2;
  WheelReading best = readings().front();
  for (const WheelReading reading : readings()) {
    read_wheels(reading, drive_);
    const double share = not_told_by_wheels(stretches_of(drive_));
    if (share < least) least = share, best = reading;
  }
  const std::string mended = read_wheels(best, drive_);
  if (!mended.empty()) draft_.warn(mended);
  using enum WheelReading;
  draft_.did(best == counter    ? "the wheels' columns go on counting: each row less the row before"
             : best == each_row ? "the wheels' columns hold what was turned since the row before"
             : best == speed    ? "the wheels' speeds: half of each of two rows acts between them"
                                : "the wheels' commanded speeds: each acts until the next row");
}

// Poses of another clock than the wheels': by the shift under which both show one motion.
void WheelsImport::join_clocks() {
  constexpr double kPoor = 0.05, kClear = 0.8, kApart = 3;
  constexpr int64_t kLatency_ns = 250'000'000;
  ClockShift best;
  for (const WheelReading one : readings()) {
    read_wheels(one, drive_);
    if (not_told_by_wheels(stretches_of(drive_)) < kPoor) return;
    const ClockShift shift = best_clock_shift(drive_);
    if (shift.correlation > best.correlation) best = shift;
  }
  const bool overlap = drive_.poses.front().ns < drive_.rows.back().ns &&
                       drive_.poses.back().ns > drive_.rows.front().ns;
  const bool clear = best.correlation > kClear && 1 - best.other > kApart * (1 - best.correlation);
  if (clear && std::abs(best.ns) > kLatency_ns) {
    for (PlanarPose& pose : drive_.poses) pose.ns += best.ns;
    return draft_.warn(fmt::format(
        "the poses' clock is put forward by {} s, where they and the wheels show one motion "
        "(correlation {:.3f}): what is left is for frame_latency",
        seconds_text(best.ns), best.correlation));
  }
  if (!overlap)
    throw InputError(fmt::format(
        "{}: the wheels' times go from {} to {} s, the poses' from {} to {} s, and no shift brings "
        "their motions together (correlation {:.2f}): expected times of one clock, or units of "
        "each (--time-unit time=ms,pose_time=s)",
        drive_.rows.front().place, seconds_text(drive_.rows.front().ns),
        seconds_text(drive_.rows.back().ns), seconds_text(drive_.poses.front().ns),
        seconds_text(drive_.poses.back().ns), best.correlation));
}

void WheelsImport::draft_velocities() {
  std::vector<int64_t> breaks;
  for (size_t k = 1; k < drive_.rows.size(); ++k) {
    if (drive_.rows[k].run != drive_.rows[k - 1].run) breaks.push_back(drive_.rows[k].ns);
  }
  draft_walk(velocities_, drive_.poses, draft_, breaks);
  if (request_.base_m > 0) {
    draft_.effects = fmt::format("  differential_drive: {{metres_per_tick: 0.001, base_m: {}}}\n",
                                 exact(request_.base_m));
    draft_.did("nominal: two wheels that follow the body's velocities");
  }
}

void WheelsImport::draft_wheels() {
  find_reading();
  draft_drive(drive_, request_, metres_per_value(unit_, request_), draft_);
  if (poses_apart_)
    draft_.did("poses between two measured ones are on the straight line between them");
}

void WheelsImport::run() {
  read_files();
  read_motion();
  say_what_is_left_out();
  take_poses();
  if (drive_.rows.empty())
    throw InputError(
        fmt::format("{}: found no row with a number for each wheel", files_.front().table.file()));
  if (poses_apart_) join_clocks();
  if (of_wheels_) return draft_wheels();
  draft_velocities();
}

}  // namespace

void import_wheels(const ImportRequest& request, SetDraft& draft) {
  WheelsImport(request, draft).run();
}

}  // namespace seam::app
