// The step of rounded values is found in whatever digits a file has them, and none where there is
// none.
#include "measurement/noise/value_steps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

constexpr double kDegreesOfRadian = 180 / std::numbers::pi;

double rounded_to(double value, double to) {
  return std::round(value / to) * to;
}

struct DigitsOfFile {
  const char* name;
  double digit_rad;
  std::function<double(double)> written;
};
const std::vector<DigitsOfFile>& digits_of_files() {
  static const std::vector<DigitsOfFile> all = {
      {"degrees, 4 decimals", 1e-4 / kDegreesOfRadian,
       [](double x) { return rounded_to(x * kDegreesOfRadian, 1e-4) / kDegreesOfRadian; }},
      {"degrees, 2 decimals", 1e-2 / kDegreesOfRadian,
       [](double x) { return rounded_to(x * kDegreesOfRadian, 1e-2) / kDegreesOfRadian; }},
      {"radians, 6 decimals", 1e-6, [](double x) { return rounded_to(x, 1e-6); }},
      {"radians, 4 decimals", 1e-4, [](double x) { return rounded_to(x, 1e-4); }},
      {"radians", 0, [](double x) { return x; }},
      {"single precision", 1e-7, [](double x) { return double{static_cast<float>(x)}; }}};
  return all;
}

// A joint that swings, with noise before it is rounded; step 0: it is not.
std::vector<double> swinging_log(double step_rad, double offset_rad, double noise_rad, int rows,
                                 uint64_t seed, const DigitsOfFile& form) {
  std::vector<double> values;
  for (int k = 0; k < rows; ++k) {
    const double t = 0.01 * k;
    const double angle = 0.8 * std::sin(1.3 * t) + 0.3 * std::sin(4 * t + 1) +
                         noise_rad * normal({seed, 0}, static_cast<uint64_t>(k));
    values.push_back(form.written(step_rad > 0 ? rounded_to(angle, step_rad) + offset_rad : angle));
  }
  return values;
}

TEST(ValueSteps, AreFoundInDigitsOfAnyFile) {
  constexpr double kTurn = 2 * std::numbers::pi;
  for (const DigitsOfFile& form : digits_of_files()) {
    for (const double step : {kTurn / 16384, kTurn / 4096, kTurn / 1024, kTurn / 360, 0.005}) {
      for (const double noise : {1e-5, 5e-4, 3e-3}) {
        for (const int rows : {250, 2000}) {
          const double found =
              step_of_values({swinging_log(step, 0, noise, rows, 3, form),
                              swinging_log(step, 0.3 * step, noise, rows, 4, form)});
          EXPECT_NEAR(found / step, 1, 1e-3) << form.name << ", " << step << ", " << noise;
        }
      }
    }
  }
}

TEST(ValueSteps, NoneIsSeenInValuesThatWereNotRounded) {
  for (const DigitsOfFile& form : digits_of_files()) {
    for (uint64_t seed = 0; seed < 10; ++seed) {
      for (const int rows : {5, 40, 400, 4000}) {
        const double found = step_of_values({swinging_log(0, 0, 1e-3, rows, seed, form)});
        // The file's own digits are a step, too.
        EXPECT_LE(found, 1.001 * form.digit_rad) << form.name << ", " << seed << ", " << rows;
      }
    }
  }
}

TEST(ValueSteps, FewValuesMustStandInSeveralRows) {
  EXPECT_EQ(step_of_values({}), 0);
  EXPECT_EQ(step_of_values({{}, {1}, {2, 2}}), 0);
  EXPECT_EQ(step_of_values({{0.1, 0.23, 0.31, 0.47}}), 0);
  std::vector<double> rest;
  for (int k = 0; k < 60; ++k) rest.push_back(0.0051 * (k * k % 3));
  EXPECT_NEAR(step_of_values({rest}), 0.0051, 1e-9);
}

}  // namespace
}  // namespace seam::measurement
