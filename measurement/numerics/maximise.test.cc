// Maxima whose place and curvature are known in closed form.
#include "measurement/numerics/maximise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

TEST(Maximise, ACorrelatedNormalHasItsMeanAndCovariance) {
  // Covariance {{4, 1.8}, {1.8, 1}} about (3, -2): its inverse is {{1, -1.8}, {-1.8, 4}} / 0.76.
  const auto log_density = [](const std::vector<double>& x) {
    const double a = x[0] - 3, b = x[1] + 2;
    return -0.5 * (a * a - 3.6 * a * b + 4 * b * b) / 0.76;
  };
  const Maximum found = maximise(log_density, {{.start = 0, .min = -50, .max = 50, .step = 0.1},
                                               {.start = 0, .min = -50, .max = 50, .step = 0.1}});
  EXPECT_TRUE(found.converged);
  EXPECT_NEAR(found.value[0], 3, 0.02 * 2);
  EXPECT_NEAR(found.value[1], -2, 0.02 * 1);
  EXPECT_NEAR(found.sigma[0], 2, 2e-3);
  EXPECT_NEAR(found.sigma[1], 1, 1e-3);
  EXPECT_NEAR(found.covariance[1], 1.8, 5e-3);
  EXPECT_NEAR(found.covariance[2], 1.8, 5e-3);
  EXPECT_NEAR(found.log_likelihood, 0, 1e-3);
  EXPECT_FALSE(found.at_bound[0]);
}

// Two values of which the sum is known a thousand times better than the difference, by a likelihood
// that is good to 1e-4: differences along the axes leave nothing of the difference's curvature.
TEST(Maximise, AWeakDirectionHasItsOwnError) {
  const auto log_density = [](const std::vector<double>& x) {
    const double sum = (x[0] + x[1] - 1) / 1e-3, difference = (x[0] - x[1] - 3) / 1;
    const double exact = -0.5 * (sum * sum + difference * difference);
    return 1e-4 * std::round(exact / 1e-4);
  };
  const Maximum found =
      maximise(log_density, {{.start = 1.5, .min = -50, .max = 50, .step = 1e-3},
                             {.start = -0.5, .min = -50, .max = 50, .step = 1e-3}});
  EXPECT_NEAR(found.sigma[0], 0.5, 0.02);
  EXPECT_NEAR(found.sigma[1], 0.5, 0.02);
  EXPECT_NEAR(found.covariance[1], -0.25, 0.02);
}

// What the likelihood does not tell lies anywhere in its range.
TEST(Maximise, ADirectionWithoutInformationIsAsWideAsItsRange) {
  const auto log_density = [](const std::vector<double>& x) {
    const double sum = (x[0] + x[1]) / 0.1;
    return -0.5 * sum * sum;
  };
  const Maximum found = maximise(log_density, {{.start = 0, .min = -3, .max = 3, .step = 0.01},
                                               {.start = 0, .min = -3, .max = 3, .step = 0.01}});
  EXPECT_NEAR(found.sigma[0], 6 / std::sqrt(12.0), 0.01);
}

// A valley whose direction turns on the way, as those of a response and its bend do: correlations
// seen at the start lead nowhere.
TEST(Maximise, ABentValleyIsFollowedToItsEnd) {
  const auto log_density = [](const std::vector<double>& x) {
    const double along = (x[0] - 2) / 0.1, off = (x[1] - x[0] * x[0]) / 0.1;
    return -0.5 * (along * along + off * off);
  };
  const Maximum found = maximise(log_density, {{.start = 0, .min = -50, .max = 50, .step = 0.01},
                                               {.start = 0, .min = -50, .max = 50, .step = 0.01}});
  EXPECT_TRUE(found.converged);
  EXPECT_NEAR(found.value[0], 2, 0.05 * 0.1);
  EXPECT_NEAR(found.value[1], 4, 0.02);
  EXPECT_NEAR(found.sigma[0], 0.1, 2e-3);
  EXPECT_NEAR(found.sigma[1], std::hypot(4 * 0.1, 0.1), 8e-3);
}

