// With many levels what rows share is kept as a diagonal less two columns: the same likelihood as
// from the whole matrix where samples of a row are alike, and close to it where they are not.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "measurement/kinds/photometry/likelihood/photometry_cells.h"
#include "measurement/kinds/photometry/likelihood/photometry_rows.h"

namespace seam::measurement {
namespace {

// Pairs of frames at so many levels, with patterns of every kind in the values.
PhotometryData stack(int levels) {
  PhotometryData data{.width_px = 30, .height_px = 20};
  std::ranlux48_base random(3);
  std::normal_distribution<double> gauss;
  std::vector<double> gain, offset, column;
  for (int i = 0; i < 600; ++i) gain.push_back(gauss(random)), offset.push_back(gauss(random));
  for (int u = 0; u < 30; ++u) column.push_back(gauss(random));
  for (int l = 0; l < levels; ++l) {
    data.levels.push_back({.illumination = 0.8 * l / levels, .exposure_s = 0.01 + 0.002 * l});
    for (int copy = 0; copy < 2; ++copy) {
      const auto frame = static_cast<int>(data.frames.size());
      data.levels.back().frames.push_back(frame);
      data.frames.push_back({.level = l, .time_s = 0.1 * frame});
      std::vector<uint16_t> image;
      for (int v = 0; v < 20; ++v) {
        const double row = 0.6 * gauss(random);
        for (int u = 0; u < 30; ++u) {
          const int i = v * 30 + u;
          const double light = data.levels.back().illumination * (1 - 0.1 * (u - 15) / 15.0);
          const double dn = 220 * light * (1 + 0.01 * gain[i]) + 12 + 0.7 * offset[i] +
                            0.5 * column[u] + row + 1.4 * gauss(random);
          image.push_back(static_cast<uint16_t>(std::clamp(std::round(dn), 0.0, 255.0)));
        }
      }
      data.images.push_back(std::move(image));
    }
  }
  sum_rows(data);
  return data;
}

double exact(const PhotometryData& data, const PhotometrySums& sums, const effects::Model& model) {
  return score_photometry(data, sums, predict(data, sums, model, 0), true).log_likelihood;
}

TEST(PhotometryManyLevels, LikelihoodEqualsThatOfEverySample) {
  const std::string sensor =
      "linear_response: {gain_dn: 220, black_dn: 12}, read_noise: {sigma_dn: 1.4}, "
      "pixel_gain_spread: {sigma: 0.01}, pixel_offset_spread: {sigma_dn: 0.7}, ";
  const std::string light = "uneven_lighting: {gx: -0.2}, ";
  const PhotometryData data = stack(40);
  std::vector<int> groups(data.frames.size());
  for (size_t f = 0; f < groups.size(); ++f) groups[f] = static_cast<int>(f);
  const PhotometrySums sums = sum_frames(data, Groups(groups.size(), 1), groups);
  ASSERT_TRUE(RowOffsets::has_many(data.levels.size()));
  for (const std::string& rest :
       {std::string("row_noise: {sigma_dn: 0.6}"), light + "row_noise: {sigma_dn: 0.6}",
        light + "column_offsets: {sigma_dn: 0.5}",
        light + "row_noise: {sigma_dn: 0.6}, column_offsets: {sigma_dn: 0.5}",
        light + "row_noise: {sigma_dn: 0.6}, dark_current_spread: {sigma_dn_per_s: 14}",
        light + "lamp_fluctuation: {sigma: 0.01}, shot_noise: {electrons_per_dn: 90}",
        light + "hot_pixels: {fraction: 0.01, level_dn: 9}, row_noise: {sigma_dn: 0.6}"}) {
    const effects::Model model = effects::Model::from_config(
        ConfigNode::from_text("format: seam-model/1\neffects: {" + sensor + rest + "}\n", "model"));
    const CellStore store;
    const double all = exact(data, sums, model);
    const auto cells = cell_score(data, sums, store, model, 0, true);
    ASSERT_TRUE(cells.has_value()) << rest;
    EXPECT_NEAR(cells->log_likelihood, all, 1.5) << rest;  // Of some 10^5.
    double frames = 0;
    for (const double own : cells->by_frame) frames += own;
    EXPECT_NEAR(frames, cells->log_likelihood, 1e-6 * std::abs(all)) << rest;
    EXPECT_EQ(cells->values, sums.values) << rest;
  }
}

TEST(PhotometryManyLevels, ScoreHasTheSquareOfEverySample) {
  const PhotometryData data = stack(40);
  std::vector<int> groups(data.frames.size());
  for (size_t f = 0; f < groups.size(); ++f) groups[f] = static_cast<int>(f);
  const PhotometrySums sums = sum_frames(data, Groups(groups.size(), 1), groups);
  const effects::Model model = effects::Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects: {linear_response: {gain_dn: 220, "
                            "black_dn: 12}, read_noise: {sigma_dn: 1.4}}\n",
                            "model"));
  const CellStore store;
  const PhotometryScore all = score_photometry(data, sums, predict(data, sums, model, 0), true);
  const auto cells = cell_score(data, sums, store, model, 0, true);
  EXPECT_NEAR(cells->square, all.square, 1e-9 * all.square);
  EXPECT_NEAR(cells->chi2, all.chi2, 1e-6 * all.chi2);
  EXPECT_EQ(cells->values, all.values);
}

// Fits ask for fields of light that differ by far less than a cell is wide.
TEST(PhotometryManyLevels, FieldsThatHardlyDifferShareTheirSortedSamples) {
  for (const int levels : {12, 40}) {
    const PhotometryData data = stack(levels);
    std::vector<int> groups(data.frames.size());
    for (size_t f = 0; f < groups.size(); ++f) groups[f] = static_cast<int>(f);
    const PhotometrySums sums = sum_frames(data, Groups(groups.size(), 1), groups);
    const CellStore store;
    const SortedSamples* sorted = nullptr;
    for (const double gx : {-0.20025, -0.2002, -0.2001}) {
      const effects::Model model = effects::Model::from_config(ConfigNode::from_text(
          "format: seam-model/1\neffects: {linear_response: {gain_dn: 220, black_dn: 12}, "
          "read_noise: {sigma_dn: 1.4}, pixel_gain_spread: {sigma: 0.01}, pixel_offset_spread: "
          "{sigma_dn: 0.7}, row_noise: {sigma_dn: 0.6}, periodic_pattern: {amplitude_dn: 0.2, "
          "period_px: 7}, uneven_lighting: {gx: " +
              std::to_string(gx) + "}}\n",
          "model"));
      const auto cells = store.cells(data, sums, model, {.products = true, .groups = true});
      if (sorted == nullptr) sorted = cells->sorted.get();
      EXPECT_EQ(cells->sorted.get(), sorted) << gx;
      const auto fast = cell_log_likelihood(data, sums, store, model, 0, true);
      EXPECT_NEAR(*fast, exact(data, sums, model), 0.5) << gx;
    }
    // Another field has its own.
    const effects::Model other = effects::Model::from_config(ConfigNode::from_text(
        "format: seam-model/1\neffects: {linear_response: {gain_dn: 220, black_dn: 12}, "
        "uneven_lighting: {gx: -0.21}}\n",
        "model"));
    EXPECT_NE(store.cells(data, sums, other, {})->sorted.get(), sorted);
  }
}

// Differences of a fit are no larger than what the likelihood bends by over half a standard
// deviation: samples that changed cells on the way would look like a bend.
TEST(PhotometryManyLevels, LikelihoodBendsEvenlyBesideTheStartOfAFit) {
  const PhotometryData data = stack(40);
  std::vector<int> groups(data.frames.size());
  for (size_t f = 0; f < groups.size(); ++f) groups[f] = static_cast<int>(f);
  const PhotometrySums sums = sum_frames(data, Groups(groups.size(), 1), groups);
  const auto model = [](double gx) {
    return effects::Model::from_config(ConfigNode::from_text(
        "format: seam-model/1\neffects: {linear_response: {gain_dn: 220, black_dn: 12}, "
        "read_noise: {sigma_dn: 1.4}, pixel_gain_spread: {sigma: 0.01}, "
        "uneven_lighting: {gy: 0.1, gx: " +
            std::to_string(gx) + "}}\n",
        "model"));
  };
  const effects::Model start = model(-0.2);
  // The largest change of the second difference from place to place, over the mean of it.
  const auto unevenness = [&](const effects::Model* near) {
    const CellStore store;
    std::vector<double> values, bends;
    for (int i = -10; i <= 10; ++i)
      values.push_back(
          *cell_log_likelihood(data, sums, store, model(-0.2 + 1e-4 * i), 0, true, near));
    for (size_t i = 1; i + 1 < values.size(); ++i)
      bends.push_back(values[i + 1] - 2 * values[i] + values[i - 1]);
    const auto [least, most] = std::minmax_element(bends.begin(), bends.end());
    const double mean =
        std::accumulate(bends.begin(), bends.end(), 0.0) / static_cast<double>(bends.size());
    return (*most - *least) / std::abs(mean);
  };
  EXPECT_LT(unevenness(&start), 0.1);
  EXPECT_GT(unevenness(nullptr), 1);
}

}  // namespace
}  // namespace seam::measurement
