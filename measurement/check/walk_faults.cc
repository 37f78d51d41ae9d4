// Faults of walks: units of places, angles and velocities against each other.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "measurement/check/fault_parts.h"

namespace seam::measurement {
namespace {

struct Walk {
  std::map<std::string, Rows> runs;
  Numbers t, vx, vy, omega;
  Numbers x, y, theta;  // Not a number where blank.

  explicit Walk(const CsvTable& table)
      : runs(rows_by(table, {"run"})),
        t(table.numbers("time_s")),
        vx(table.numbers("vx_cmd_mps")),
        vy(table.numbers("vy_cmd_mps")),
        omega(table.numbers("omega_cmd_radps")),
        x(table.numbers_or_blank("x_m")),
        y(table.numbers_or_blank("y_m")),
        theta(table.numbers_or_blank("theta_rad")) {}
};

struct Walked {
  double measured_m = 0, commanded_m = 0;
  double measured_rad = 0, commanded_rad = 0;
};

// How far each run got from its start, and how far its commands would have.
Walked walked_in(const Walk& walk) {
  const auto& [runs, t, vx, vy, omega, x, y, theta] = walk;
  Walked walked;
  for (const auto& [name, rows] : runs) {
    double px = 0, py = 0, heading = 0, far = 0, turn = 0, far_seen = 0, turn_seen = 0,
           before = NAN;
    double seen = 0;
    size_t first = rows[0];
    for (const size_t row : rows) {
      if (row != rows[0]) {
        const size_t last = row - 1;
        const double dt = t[row] - t[last];
        px += dt * (vx[last] * std::cos(heading) - vy[last] * std::sin(heading));
        py += dt * (vx[last] * std::sin(heading) + vy[last] * std::cos(heading));
        heading += dt * omega[last];
      }
      far = std::max(far, std::hypot(px, py)), turn = std::max(turn, std::abs(heading));
      if (std::isnan(x[row]) || std::isnan(y[row]) || std::isnan(theta[row])) continue;
      if (std::isnan(before)) first = row;
      far_seen = std::max(far_seen, std::hypot(x[row] - x[first], y[row] - y[first]));
      if (!std::isnan(before)) {
        // Headings may be wrapped, by whatever turn they are counted in.
        const double step = theta[row] - before;
        seen += std::abs(step) > 180 ? step - std::copysign(360, step)
                : std::abs(step) > std::numbers::pi && std::abs(step) < 2.001 * std::numbers::pi
                    ? std::remainder(step, 2 * std::numbers::pi)
                    : step;
      }
      before = theta[row];
      turn_seen = std::max(turn_seen, std::abs(seen));
    }
    walked.measured_m += far_seen, walked.commanded_m += far;
    walked.measured_rad += turn_seen, walked.commanded_rad += turn;
  }
  return walked;
}

// How far measured steps are from those that the commands make along the measured heading, root
// mean square, with the measured step's x and y changed.
struct WalkSteps {
  double as_is_m = 0, exchanged_m = 0, mirrored_m = 0;
  double turn = 0, turn_commanded = 0;  // Their sums where they agree in sign less where not.
};

WalkSteps walk_steps_in(const Walk& walk) {
  const auto& [runs, t, vx, vy, omega, x, y, theta] = walk;
  WalkSteps steps;
  size_t count = 0;
  for (const auto& [name, rows] : runs) {
    double forward = 0, left = 0, turn = 0;  // Commanded since the last pose.
    size_t pose = t.size();
    for (const size_t row : rows) {
      if (row != rows[0]) {
        const double dt = t[row] - t[row - 1];
        forward += dt * vx[row - 1], left += dt * vy[row - 1], turn += dt * omega[row - 1];
      }
      if (std::isnan(x[row]) || std::isnan(y[row]) || std::isnan(theta[row])) continue;
      if (pose < t.size()) {
        const double heading = theta[pose] + 0.5 * turn, c = std::cos(heading),
                     s = std::sin(heading);
        const double dx = x[row] - x[pose], dy = y[row] - y[pose];
        const double wx = c * forward - s * left, wy = s * forward + c * left;
        const auto square = [&](double ax, double ay) {
          return (ax - wx) * (ax - wx) + (ay - wy) * (ay - wy);
        };
        steps.as_is_m += square(dx, dy), steps.exchanged_m += square(dy, dx);
        steps.mirrored_m += square(dx, -dy);
        steps.turn += turn * std::remainder(theta[row] - theta[pose], 2 * std::numbers::pi);
        steps.turn_commanded += turn * turn;
        ++count;
      }
      pose = row, forward = left = turn = 0;
    }
  }
  const double n = std::max<double>(1, static_cast<double>(count));
  steps.as_is_m = std::sqrt(steps.as_is_m / n),
  steps.exchanged_m = std::sqrt(steps.exchanged_m / n);
  steps.mirrored_m = std::sqrt(steps.mirrored_m / n);
  return steps;
}

// Axes exchanged or counted to the other side, by what the commands would have done.
void tell_axes(const CsvTable& table, const Walk& walk, std::vector<std::string>& found) {
  constexpr double kBetter = 3;
  const WalkSteps steps = walk_steps_in(walk);
  const bool turned = steps.turn_commanded > 0 && steps.turn < -0.5 * steps.turn_commanded;
  if (turned)
    found.push_back(fmt::format(
        "{}: theta_rad turns against omega_cmd_radps: one of them counts clockwise, expected "
        "counter-clockwise",
        table.file()));
  if (kBetter * steps.exchanged_m < steps.as_is_m)
    found.push_back(fmt::format(
        "{}: steps miss the commands by {:.2g} m, and by {:.2g} m with x_m and y_m exchanged",
        table.file(), steps.as_is_m, steps.exchanged_m));
  // A heading that counts the other way mirrors the walk as well.
  if (!turned && kBetter * steps.mirrored_m < steps.as_is_m)
    found.push_back(fmt::format(
        "{}: steps miss the commands by {:.2g} m, and by {:.2g} m with y_m counted to the other "
        "side: expected x forward, y to the left",
        table.file(), steps.as_is_m, steps.mirrored_m));
}

}  // namespace

void walk_faults(const MeasurementSet& set, std::vector<std::string>& found) {
  const CsvTable table = set.table("odometry");
  if (has_all(table, {"time_s", "left_ticks", "right_ticks", "x_m", "y_m", "theta_rad"}))
    tick_faults(table, found);
  if (!has_all(table, {"time_s", "vx_cmd_mps", "vy_cmd_mps", "omega_cmd_radps", "x_m", "y_m",
                       "theta_rad"}))
    return;
  const Walk walk(table);
  const Walked walked = walked_in(walk);
  const size_t before = found.size();
  const auto tell = [&](double ratio, double factor, const char* columns, const char* verb,
                        const char* unit, const char* instead) {
    if (const auto text = unit_of_ratio(ratio, factor, unit, instead); !text.empty())
      found.push_back(fmt::format("{}: {} {} {:.0f} times as far as the other columns say: {}",
                                  table.file(), columns, verb, ratio, text));
  };
  if (walked.commanded_m > 0 && walked.measured_m > 0) {
    const double ratio = walked.measured_m / walked.commanded_m;
    tell(ratio, 1000, "x_m and y_m", "go", "millimetres", "metres");
    tell(1 / ratio, 1000, "vx_cmd_mps and vy_cmd_mps", "go", "millimetres", "metres");
  }
  if (walked.commanded_rad > 0.5 && walked.measured_rad > 0.5) {
    const double ratio = walked.measured_rad / walked.commanded_rad;
    tell(ratio, kDegrees, "theta_rad", "turns", "degrees", "radians");
    tell(1 / ratio, kDegrees, "omega_cmd_radps", "turns", "degrees", "radians");
  }
  // Both alike.
  constexpr double kMost_radps = 20;
  const Numbers& omega = walk.omega;
  const auto fastest = std::max_element(
      omega.begin(), omega.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  if (found.size() == before && fastest != omega.end() && std::abs(*fastest) > kMost_radps)
    found.push_back(
        fmt::format("{}: omega_cmd_radps is {:g}, {:.1f} turns a second: degrees for "
                    "radians?",
                    place(table, static_cast<size_t>(fastest - omega.begin())), *fastest,
                    std::abs(*fastest) / (2 * std::numbers::pi)));
  // Of wrong units the steps say nothing.
  if (found.size() == before) tell_axes(table, walk, found);
}

}  // namespace seam::measurement
