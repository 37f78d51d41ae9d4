// Light that the camera itself sheds on its sensor: against a generator and formulas of their own.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

#include "measurement/kinds/kinds.h"
#include "measurement/kinds/photometry/photometry_problem.h"
#include "measurement/search/search.h"
#include "sim_core/base/image.h"
#include "sim_core/base/output.h"

namespace seam::measurement {
namespace {

constexpr int kColumns = 36, kRows = 28;
constexpr double kGain = 900, kBlack = 40, kElectrons = 4, kRead = 2;  // At the first exposure.

// DN of a glow at the first exposure: from the lower right corner, or along the left edge.
double glow_dn(bool edge, int u, int v) {
  return edge ? 60 * std::exp(-u / 5.0)
              : 90 * std::exp(-std::hypot(kColumns - 1 - u, kRows - 1 - v) / 6.0);
}

std::filesystem::path flat_fields(bool edge) {
  const auto folder =
      std::filesystem::path(testing::TempDir()) / (edge ? "glow-edge" : "glow-corner");
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  std::ranlux48_base random(edge ? 31 : 30);
  std::normal_distribution<double> gauss;
  std::string table = "frame,file,time_s,exposure_s,illumination\n";
  int frame = 0;
  for (const int longer : {1, 2, 4}) {
    for (const double light : {0.0, 0.1, 0.3, 0.6, 0.9}) {
      for (int k = 0; k < 6; ++k, ++frame) {
        Image image{.width_px = kColumns, .height_px = kRows, .bits = 16};
        for (int v = 0; v < kRows; ++v) {
          for (int u = 0; u < kColumns; ++u) {
            const double electrons = kElectrons * longer * (kGain * light + glow_dn(edge, u, v));
            const double counted = std::poisson_distribution<int>(electrons)(random);
            const double dn = counted / kElectrons + kBlack + kRead * gauss(random);
            image.samples.push_back(static_cast<uint16_t>(std::clamp(std::round(dn), 0.0, 4095.0)));
          }
        }
        write_png(folder / fmt::format("{}.png", frame), image);
        table += fmt::format("{0},{0}.png,{1},{2},{3}\n", frame, 0.1 * frame, 0.01 * longer, light);
      }
    }
  }
  write_file_atomically(folder / "frames.csv", table);
  write_file_atomically(
      folder / "measurement.yaml",
      fmt::format("format: seam-measurement/1\nkind: photometry\ntitle: glow\ncamera: {{width_px: "
                  "{}, height_px: {}, bits: 12}}\ngroup: frame\nfiles: {{frames: frames.csv}}\n",
                  kColumns, kRows));
  return folder;
}

Model glow_model(const std::string& more) {
  return Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects: {linear_response: {gain_dn: {value: 850, free: true}, "
      "black_dn: {value: 39, free: true}}, read_noise: {sigma_dn: {value: 2.5, free: true}}" +
          more + "}\n",
      "model"));
}

// Neither the light nor the photon noise is hidden by a glow.
void find_glow(bool edge) {
  const auto folder = flat_fields(edge);
  const auto problem = open_problem(folder);
  const SearchResult result = search(*problem, glow_model(""), {}, [](const std::string&) {});
  std::filesystem::remove_all(folder);
  std::string steps;
  for (const Step& step : result.steps) steps += step.effect + " ";
  const Model& model = result.best.assessment.model;
  ASSERT_EQ(result.steps.size(), 2u) << steps;
  ASSERT_TRUE(model.has("amplifier_glow") && model.has("shot_noise")) << steps;
  EXPECT_NEAR(result.best.assessment.error, 1, 0.02);
  EXPECT_NEAR(model.find("shot_noise")->value("electrons_per_dn"), kElectrons, 0.05);
  const effects::ModelEffect& glow = *model.find("amplifier_glow");
  EXPECT_NEAR(glow.value("light") * model.find("linear_response")->value("gain_dn"), edge ? 60 : 90,
              edge ? 1.0 : 2.0);
  EXPECT_NEAR(glow.value("fall_u_per_px"), edge ? 1 / 5.0 : 1 / 6.0, 0.005);
  EXPECT_NEAR(glow.value("fall_v_per_px"), edge ? 0 : 1 / 6.0, 0.005);
}

TEST(OwnLightSlow, AGlowInACornerIsFoundAndThePhotonNoiseBesideIt) {
  find_glow(false);
}

TEST(OwnLightSlow, AGlowAlongAnEdgeIsFoundAndThePhotonNoiseBesideIt) {
  find_glow(true);
}

// Signal and photon noise of a glow grow with the exposure, whatever the light.
TEST(OwnLight, PredictsMeanAndVariance) {
  const auto folder = flat_fields(false);
  Facts facts;
  const PhotometryData data = read_photometry(MeasurementSet::open(folder), facts);
  const PhotometrySums sums = sum_frames(data, Groups(facts.groups.size(), 1), facts.group_of_row);
  const auto prediction = predict(data, sums,
                                  glow_model(", shot_noise: {electrons_per_dn: 4}, amplifier_glow: "
                                             "{light: 0.1, u0: 0.5, v0: 0.5, fall_u_per_px: 0.2, "
                                             "fall_v_per_px: 0.2}"),
                                  0);
  for (size_t l = 0; l < data.levels.size(); ++l) {
    const PhotometryLevel& level = data.levels[l];
    for (const auto& [u, v] : {std::pair{35, 27}, {30, 20}, {3, 2}}) {
      const double glow = 0.1 * std::exp(-0.2 * std::hypot(35 - u, 27 - v));
      const double signal = 850 * (level.illumination + glow) * level.exposure_s / 0.01;
      const auto i = static_cast<size_t>(v) * kColumns + static_cast<size_t>(u);
      EXPECT_NEAR(prediction.levels[l].mean[i], signal + 39, 0.01);
      EXPECT_NEAR(prediction.levels[l].variance[i], signal / 4 + 2.5 * 2.5 + 1 / 12.0, 0.05);
    }
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace seam::measurement
