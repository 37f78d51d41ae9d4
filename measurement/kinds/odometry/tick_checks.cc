// Ticks that are none since the row before: counters that go on, wrap around or were reset.
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "measurement/kinds/odometry/odometry.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

constexpr const char* kExpected = "ticks since the row before";
// Sizes of counters that wrap around.
constexpr int kCounterBits[] = {8, 10, 12, 14, 15, 16, 24, 31, 32};
// A wheel that turns so many times as fast as in nearly all other rows may be counted wrongly, and
// one that turns so much faster is.
constexpr double kJump = 5, kAbsurdJump = 50;
constexpr size_t kLeastRows = 20;

// The value below which this share of them is.
double share_below(std::vector<double> values, double share) {
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

// How a body moves (forward, turning) over some time, and what its wheels' columns say of it: the
// sum of their rows, and how far they go on.
struct Moves {
  Eigen::MatrixXd motion, sums, differences;
};

// Over half a second each, so that the noise of the poses is small beside the motion. Where a
// counter was reset its difference is no motion.
Moves moves_of(const WalkRun& run, double usual_s) {
  const auto reach = static_cast<size_t>(std::max(1.0, std::round(0.5 / std::max(usual_s, 1e-3))));
  std::array<std::vector<double>, 2> differences;
  std::array<double, 2> usual{};
  for (int wheel = 0; wheel < 2; ++wheel) {
    for (size_t k = 1; k < run.rows.size(); ++k)
      differences[wheel].push_back(std::abs(run.ticks[k][wheel] - run.ticks[k - 1][wheel]));
    std::vector<double> some = differences[wheel];
    std::erase(some, 0);
    usual[wheel] = some.empty() ? 0 : share_below(some, 0.98);
  }
  std::vector<std::array<double, 6>> rows;
  for (size_t k = reach; k < run.rows.size(); ++k) {
    const WalkPose &from = run.pose[k - reach], &to = run.pose[k];
    std::array<double, 6> row{};
    bool jumps = false;
    for (size_t j = k - reach + 1; j <= k; ++j) {
      for (int wheel = 0; wheel < 2; ++wheel) {
        row[2 + wheel] += run.ticks[j][wheel];
        jumps = jumps || differences[wheel][j - 1] > kJump * usual[wheel];
      }
    }
    for (int wheel = 0; wheel < 2; ++wheel)
      row[4 + wheel] = run.ticks[k][wheel] - run.ticks[k - reach][wheel];
    row[1] = maths::wrap_angle(to[2] - from[2]);
    const double heading = from[2] + 0.5 * row[1];
    row[0] = maths::cos(heading) * (to[0] - from[0]) + maths::sin(heading) * (to[1] - from[1]);
    if (!jumps && !std::isnan(row[0] + row[1])) rows.push_back(row);
  }
  const auto n = static_cast<Eigen::Index>(rows.size());
  Moves moves{.motion = {n, 2}, .sums = {n, 2}, .differences = {n, 2}};
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& row = rows[static_cast<size_t>(i)];
    moves.motion.row(i) << row[0], row[1];
    moves.sums.row(i) << row[2], row[3];
    moves.differences.row(i) << row[4], row[5];
  }
  return moves;
}

// Share of the body's motion that is not proportional to what the wheels say: forward times
// turning.
double not_told_by(const Eigen::MatrixXd& wheels, const Eigen::MatrixXd& motion) {
  constexpr double kLeast = 1e-3;  // What is less is rounding.
  double share = 1;
  for (Eigen::Index c = 0; c < motion.cols(); ++c) {
    const Eigen::VectorXd y = motion.col(c);
    const double whole = y.squaredNorm();
    if (whole > 0)
      share *= std::max(kLeast, (y - wheels * solve_any_rank(wheels, y)).squaredNorm() / whole);
  }
  return share;
}

