// A wave over the image far higher than the noise of dark frames, which is cut off at 0 there: no
// value has the wave that the lit frames show, and none is linear in it.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "measurement/imaging/sensor_response.h"
#include "measurement/kinds/photometry/likelihood/photometry_cells.h"

namespace seam::measurement {
namespace {

constexpr int kWidth = 48, kHeight = 36;

// Two frames each in the dark and at five lights, a wave of 40 DN over a black of 12 and a noise
// of 3; rounded to whole DN.
PhotometryData stack_with_wave() {
  PhotometryData data{.width_px = kWidth, .height_px = kHeight, .file_bits = 12};
  std::ranlux48_base random(9);
  std::normal_distribution<double> gauss;
  const effects::PatternWave wave{
      .amplitude_dn = 40, .period_px = 7.4, .angle_rad = 0.8, .phase_rad = -1};
  for (int level = 0; level < 6; ++level) {
    data.levels.push_back({.illumination = 0.15 * level, .exposure_s = 0.01});
    for (int copy = 0; copy < 2; ++copy) {
      const auto frame = static_cast<int>(data.frames.size());
      data.levels.back().frames.push_back(frame);
      data.frames.push_back({.level = level, .time_s = 0.1 * frame});
      std::vector<uint16_t> image;
      for (int v = 0; v < kHeight; ++v) {
        for (int u = 0; u < kWidth; ++u) {
          const double light = 1 - 0.05 * (u - 0.5 * (kWidth - 1)) / (0.5 * kWidth);
          const double dn = 3000 * 0.15 * level * light + 12 +
                            wave.amplitude_dn * wave.unit_at(u, v) + 3 * gauss(random);
          image.push_back(static_cast<uint16_t>(std::clamp(std::round(dn), 0.0, 4095.0)));
        }
      }
      data.images.push_back(std::move(image));
    }
  }
  sum_rows(data);
  return data;
}

PhotometrySums sums_of(PhotometryData& data) {
  std::vector<int> groups(data.frames.size());
  for (size_t f = 0; f < groups.size(); ++f) groups[f] = static_cast<int>(f);
  const PhotometrySums sums = sum_frames(data, Groups(groups.size(), 1), groups);
  data.least_at_top_dn2 = least_at_top(data, sums);
  data.least_at_bottom_dn2 = least_at_bottom(data, sums);
  return sums;
}

effects::Model with_wave(double amplitude_dn, double black_dn, double read_dn, double gx) {
  return effects::Model::from_config(ConfigNode::from_text(
      fmt::format(
          "format: seam-model/1\neffects: {{linear_response: {{gain_dn: 3000, black_dn: "
          "{}}}, read_noise: {{sigma_dn: {}}}, periodic_pattern: {{amplitude_dn: {}, "
          "period_px: 7.4, angle_rad: 0.8, phase_rad: -1}}, uneven_lighting: {{gx: {}}}}}\n",
          black_dn, read_dn, amplitude_dn, gx),
      "model"));
}

TEST(CutWave, CellsEqualEverySample) {
  PhotometryData data = stack_with_wave();
  const PhotometrySums sums = sums_of(data);
  for (const double gx : {0.0, -0.098}) {
    const CellStore store;
    const effects::Model model = with_wave(40, 12, 3, gx);
    const PhotometryScore all = score_photometry(data, sums, predict(data, sums, model, 0), true);
    const auto cells = cell_score(data, sums, store, model, 0, true);
    ASSERT_TRUE(cells.has_value());
    EXPECT_NEAR(cells->log_likelihood, all.log_likelihood, 2e-4 * std::abs(all.log_likelihood));
    EXPECT_NEAR(static_cast<double>(cells->values), static_cast<double>(all.values),
                0.002 * static_cast<double>(all.values));
  }
}

TEST(CutWave, TheLikelihoodIsHighestAtTheTruth) {
  PhotometryData data = stack_with_wave();
  const PhotometrySums sums = sums_of(data);
  const CellStore store;
  const double gx = -0.1 * (kWidth - 1) / kWidth;
  const auto score = [&](double amplitude_dn, double black_dn, double read_dn) {
    return *cell_score(data, sums, store, with_wave(amplitude_dn, black_dn, read_dn, gx), 0, true);
  };
  const PhotometryScore truth = score(40, 12, 3);
  EXPECT_NEAR(std::sqrt(truth.chi2 / static_cast<double>(truth.values)), 1, 0.03);
  for (const auto& [amplitude_dn, black_dn, read_dn] : {std::array{39.0, 12.0, 3.0},
                                                        {41, 12, 3},
                                                        {40, 11.5, 3},
                                                        {40, 12.5, 3},
                                                        {40, 12, 2.8},
                                                        {40, 12, 3.2},
                                                        {25, 20, 8}})
    EXPECT_LT(score(amplitude_dn, black_dn, read_dn).log_likelihood, truth.log_likelihood - 10)
        << amplitude_dn << " " << black_dn << " " << read_dn;
}

TEST(DarkResponse, IsThatWithoutMemory) {
  effects::SensorChain chain{.gain_dn = 200, .black_dn = 4};
  chain.read_sigma_dn = 3, chain.row_sigma_dn = 1;
  const DarkResponses memory;
  for (int round = 0; round < 2; ++round) {
    for (const double offset_dn : {-9.0, 0.0, 5.0}) {
      for (const double stated_dn : {0.0, 0.4}) {
        const effects::SensorExposure exposure{.exposure_s = 0.01, .file_bits = 12};
        const SetNoise noise{.stated_dn = stated_dn};
        const Response own = respond(chain, exposure, 1, noise, 0, offset_dn);
        const Response kept = memory.of(chain, exposure, 1, noise, offset_dn);
        EXPECT_EQ(kept.mean, own.mean);
        EXPECT_EQ(kept.variance, own.variance);
        EXPECT_EQ(kept.offset_slope, own.offset_slope);
      }
    }
  }
}

}  // namespace
}  // namespace seam::measurement