// Of n exponential lifetimes with the sum T, the rate is n / T and its error rate / sqrt(n).
TEST(Maximise, SideBySideIsTheSameToTheBit) {
  const auto log_density = [](const std::vector<double>& x) {
    const double along = (x[0] - 2) / 0.1, off = (x[1] - x[0] * x[0]) / 0.1, third = x[2] - x[0];
    return -0.5 * (along * along + off * off + third * third);
  };
  // The last begins at its bound, where differences are one-sided.
  const std::vector<SearchParameter> parameters{{.start = 0, .min = -50, .max = 50, .step = 0.01},
                                                {.start = 0, .min = -50, .max = 50, .step = 0.01},
                                                {.start = 0, .min = 0, .max = 50, .step = 0.01}};
  const Maximum one = maximise(log_density, parameters),
                two = maximise(log_density, parameters, Calls::side_by_side);
  EXPECT_TRUE(one.converged);
  EXPECT_EQ(one.value, two.value);
  EXPECT_EQ(one.sigma, two.sigma);
  EXPECT_EQ(one.covariance, two.covariance);
  EXPECT_EQ(one.log_likelihood, two.log_likelihood);
}

TEST(Maximise, ARateOnALogarithmicScale) {
  constexpr double kCount = 400;
  double total_s = 0;
  const RandomStream stream{.seed = 5};
  for (size_t i = 0; i < kCount; ++i) total_s -= std::log(uniform(stream, i)) / 25;
  const auto log_density = [&](const std::vector<double>& x) {
    return kCount * std::log(x[0]) - x[0] * total_s;
  };
  const double rate = kCount / total_s;
  for (const double start : {1e-2, 1.0, 400.0}) {
    const Maximum found =
        maximise(log_density,
                 {{.start = start, .min = 1e-6, .max = 1e6, .step = 0.02, .logarithmic = true}});
    EXPECT_TRUE(found.converged) << start;
    EXPECT_NEAR(found.value[0], rate, 0.02 * rate / std::sqrt(kCount)) << start;
    EXPECT_NEAR(found.sigma[0], rate / std::sqrt(kCount), 0.01 * rate / std::sqrt(kCount)) << start;
  }
}

// Mean and spread of a normal sample: their errors are s / sqrt(n) and s / sqrt(2 n).
TEST(Maximise, MeanAndSpreadOfASample) {
  constexpr size_t kCount = 200;
  const RandomStream stream{.seed = 6};
  std::vector<double> sample;
  double sum = 0, sum2 = 0;
  for (size_t i = 0; i < kCount; ++i) sample.push_back(1e3 + 0.2 * normal(stream, i));
  for (const double x : sample) sum += x;
  const double mean = sum / kCount;
  for (const double x : sample) sum2 += (x - mean) * (x - mean);
  const double spread = std::sqrt(sum2 / kCount);
  const Maximum found = maximise(
      [&](const std::vector<double>& p) {
        double value = 0;
        for (const double x : sample)
          value -= std::log(p[1]) + 0.5 * (x - p[0]) * (x - p[0]) / (p[1] * p[1]);
        return value;
      },
      {{.start = 999, .min = 0, .max = 1e4, .step = 0.1},
       {.start = 5, .min = 1e-3, .max = 100, .step = 0.05, .logarithmic = true}});
  const double root = std::sqrt(static_cast<double>(kCount));
  EXPECT_NEAR(found.value[0], mean, 0.03 * spread / root);
  EXPECT_NEAR(found.value[1], spread, 0.03 * spread / root);
  EXPECT_NEAR(found.sigma[0], spread / root, 0.02 * spread / root);
  EXPECT_NEAR(found.sigma[1], spread / root / std::sqrt(2.0), 0.02 * spread / root);
}

// Where the start is near the end and the steps are known to fit, one look is enough.
TEST(Maximise, ALookWithStepsThatFitIsNotRepeated) {
  size_t looks = 0;
  const auto log_density = [&](const std::vector<double>& x) {
    ++looks;
    const double a = x[0] - 3, b = x[1] + 2;
    return -0.5 * (a * a - 3.6 * a * b + 4 * b * b) / 0.76;
  };
  const auto find = [&](bool step_fits) {
    looks = 0;
    return maximise(log_density,
                    {{.start = 3.01, .min = -50, .max = 50, .step = 1, .step_fits = step_fits},
                     {.start = -2.01, .min = -50, .max = 50, .step = 0.5, .step_fits = step_fits}});
  };
  const Maximum twice = find(false);
  const size_t looks_twice = looks;
  const Maximum once = find(true);
  EXPECT_LT(looks, 0.7 * static_cast<double>(looks_twice));
  EXPECT_TRUE(once.converged);
  EXPECT_NEAR(once.value[0], 3, 0.02 * 2);
  EXPECT_NEAR(once.sigma[0], twice.sigma[0], 1e-3);
  EXPECT_NEAR(once.covariance[1], 1.8, 5e-3);
  EXPECT_NEAR(once.gained, once.log_likelihood - log_density({3.01, -2.01}), 1e-12);
}

