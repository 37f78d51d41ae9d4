// A drive as a set of odometry with the nominal model of its two wheels.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/import/draft/wheel_drive.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

// Rows with the pose that is measured in each: of poses that come more seldom than rows each counts
// for the nearest row alone, so that no error counts twice.
std::vector<char> rows_with_poses(const Drive& drive, std::vector<PlanarPose>& poses) {
  const auto usual_step = [](const auto& list) {
    std::vector<double> steps;
    for (size_t i = 1; i < list.size(); ++i)
      steps.push_back(1e-9 * static_cast<double>(list[i].ns - list[i - 1].ns));
    return measurement::median_of(steps);
  };
  const size_t n = drive.rows.size();
  std::vector<char> has_pose(n, 0);
  poses.assign(n, {});
  for (size_t k = 0; k < n; ++k) has_pose[k] = pose_at(drive, drive.rows[k].ns, poses[k]);
  if (usual_step(drive.poses) < 1.5 * usual_step(drive.rows)) return has_pose;
  std::vector<char> nearest(n, 0);
  for (const PlanarPose& pose : drive.poses) {
    const auto after = std::lower_bound(drive.rows.begin(), drive.rows.end(), pose.ns,
                                        [](const WheelRow& row, int64_t t) { return row.ns < t; });
    size_t k = static_cast<size_t>(after - drive.rows.begin());
    if (k == n || (k > 0 && pose.ns - drive.rows[k - 1].ns < drive.rows[k].ns - pose.ns)) --k;
    nearest[k] = has_pose[k];
  }
  return nearest;
}

struct Nominal {
  double metres = 0, base_m = 0;
  bool metres_known = false, base_known = false;
};

std::string number(double value, bool known) {
  return known ? exact(value) : fmt::format("{{value: {:.6g}, free: true}}", value);
}

// What the request does not say is estimated from the drive itself, and stays free.
Nominal nominal_of(const Drive& drive, const ImportRequest& request, double metres_per_value) {
  Nominal nominal{
      .metres = request.metres_per_tick > 0 ? request.metres_per_tick : metres_per_value,
      .base_m = request.base_m};
  nominal.metres_known = nominal.metres > 0, nominal.base_known = nominal.base_m > 0;
  double forward = 0, way2 = 0, turn = 0, difference2 = 0;
  for (const Stretch& s : stretches_of(drive)) {
    const double way = 0.5 * (s.wheels[0] + s.wheels[1]), difference = s.wheels[1] - s.wheels[0];
    forward += s.forward_m * way, way2 += way * way;
    turn += s.turn_rad * difference, difference2 += difference * difference;
  }
  if (!nominal.metres_known) nominal.metres = way2 > 0 ? std::abs(forward / way2) : 0;
  if (!nominal.base_known && turn != 0)
    nominal.base_m = nominal.metres * difference2 / std::abs(turn);
  if (nominal.metres_known && !(nominal.metres > 1e-9 && nominal.metres <= 1))
    throw InputError(
        fmt::format("{}: one count of a wheel is {:.6g} m, expected at most 1 m: lengths in metres",
                    drive.rows.front().place, nominal.metres));
  if (nominal.base_known && !(nominal.base_m > 0.01 && nominal.base_m < 10))
    throw InputError(fmt::format(
        "--base {:.6g}: expected the distance between the wheels in "
        "metres, 0.01 to 10{}",
        nominal.base_m,
        nominal.base_m >= 10 && nominal.base_m < 10000
            ? fmt::format("; --base {:.6g} if it is in millimetres", nominal.base_m / 1000)
            : ""));
  if (!(nominal.metres > 1e-9 && nominal.metres <= 1))
    throw InputError(fmt::format(
        "{}: the way of a wheel for each of its counts cannot be estimated (found {:.3g} m): say "
        "it, --metres-per-tick, or --radius with --unit left=ticks:N",
        drive.rows.front().place, nominal.metres));
  if (!(nominal.base_m > 0.01 && nominal.base_m < 10))
    throw InputError(
        fmt::format("{}: the distance between the wheels cannot be estimated (found {:.3g} m): say "
                    "it, --base METRES",
                    drive.rows.front().place, nominal.base_m));
  return nominal;
}