// Whether the body moves as the differences of a column's rows say, and not as the rows themselves
// do.
std::array<bool, 2> go_on(const WalkRun& run, double usual_s) {
  constexpr double kClearly = 0.25;
  const Moves moves = moves_of(run, usual_s);
  std::array<bool, 2> best = {false, false};
  if (moves.motion.rows() < static_cast<Eigen::Index>(kLeastRows)) return best;
  double least = kClearly * not_told_by(moves.sums, moves.motion);
  for (const auto& [left, right] : {std::pair{true, true}, {true, false}, {false, true}}) {
    Eigen::MatrixXd wheels = moves.sums;
    if (left) wheels.col(0) = moves.differences.col(0);
    if (right) wheels.col(1) = moves.differences.col(1);
    const double share = not_told_by(wheels, moves.motion);
    if (share < least) least = share, best = {left, right};
  }
  return best;
}

double usual_step_s(const std::vector<WalkRun>& runs) {
  std::vector<double> steps;
  for (const WalkRun& run : runs) {
    for (size_t k = 1; k < run.rows.size(); ++k) steps.push_back(run.time_s[k] - run.time_s[k - 1]);
  }
  return median_of(steps);
}

// The time in which a row's ticks were counted: stamps may stand closer than the counts do.
double counting_s(const WalkRun& run, size_t k, double usual_s) {
  return std::max(run.time_s[k] - run.time_s[k - 1], usual_s);
}

// Ticks a second of nearly all rows in which the wheel turns; 0: too few to tell.
double usual_rate(const std::vector<WalkRun>& runs, int wheel, double usual_s) {
  std::vector<double> rates;
  for (const WalkRun& run : runs) {
    for (size_t k = 1; k < run.rows.size(); ++k) {
      if (run.ticks[k][wheel] != 0)
        rates.push_back(std::abs(run.ticks[k][wheel]) / counting_s(run, k, usual_s));
    }
  }
  return rates.size() < kLeastRows ? 0 : share_below(rates, 0.98);
}

// What became of a counter whose difference is this, where at most `largest` was to be expected.
std::string cause_of(double ticks, double counted_before, double largest) {
  for (const int bits : kCounterBits) {
    const double whole = std::ldexp(1.0, bits);
    const double real = ticks > 0 ? ticks - whole : ticks + whole;
    if (std::abs(real) <= largest)
      return fmt::format(": a counter of {} bits that wrapped around would give it for {:g}", bits,
                         real);
  }
  if (std::abs(ticks + counted_before) <= largest)
    return fmt::format(": a counter that was reset at {:g} would give it", counted_before);
  // It began before the log.
  return ticks * counted_before < 0 ? ": a counter that was reset would give it" : "";
}

// Throws where a wheel's column holds a counter.
void refuse_counters(const CsvTable& table, const std::vector<WalkRun>& runs, double usual_s) {
  for (const WalkRun& run : runs) {
    const auto [left, right] = go_on(run, usual_s);
    if (!left && !right) continue;
    const int wheel = left ? 0 : 1;
    const size_t row = run.rows.back();
    table.fail(row, kTickColumns[wheel], table.cell(row, kTickColumns[wheel]),
               fmt::format("{}{}; here the body moves as the differences of rows say: {}. Write "
                           "each row less the row before",
                           kExpected,
                           left && right ? "" : fmt::format(", as {} has", kTickColumns[1 - wheel]),
                           left && right ? "counters that go on" : "a counter that goes on"));
  }
}

}  // namespace

void check_ticks(const CsvTable& table, const std::vector<WalkRun>& runs) {
  if (!has_ticks(table)) return;
  const double usual_s = usual_step_s(runs);
  refuse_counters(table, runs, usual_s);
  for (int wheel = 0; wheel < 2; ++wheel) {
    const double usual = usual_rate(runs, wheel, usual_s);
    if (usual == 0) continue;
    for (const WalkRun& run : runs) {
      double counted = 0;
      for (size_t k = 1; k < run.rows.size(); ++k) {
        const double ticks = run.ticks[k][wheel];
        const double most = usual * counting_s(run, k, usual_s);
        if (std::abs(ticks) > kJump * most) {
          const std::string cause = cause_of(ticks, counted, kJump * most);
          if (!cause.empty() || std::abs(ticks) > kAbsurdJump * most)
            table.fail(
                run.rows[k], kTickColumns[wheel], table.cell(run.rows[k], kTickColumns[wheel]),
                fmt::format("{}, about {:.0f} at most as in other rows{}", kExpected, most, cause));
        }
        counted += ticks;
      }
    }
  }
}

}  // namespace seam::measurement
