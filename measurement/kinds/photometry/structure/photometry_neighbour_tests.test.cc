// Likeness of neighbours against independent samples, a filter of known correlation, and dust.
#include "measurement/kinds/photometry/structure/photometry_neighbour_tests.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

constexpr int kWidth = 60, kHeight = 50, kFrames = 6;
constexpr double kNoise = 5, kPattern = 2;

using Field = std::vector<double>;

Field normal_field(RandomStream random, uint64_t number, double size) {
  Field field(kWidth * kHeight);
  for (size_t i = 0; i < field.size(); ++i) field[i] = size * normal(random.child(number), i);
  return field;
}

// Along rows, by weights 1, 2, 1: neighbours in a row correlate by 4 / 6, those in a column not.
Field filtered(const Field& field) {
  Field out = field;
  for (size_t i = 1; i + 1 < field.size(); ++i)
    out[i] = 0.25 * (field[i - 1] + 2 * field[i] + field[i + 1]);
  return out;
}

struct Tested {
  std::vector<StructureTest> tests;
  NoiseLikeness noise;
};

Tested tested(uint64_t seed, bool filter, double dust, double odd_rows = 0) {
  const RandomStream random{seed, 4};
  PhotometryData data{.width_px = kWidth, .height_px = kHeight};
  data.levels.resize(2);
  const Field pattern = normal_field(random, 100, kPattern);
  for (int frame = 0; frame < 2 * kFrames; ++frame) {
    const int level = frame / kFrames;
    data.frames.push_back({level, 0.04 * frame});
    data.levels[static_cast<size_t>(level)].frames.push_back(frame);
    Field noise = normal_field(random, static_cast<uint64_t>(frame), kNoise);
    if (filter) noise = filtered(noise);
    auto& image = data.images.emplace_back();
    for (int i = 0; i < kWidth * kHeight; ++i) {
      const bool dusty = std::abs(std::hypot(i % kWidth - 30, i / kWidth - 25) - 12) < 2;
      const double value = 100 + 50 * level + pattern[static_cast<size_t>(i)] +
                           noise[static_cast<size_t>(i)] - (dusty ? dust : 0) +
                           (i / kWidth % 2 == 1 ? odd_rows : 0);
      image.push_back(static_cast<uint16_t>(std::lround(value)));
    }
  }
  sum_rows(data);
  std::vector<int> group(data.frames.size(), 0);
  const PhotometrySums sums = sum_frames(data, Groups{1}, group);
  PhotometryPrediction prediction;
  for (int level = 0; level < 2; ++level)
    prediction.levels.push_back({.mean = Field(kWidth * kHeight, 100 + 50 * level)});
  return {neighbour_tests({data, sums}, prediction), noise_likeness({data, sums})};
}

std::vector<StructureTest> tests_of(uint64_t seed, bool filter, double dust, double odd_rows = 0) {
  return tested(seed, filter, dust, odd_rows).tests;
}

TEST(NeighbourTests, OfIndependentSamplesTheyAreChiSquares) {
  constexpr int kSets = 60;
  constexpr int kFreedom[4] = {2, kHeight - 1, kWidth - 1, 2};
  double chi2[4] = {0, 0, 0, 0};
  for (uint64_t seed = 1; seed <= kSets; ++seed) {
    const auto tests = tests_of(seed, false, 0);
    ASSERT_EQ(tests.size(), 4u);
    for (size_t k = 0; k < 4; ++k) {
      EXPECT_EQ(tests[k].freedom, kFreedom[k]);
      chi2[k] += tests[k].chi2 / kSets;
    }
  }
  // The mean of 60 chi-squares of n degrees of freedom scatters by the root of n / 30.
  for (size_t k = 0; k < 4; ++k)
    EXPECT_NEAR(chi2[k], kFreedom[k], 3.1 * std::sqrt(kFreedom[k] / 30.0)) << k;
}

// Rows that alternate by 1.5 DN, as two circuits read them: half of that is their scatter.
TEST(NeighbourTests, RowsThatAlternateAreAlikeWithinThemselves) {
  const auto tests = tests_of(1, false, 0, 1.5);
  EXPECT_EQ(tests[1].structure.covariate, "row");
  EXPECT_NEAR(tests[1].structure.strength, 0.75, 0.08);
  // Pixels of 2.8 DN in means of 60.
  EXPECT_NEAR(tests[1].chi2, (kHeight - 1) * (1 + 60 * 0.75 * 0.75 / (2.8 * 2.8)), 60);
  EXPECT_LT(tests[2].chi2, 100);
}

TEST(NeighbourTests, AFilterInTheCameraIsInTheNoiseAlone) {
  const auto tests = tests_of(1, true, 0);
  EXPECT_GT(tests[3].chi2, 1000);
  // Of the filter's variance, 6 / 16 of the noise's, half of 4 / 6 is alike in a neighbour.
  EXPECT_NEAR(tests[3].structure.strength, kNoise * std::sqrt(6.0 / 16 * 4 / 6 / 2), 0.1);
  EXPECT_EQ(tests[3].structure.covariate, "neighbouring_pixel*time");
}

TEST(NeighbourTests, TheCorrelationOfAFilterIsThatOfItsWeights) {
  const NoiseLikeness noise = tested(1, true, 0).noise, none = tested(1, false, 4).noise;
  // Rounding to whole numbers adds a hundredth to the filtered variance, which no neighbour shares.
  EXPECT_NEAR(noise.along_rows, 4.0 / 6, 0.02);
  EXPECT_NEAR(noise.along_columns, 0, 0.02);
  EXPECT_LT(noise.p_value, 1e-100);
  EXPECT_NEAR(none.along_rows, 0, 0.02);
  EXPECT_GT(none.p_value, 1e-3);
}

TEST(NeighbourTests, DustIsInTheMeansAlone) {
  const auto tests = tests_of(1, false, 4);
  // A tenth of the pixels, 4 DN darker beside 2.5 DN of pattern and noise: of the 3,000 pairs each
  // way an eighth of the variance is alike.
  EXPECT_NEAR(tests[0].chi2, 80, 30);
  EXPECT_LT(tests[3].chi2, 14);
  EXPECT_EQ(tests[0].structure.covariate, "neighbouring_pixel");
}

}  // namespace
}  // namespace seam::measurement