void tell_nominal(const Nominal& nominal, SetDraft& draft) {
  const auto stated = [](double value, bool known, const char* how) {
    return fmt::format("{:.4g} m {}", value, known ? "as stated" : how);
  };
  const char* how = "estimated from the drive itself, so free in the nominal model";
  draft.did(fmt::format("nominal wheels: {} for each count, {} apart",
                        stated(nominal.metres, nominal.metres_known, how),
                        stated(nominal.base_m, nominal.base_known, how)));
  if (!nominal.metres_known)
    draft.could_not_know(
        "the wheels' size (--metres-per-tick or --radius): without it no scale "
        "that both wheels share can be found");
  if (!nominal.base_known)
    draft.could_not_know(
        "the distance between the wheels (--base): without it no error of it can "
        "be found");
}

}  // namespace

void draft_drive(const Drive& drive, const ImportRequest& request, double metres_per_value,
                 SetDraft& draft) {
  std::vector<PlanarPose> poses;
  const std::vector<char> has_pose = rows_with_poses(drive, poses);
  const size_t count = static_cast<size_t>(std::count(has_pose.begin(), has_pose.end(), 1));
  if (count < 8)
    throw InputError(fmt::format(
        "{}: found {} rows of wheels while poses were measured, expected 8 or more: other clocks?",
        drive.rows.front().place, count));
  const bool one_run = std::all_of(drive.rows.begin(), drive.rows.end(), [&](const WheelRow& row) {
    return row.run == drive.rows.front().run;
  });
  // A long drive in parts, so that some can be held out; each begins where it was measured.
  const size_t parts = one_run ? std::clamp<size_t>(count / 16, 1, 20) : 1;
  measurement::CsvWriter table(
      {"run", "time_s", "left_ticks", "right_ticks", "x_m", "y_m", "theta_rad"});
  size_t seen = 0, part = 0, rows = 0, begun = 0, broken = 0;
  bool open = false;
  for (size_t k = 0; k < drive.rows.size(); ++k) {
    if (drive.begins[k]) open = false;
    if (drive.begins[k] && k > 0)
      broken = drive.rows[k].run == drive.rows[k - 1].run ? broken + 1 : 0;
    if (has_pose[k]) {
      const size_t now = seen++ * parts / count;
      if (now != part) part = now, open = false;
    }
    // A run begins where the body was seen.
    if (!open && !has_pose[k]) continue;
    begun += !open, open = true;
    const std::string name = one_run      ? fmt::format("{}", part + broken)
                             : broken > 0 ? fmt::format("{}-{}", drive.rows[k].run, broken)
                                          : drive.rows[k].run;
    table.row({name, seconds_text(drive.rows[k].ns), exact(drive.since[k][0]),
               exact(drive.since[k][1]), has_pose[k] ? exact(poses[k].x_m) : "",
               has_pose[k] ? exact(poses[k].y_m) : "",
               has_pose[k] ? exact(poses[k].theta_rad) : ""});
    ++rows;
  }
  const Nominal nominal = nominal_of(drive, request, metres_per_value);
  draft.kind = "odometry";
  draft.group = "run";
  draft.effects = fmt::format("  differential_drive: {{metres_per_tick: {}, base_m: {}}}\n",
                              number(nominal.metres, nominal.metres_known),
                              number(nominal.base_m, nominal.base_known));
  draft.add_table("odometry", table);
  draft.did(
      fmt::format("{} rows of two wheels in {} runs, {} of them with a pose", rows, begun, count));
  if (parts > 1)
    draft.did(
        "one drive is cut into runs of equal length, so that some can be held out; each "
        "begins anew where it was measured, in motion");
  tell_nominal(nominal, draft);
  draft.could_not_know("the noise of the poses: it is estimated");
}

}  // namespace seam::app
