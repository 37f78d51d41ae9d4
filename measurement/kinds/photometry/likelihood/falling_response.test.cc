// A response that falls within the light of the set is none: where all fields above some light are
// clipped, a cubic that turns round there would do for the clipping.
#include <gtest/gtest.h>

#include <cmath>

#include "measurement/kinds/photometry/likelihood/photometry_cells.h"

namespace seam::measurement {
namespace {

// Two frames each at three lights, clipped at 200 DN in the last. Unknown light: NaN.
PhotometryData stack(double brightest) {
  PhotometryData data{.width_px = 8, .height_px = 6, .file_bits = 8};
  const double light[] = {0, 0.5, brightest}, dn[] = {10, 110, 200};
  for (int level = 0; level < 3; ++level) {
    data.levels.push_back({.illumination = light[level], .exposure_s = 0.01});
    for (int copy = 0; copy < 2; ++copy) {
      data.levels.back().frames.push_back(static_cast<int>(data.frames.size()));
      data.frames.push_back({.level = level, .time_s = 0.1 * (2 * level + copy)});
      data.images.emplace_back(8 * 6, static_cast<uint16_t>(dn[level] + copy));
    }
  }
  sum_rows(data);
  return data;
}

// Whether it has a likelihood, by cells and by every sample.
std::pair<bool, bool> has_likelihood(const std::string& effects, double brightest = 1.2) {
  const PhotometryData data = stack(brightest);
  const PhotometrySums sums = sum_frames(data, Groups(6, 1), {0, 1, 2, 3, 4, 5});
  const effects::Model model = effects::Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects: {linear_response: {gain_dn: 200, black_dn: 10}, "
      "read_noise: {sigma_dn: 2}" +
          effects + "}\n",
      "model"));
  const CellStore store;
  const auto cells = cell_score(data, sums, store, model, 0, true);
  const auto all = score_photometry(data, sums, predict(data, sums, model, 0), true);
  EXPECT_TRUE(cells.has_value());
  return {std::isfinite(cells->chi2) && std::isfinite(cells->log_likelihood),
          std::isfinite(all.chi2) && std::isfinite(all.log_likelihood)};
}

constexpr std::pair kBoth{true, true}, kNeither{false, false};
// It turns at a signal of 218 DN, three quarters of the way to the brightest field.
constexpr const char* kFalls = ", response_cubic: {k2: 0.3, k3: -0.69}";

TEST(FallingResponse, IsNone) {
  EXPECT_EQ(has_likelihood(""), kBoth);
  EXPECT_EQ(has_likelihood(", response_cubic: {k2: -0.3, k3: 0.05}"), kBoth);
  EXPECT_EQ(has_likelihood(kFalls), kNeither);
}

TEST(FallingResponse, MayFallBeyondTheLight) {
  EXPECT_EQ(has_likelihood(kFalls, 1.0), kBoth);
}

TEST(FallingResponse, MayFallWhereTheCameraClips) {
  EXPECT_EQ(has_likelihood(std::string(kFalls) + ", saturation: {full_dn: 150}"), kBoth);
}

TEST(FallingResponse, UnevenLightCountsAtItsBrightest) {
  EXPECT_EQ(has_likelihood(std::string(kFalls) + ", uneven_lighting: {gx: 0.5}", 1.0), kNeither);
}

TEST(FallingResponse, UnknownLightIsThatOfTheFit) {
  EXPECT_EQ(has_likelihood(std::string(kFalls), std::nan("")), kBoth);
}

}  // namespace
}  // namespace seam::measurement
