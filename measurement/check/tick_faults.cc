// Faults of wheels: headings in degrees, places in millimetres, a wheel that is not counted,
// counted backwards or taken for the other one.
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "measurement/check/fault_parts.h"
#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {
namespace {

constexpr std::array kWheels = {"left_ticks", "right_ticks"};
// Stretches that last so long: the noise of the poses is small beside the motion.
constexpr double kStretch_s = 0.5;
constexpr size_t kFewestStretches = 20;

// How the body moved from one pose to a later one, and what the wheels counted on the way.
struct Stretch {
  double dx_m, dy_m, heading, turn;
  std::array<double, 2> ticks;
};

std::vector<Stretch> stretches_of(const CsvTable& table) {
  const Numbers t = table.numbers("time_s"), x = table.numbers_or_blank("x_m"),
                y = table.numbers_or_blank("y_m"), theta = table.numbers_or_blank("theta_rad");
  const std::array ticks = {table.numbers(kWheels[0]), table.numbers(kWheels[1])};
  std::vector<Stretch> found;
  for (const auto& [name, rows] : rows_by(table, {"run"})) {
    size_t from = table.rows();
    std::array<double, 2> counted{};
    for (const size_t row : rows) {
      for (size_t wheel = 0; wheel < 2; ++wheel) counted[wheel] += ticks[wheel][row];
      if (std::isnan(x[row] + y[row] + theta[row])) continue;
      if (from < table.rows()) {
        if (t[row] - t[from] < kStretch_s) continue;
        found.push_back({.dx_m = x[row] - x[from],
                         .dy_m = y[row] - y[from],
                         .heading = 0.5 * (theta[from] + theta[row]),
                         .turn = theta[row] - theta[from],
                         .ticks = counted});
      }
      from = row, counted = {};
    }
  }
  return found;
}

// How well a body that cannot go sideways goes along its heading, this factor on it: 1 at best.
double goes_along(const std::vector<Stretch>& stretches, double factor) {
  std::complex<double> sum = 0;
  double most = 0;
  for (const Stretch& s : stretches) {
    // Where the heading jumps by a turn its middle means nothing.
    if (std::abs(factor * s.turn) > 1) continue;
    const double way = std::hypot(s.dx_m, s.dy_m);
    sum += std::polar(way, 2 * (std::atan2(s.dy_m, s.dx_m) - factor * s.heading));
    most += way;
  }
  return most > 0 ? std::abs(sum) / most : 1;
}

// Headings that the way contradicts; whether anything was said.
bool tell_headings(const CsvTable& table, const std::vector<Stretch>& stretches,
                   std::vector<std::string>& found) {
  constexpr double kLittle = 0.6, kMuch = 0.9;
  if (goes_along(stretches, 1) > kLittle) return false;
  for (const auto& [factor, text] :
       {std::pair{1 / kDegrees, "theta_rad is read as degrees"},
        {-1.0, "theta_rad counts to the other side, or y_m does, or x_m and y_m are exchanged"}}) {
    if (goes_along(stretches, factor) < kMuch) continue;
    found.push_back(
        fmt::format("{}: a body on two wheels goes where it looks, and this one does so "
                    "where {}",
                    table.file(), text));
    return true;
  }
  return false;
}

// A side that stands still in all rows, or repeats the other one, while the body turns.
bool tell_dead(const CsvTable& table, const std::vector<Stretch>& stretches,
               std::vector<std::string>& found) {
  double turned = 0;
  for (const Stretch& s : stretches)
    turned += std::abs(std::remainder(s.turn, 2 * std::numbers::pi));
  if (turned < 2 * std::numbers::pi) return false;
  const auto all = [&](auto&& is_so) {
    return std::all_of(stretches.begin(), stretches.end(), is_so);
  };
  for (size_t wheel = 0; wheel < 2; ++wheel) {
    if (!all([&](const Stretch& s) { return s.ticks[wheel] == 0; })) continue;
    found.push_back(
        fmt::format("{}: column {} is 0 in this row and in all others, while the body "
                    "turns: a wheel that is not counted",
                    place(table, 0), kWheels[wheel]));
    return true;
  }
  if (!all([](const Stretch& s) { return s.ticks[0] == s.ticks[1]; })) return false;
  found.push_back(
      fmt::format("{}: left_ticks and right_ticks are equal in all rows, while the "
                  "body turns: one is a copy of the other",
                  table.file()));
  return true;
}

// Sides by their signs: the left wheel goes forward and turns the body to the right.
void tell_sides(const CsvTable& table, const std::vector<Stretch>& stretches,
                std::vector<std::string>& found) {
  const auto n = static_cast<Eigen::Index>(stretches.size());
  Eigen::MatrixXd wheels(n, 2), motion(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Stretch& s = stretches[static_cast<size_t>(i)];
    wheels.row(i) << s.ticks[0], s.ticks[1];
    motion.row(i) << std::cos(s.heading) * s.dx_m + std::sin(s.heading) * s.dy_m,
        std::remainder(s.turn, 2 * std::numbers::pi);
  }
  Eigen::Index rank = 0;
  const Eigen::MatrixXd by = solve_any_rank(wheels, motion, &rank);
  if (rank < 2) return;
  const Eigen::RowVector2d left = (motion - wheels * by).colwise().squaredNorm(),
                           whole = motion.colwise().squaredNorm();
  // Where the wheels do not say how the body moves, no sign means anything.
  constexpr double kMostLeft = 0.1;
  if (!(left[0] < kMostLeft * whole[0] && left[1] < kMostLeft * whole[1])) return;
  const bool left_back = by(0, 0) < 0, right_back = by(1, 0) < 0;
  const bool left_turns_left = by(0, 1) > 0, right_turns_left = by(1, 1) > 0;
  // A tick goes by its half into the way, and by its part of the base into the turn.
  constexpr double kWidestBase_m = 20;
  const double base_m =
      2 * (std::abs(by(0, 0)) + std::abs(by(1, 0))) / (std::abs(by(0, 1)) + std::abs(by(1, 1)));
  if (base_m > kWidestBase_m)
    found.push_back(
        fmt::format("{}: by ways and turns the wheels stand {:.3g} m apart: "
                    "millimetres for metres in x_m and y_m?",
                    table.file(), base_m));
  const char* text = nullptr;
  if (left_back && right_back && left_turns_left && !right_turns_left)
    text = "both columns count backwards";
  else if (left_back && !right_back && left_turns_left && right_turns_left)
    text = "left_ticks counts backwards";
  else if (!left_back && right_back && !left_turns_left && !right_turns_left)
    text = "right_ticks counts backwards";
  else if (!left_back && !right_back && left_turns_left && !right_turns_left)
    text = "left_ticks and right_ticks are exchanged";
  if (text == nullptr) return;
  found.push_back(
      fmt::format("{}: the body moves as the wheels say where {} (expected: forward is "
                  "more, and more of the right wheel turns to the left)",
                  table.file(), text));
}

}  // namespace

void tick_faults(const CsvTable& table, std::vector<std::string>& found) {
  std::vector<Stretch> stretches = stretches_of(table);
  if (stretches.size() < kFewestStretches) return;
  if (tell_headings(table, stretches, found) || tell_dead(table, stretches, found)) return;
  std::erase_if(stretches, [](const Stretch& s) { return std::abs(s.turn) > std::numbers::pi; });
  tell_sides(table, stretches, found);
}

}  // namespace seam::measurement
