// Densities with heavy tails against integrals done here, and against draws.
#include "measurement/noise/few_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

double normal_density(double x, double sigma) {
  return std::exp(-0.5 * x * x / (sigma * sigma)) / (sigma * std::sqrt(2 * std::numbers::pi));
}

// A normal error and an exponential one, folded by Simpson's rule over the latter.
double folded(double error, double sigma, double scale) {
  constexpr int kSteps = 20000;
  const double far = std::max(60 * scale, error + 12 * sigma), h = far / kSteps;
  double sum = 0;
  for (int k = 0; k <= kSteps; ++k) {
    const double x = k * h, weight = k == 0 || k == kSteps ? 1 : k % 2 ? 4 : 2;
    sum += weight * std::exp(-x / scale) / scale * normal_density(error - x, sigma);
  }
  return sum * h / 3;
}

TEST(FewErrors, DensityOfATail) {
  for (const double scale : {0.05, 0.4, 3.0}) {
    const FewErrors errors(FewErrors::Sort::exponential, 0.2, scale);
    for (const double error : {-0.5, -0.1, 0.0, 0.07, 0.3, 1.0, 2.0}) {
      const double sigma = 0.1;
      const double expected =
          std::log(0.8 * normal_density(error, sigma) + 0.2 * folded(error, sigma, scale));
      EXPECT_NEAR(errors.at(error, sigma).value, expected, 1e-6) << scale << " " << error;
    }
  }
}

TEST(FewErrors, DensityOfAMixture) {
  const FewErrors errors(FewErrors::Sort::normal, 0.1, 2);
  for (const double error : {-4.0, -0.2, 0.0, 0.5, 7.0}) {
    const double expected = std::log(0.9 * normal_density(error, 0.3) +
                                     0.1 * normal_density(error, std::hypot(0.3, 2)));
    EXPECT_NEAR(errors.at(error, 0.3).value, expected, 1e-9);
  }
}

TEST(FewErrors, DerivativesAreThoseOfTheDensity) {
  for (const auto sort : {FewErrors::Sort::exponential, FewErrors::Sort::normal}) {
    const FewErrors errors(sort, 0.15, 0.6);
    for (const double error : {-1.5, -0.3, 0.0, 0.2, 0.5, 2.0, 9.0}) {
      const double h = 1e-4;
      const LogDensity low = errors.at(error - h, 0.1), here = errors.at(error, 0.1),
                       high = errors.at(error + h, 0.1);
      EXPECT_NEAR(here.slope, (high.value - low.value) / (2 * h),
                  1e-4 * (1 + std::abs(here.slope)));
      EXPECT_NEAR(here.curvature, (high.slope - low.slope) / (2 * h),
                  1e-4 * (1 + std::abs(here.curvature)));
    }
  }
}

// Half of z^2 and of what stands in for log det is the log-likelihood, and z^2 has the mean that is
// stated.
TEST(FewErrors, DevianceStandsForTheLikelihood) {
  const RandomStream stream{.seed = 3};
  for (const auto sort : {FewErrors::Sort::exponential, FewErrors::Sort::normal}) {
    for (const double size : {0.2, 1.0, 10.0}) {
      const FewErrors errors(sort, 0.1, size);
      const double sigma = 0.3;
      const int n = 40000;
      double whitened = 0, square = 0, fourth = 0, variance = 0, mean = 0;
      for (int i = 0; i < n; ++i) {
        double error = sigma * normal(stream.child("normal"), i);
        if (uniform(stream.child("few"), i) < 0.1) {
          error += sort == FewErrors::Sort::normal
                       ? size * normal(stream.child("more"), i)
                       : -size * std::log(uniform(stream.child("more"), i));
        }
        const Deviance seen = errors.deviance(error, sigma);
        EXPECT_NEAR(-0.5 * (seen.z * seen.z + std::log(2 * std::numbers::pi) + seen.log_det),
                    errors.at(error, sigma).value, 1e-5);
        whitened += seen.z / n;
        square += seen.z * seen.z / n, fourth += std::pow(seen.z, 4) / n;
        mean += error / n, variance += error * error / n;
      }
      const double scatter = std::sqrt((fourth - square * square) / n);
      EXPECT_NEAR(errors.mean_square(sigma), square, 4 * scatter) << size;
      EXPECT_NEAR(errors.mean(sigma), whitened, 4 * std::sqrt(square / n)) << size;
      EXPECT_NEAR(errors.variance(sigma), variance - mean * mean, 0.1 * variance) << size;
    }
  }
}

// The likeliest error is that, and costs nothing.
TEST(FewErrors, Mode) {
  const FewErrors errors(FewErrors::Sort::exponential, 0.5, 0.7);
  const double mode = errors.mode(0.2);
  EXPECT_GT(mode, 0);
  EXPECT_NEAR(errors.at(mode, 0.2).slope, 0, 0.05);
  EXPECT_NEAR(errors.deviance(mode, 0.2).z, 0, 1e-2);
}

// Both coordinates of a point fail together.
TEST(FewErrors, SecondOfAPair) {
  const RandomStream stream{.seed = 4};
  for (const double size : {0.3, 1.0, 6.0}) {
    const FewErrors errors(FewErrors::Sort::normal, 0.1, size);
    const double sigma = 0.3;
    const int n = 40000;
    double square = 0, fourth = 0;
    for (int i = 0; i < n; ++i) {
      const double more = uniform(stream.child("few"), i) < 0.1 ? size : 0;
      const double u = sigma * normal(stream, 4 * i) + more * normal(stream, 4 * i + 1),
                   v = sigma * normal(stream, 4 * i + 2) + more * normal(stream, 4 * i + 3);
      const double lot = errors.share_of_more(u, sigma, 0.1);
      const double z = errors.deviance(v, sigma, lot).z;
      square += z * z / n, fourth += std::pow(z, 4) / n;
      // Together they are the density of the pair.
      const double pair =
          0.9 * normal_density(u, 0.3) * normal_density(v, 0.3) +
          0.1 * normal_density(u, std::hypot(0.3, size)) * normal_density(v, std::hypot(0.3, size));
      EXPECT_NEAR(errors.at(u, sigma).value + errors.at(v, sigma, lot).value, std::log(pair), 1e-9);
    }
    const double scatter = std::sqrt((fourth - square * square) / n);
    EXPECT_NEAR(errors.mean_square_of_second(sigma), square, 4 * scatter + 0.01) << size;
  }
}

TEST(FewErrors, KnowsWhichHaveMore) {
  const FewErrors errors(FewErrors::Sort::normal, 0.1, 2);
  EXPECT_LT(errors.share_of_more(0.1, 0.3, 0.1), 0.05);
  EXPECT_GT(errors.share_of_more(3, 0.3, 0.1), 0.999);
}

}  // namespace
}  // namespace seam::measurement
