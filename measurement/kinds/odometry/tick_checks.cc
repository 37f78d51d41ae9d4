// Ticks that are none since the row before: counters that go on, wrap around or were reset.
#include <Eigen/Core>
#include <algorithm>
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

// Share of the body's motion (forward, turning) that is proportional to what the wheels say.
double told_by(const Eigen::MatrixXd& wheels, const Eigen::MatrixXd& motion) {
  double share = 0;
  for (Eigen::Index c = 0; c < motion.cols(); ++c) {
    const Eigen::VectorXd y = motion.col(c);
    const Eigen::MatrixXd fit = solve_any_rank(wheels, y);
    const double whole = y.squaredNorm();
    if (whole > 0) share += 0.5 * (1 - (y - wheels * fit).squaredNorm() / whole);
  }
  return share;
}

// Whether the body moves as the differences of the columns say, and not as the columns themselves
// do.
bool goes_on(const WalkRun& run) {
  std::vector<size_t> rows;
  for (size_t k = 1; k < run.rows.size(); ++k) {
    double sum = 0;
    for (int c = 0; c < 3; ++c) sum += run.pose[k][c] + run.pose[k - 1][c];
    if (!std::isnan(sum)) rows.push_back(k);
  }
  if (rows.size() < kLeastRows) return false;
  // Where a counter was reset its difference is no motion.
  const auto size_at = [&](size_t k) {
    return std::max(std::abs(run.ticks[k][0] - run.ticks[k - 1][0]),
                    std::abs(run.ticks[k][1] - run.ticks[k - 1][1]));
  };
  std::vector<double> sizes;
  for (const size_t k : rows) sizes.push_back(size_at(k));
  const double usual = share_below(sizes, 0.98);
  std::erase_if(rows, [&](size_t k) { return size_at(k) > kJump * usual; });
  const auto n = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd as_given(n, 2), differences(n, 2), motion(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    const size_t k = rows[static_cast<size_t>(i)];
    const WalkPose &from = run.pose[k - 1], &to = run.pose[k];
    motion(i, 0) =
        maths::cos(from[2]) * (to[0] - from[0]) + maths::sin(from[2]) * (to[1] - from[1]);
    motion(i, 1) = maths::wrap_angle(to[2] - from[2]);
    for (int wheel = 0; wheel < 2; ++wheel) {
      as_given(i, wheel) = run.ticks[k][wheel];
      differences(i, wheel) = run.ticks[k][wheel] - run.ticks[k - 1][wheel];
    }
  }
  return told_by(differences, motion) > 0.5 &&
         told_by(as_given, motion) < 0.5 * told_by(differences, motion);
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
  return "";
}

}  // namespace

void check_ticks(const CsvTable& table, const std::vector<WalkRun>& runs) {
  if (!has_ticks(table)) return;
  for (const WalkRun& run : runs) {
    if (!goes_on(run)) continue;
    const size_t row = run.rows.back();
    table.fail(row, kTickColumns[0], table.cell(row, kTickColumns[0]),
               fmt::format("{}; here the body moves as the differences of rows say: counters that "
                           "go on. Write each row less the row before",
                           kExpected));
  }
  const double usual_s = usual_step_s(runs);
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
