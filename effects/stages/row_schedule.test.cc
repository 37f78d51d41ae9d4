#include "effects/stages/row_schedule.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ostream>

namespace seam::effects {
namespace {

SimTime instant_of(const RowSchedule& schedule, int row, size_t k) {
  return schedule.instants[schedule.first_instant[row] + k];
}

double integrate(const RowSchedule& schedule, int row, double (*light)(double t_s)) {
  double sum = 0;
  for (size_t k = 0; k < schedule.weights[row].size(); ++k) {
    sum += schedule.weights[row][k] * light(instant_of(schedule, row, k).s());
  }
  return sum;
}

struct Case {
  double line_delay_s, exposure_s;
  int instants;

  friend void PrintTo(const Case& c, std::ostream* out) {
    *out << c.line_delay_s << " s a row, " << c.exposure_s << " s, " << c.instants << " instants";
  }
};

class RowScheduleCases : public testing::TestWithParam<Case> {};

TEST_P(RowScheduleCases, WeightsAreExactForLinearMotionInEveryRow) {
  const Case c = GetParam();
  const Timing timing{
      .line_delay_s = c.line_delay_s, .exposure_s = c.exposure_s, .latency_s = 1e-3};
  const SimTime stamp = SimTime::from_ns(123'456'789);
  const RowSchedule schedule =
      make_row_schedule(timing, stamp, 144, {.instants_per_row = c.instants});
  ASSERT_EQ(schedule.rows.size(), 144u);
  EXPECT_TRUE(std::is_sorted(schedule.instants.begin(), schedule.instants.end()));
  for (int row = 0; row < 144; ++row) {
    const RowWindow window = schedule.rows[row];
    EXPECT_EQ(window.start, stamp + SimDuration::from_s(1e-3 + c.line_delay_s * row));
    EXPECT_EQ((window.end - window.start), SimDuration::from_s(c.exposure_s));
    if (c.exposure_s > 0 && c.instants > 1) {
      EXPECT_GE(schedule.weights[row].size(), size_t(c.instants));
    }
    double sum = 0, mean_ns = 0;
    for (size_t k = 0; k < schedule.weights[row].size(); ++k) {
      const SimTime at = instant_of(schedule, row, k);
      EXPECT_GE(at, window.start);
      EXPECT_LE(at, window.end);
      EXPECT_GT(schedule.weights[row][k], 0);
      sum += schedule.weights[row][k];
      mean_ns += schedule.weights[row][k] * double((at - window.start).ns());
    }
    EXPECT_NEAR(sum, 1, 1e-12);
    EXPECT_NEAR(mean_ns, 0.5 * double((window.end - window.start).ns()), 1);
  }
}

INSTANTIATE_TEST_SUITE_P(Timings, RowScheduleCases,
                         testing::Values(Case{2.78e-4, 5e-3, 8}, Case{-2.78e-4, 5e-3, 8},
                                         Case{0, 5e-3, 8}, Case{2.78e-4, 0.02, 8},
                                         Case{1e-3, 1e-4, 8},  // Windows with gaps between rows.
                                         Case{2.78e-4, 5e-3, 2}, Case{2.78e-4, 5e-3, 3},
                                         Case{2.78e-4, 5e-3, 1}, Case{2.78e-4, 0, 8},
                                         Case{2.7e-5, 3.3e-3, 64}));

TEST(RowSchedule, ErrorForSmoothLightFallsWithTheThirdPowerOfTheStep) {
  const auto light = [](double t_s) { return std::sin(400 * t_s); };
  const auto worst_error = [&](int instants) {
    const Timing timing{.line_delay_s = 2.78e-4, .exposure_s = 5e-3};
    const RowSchedule schedule =
        make_row_schedule(timing, SimTime(), 144, {.instants_per_row = instants});
    double worst = 0;
    for (int row = 0; row < 144; ++row) {
      const double a = schedule.rows[row].start.s(), b = schedule.rows[row].end.s();
      const double exact = (std::cos(400 * a) - std::cos(400 * b)) / (400 * (b - a));
      worst = std::max(worst, std::abs(integrate(schedule, row, light) - exact));
    }
    return worst;
  };
  // At phi = 1, the worst, two weights an end leave 0.375 h^3 |f''| / exposure.
  EXPECT_LT(worst_error(8), 0.375 * 400 * 400 * std::pow(5e-3, 2) / std::pow(8, 3));
  EXPECT_LT(worst_error(16), worst_error(8) / 6);
  EXPECT_LT(worst_error(32), worst_error(16) / 6);
}

TEST(RowSchedule, InstantsAreSharedByRows) {
  const Timing timing{.line_delay_s = 2.78e-4, .exposure_s = 5e-3};
  const RowSchedule schedule = make_row_schedule(timing, SimTime(), 144);
  // 143 rows of delay and one window at 0.625 ms a step.
  EXPECT_NEAR(double(schedule.instants.size()), (143 * 2.78e-4 + 5e-3) / 0.625e-3, 2);
}

TEST(RowSchedule, DriftJitterAndLargeStampsKeepTheirNanoseconds) {
  const SimTime stamp = SimTime::from_ns(1'700'000'000'000'000'123);
  const Timing timing{.line_delay_s = 1e-6, .exposure_s = 0, .drift_ppm = 100};
  const RowSchedule schedule = make_row_schedule(
      timing, stamp, 4,
      {.reference = stamp - SimDuration::from_s(10), .jitter = SimDuration::from_ns(7)});
  EXPECT_EQ(schedule.rows[0].start - stamp, SimDuration::from_ns(1'000'000 + 7));
  EXPECT_EQ(schedule.rows[3].start - schedule.rows[0].start, SimDuration::from_ns(3000));
}

}  // namespace
}  // namespace seam::effects