// Correlations that part of the data showed need not be measured once more in all of them.
TEST(Maximise, CorrelationsOfPartOfTheDataSaveLooks) {
  size_t looks = 0;
  double rows = 1;
  const auto log_density = [&](const std::vector<double>& x) {
    ++looks;
    const double a = x[0] - 3, b = x[1] + 2, c = x[2], d = x[3];
    return -0.5 * rows * ((a * a - 3.6 * a * b + 4 * b * b) / 0.76 + c * c + d * d - c * d);
  };
  std::vector<SearchParameter> parameters(4, {.min = -50, .max = 50, .step = 0.3});
  const Maximum part = maximise(log_density, parameters);
  rows = 25;
  const auto again = [&](const std::vector<double>& alike) {
    looks = 0;
    for (size_t i = 0; i < parameters.size(); ++i) {
      parameters[i] = {.start = part.value[i] + 0.1, .min = -50, .max = 50, .step_fits = true};
      parameters[i].step = part.step[i] / 5;
    }
    return maximise(log_density, parameters, Calls::one_by_one, alike);
  };
  const Maximum measured = again({});
  const size_t all = looks;
  const Maximum given = again(part.curvature);
  EXPECT_LE(looks + 12, all);  // Two looks for each of six pairs.
  EXPECT_TRUE(given.converged);
  for (size_t i = 0; i < parameters.size(); ++i) {
    EXPECT_NEAR(given.value[i], measured.value[i], 0.01 * measured.sigma[i]);
    EXPECT_NEAR(given.sigma[i], part.sigma[i] / 5, 1e-3 * part.sigma[i]);
  }
}

TEST(Maximise, StopsAtABoundAndSaysSo) {
  const Maximum found =
      maximise([](const std::vector<double>& x) { return -0.5 * (x[0] - 7) * (x[0] - 7); },
               {{.start = 1, .min = -5, .max = 5, .step = 0.1}});
  EXPECT_EQ(found.value[0], 5);
  EXPECT_TRUE(found.at_bound[0]);
  EXPECT_NEAR(found.log_likelihood, -2, 1e-9);
}

TEST(Maximise, WhatChangesNothingHasNoEstimate) {
  const Maximum found =
      maximise([](const std::vector<double>& x) { return -0.5 * x[0] * x[0]; },
               {{.start = 1, .min = -5, .max = 5}, {.start = 0.5, .min = -5, .max = 5}});
  EXPECT_NEAR(found.sigma[0], 1, 1e-3);
  EXPECT_TRUE(std::isinf(found.sigma[1]));
  EXPECT_EQ(found.value[1], 0.5);
}

// Nor is the end of a range, to which the least slope leads, a finding.
TEST(Maximise, WhatChangesNextToNothingStaysWhereItBegan) {
  const Maximum found =
      maximise([](const std::vector<double>& x) { return -0.5 * x[0] * x[0] + 1e-7 * x[1]; },
               {{.start = 1, .min = -5, .max = 5}, {.start = 0.5, .min = -5, .max = 5}});
  EXPECT_NEAR(found.value[0], 0, 1e-3);
  EXPECT_EQ(found.value[1], 0.5);
  EXPECT_FALSE(found.at_bound[1]);
}

// The function need not be known everywhere.
TEST(Maximise, KeepsOutOfWhereThereIsNoValue) {
  const Maximum found =
      maximise([](const std::vector<double>& x) { return std::log(x[0]) * 50 - 20 * x[0]; },
               {{.start = 0.05, .min = -5, .max = 5, .step = 0.01}});
  EXPECT_NEAR(found.value[0], 2.5, 0.02);
  EXPECT_NEAR(found.sigma[0], 2.5 / std::sqrt(50.0), 5e-3);
}

}  // namespace
}  // namespace seam::measurement
