// A filter over neighbours in flat fields that a generator of its own makes: the camera's gain is
// that of the noise before it.
#include <fmt/format.h>
#include <gmock/gmock.h>
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

constexpr int kFilterColumns = 40, kFilterRows = 30;
constexpr double kFilterGain = 3000, kFilterBlack = 100, kFilterElectrons = 2.5, kFilterRead = 4,
                 kFilterSpread = 0.012;

double filter_share(double weight, int away) {
  return away == 0 ? 1 - 2 * weight : weight;
}

std::filesystem::path filtered_fields(double along_rows, double along_columns) {
  const auto folder =
      std::filesystem::path(testing::TempDir()) / fmt::format("filter-{:g}", along_rows);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  std::ranlux48_base random(17);
  std::normal_distribution<double> gauss;
  std::vector<double> gains(kFilterColumns * kFilterRows);
  for (double& gain : gains) gain = 1 + kFilterSpread * gauss(random);
  std::string table = "frame,file,time_s,exposure_s,illumination\n";
  int frame = 0;
  for (const double light : {0.0, 0.2, 0.4, 0.6, 0.8, 1.0}) {
    for (int k = 0; k < 6; ++k, ++frame) {
      std::vector<double> dn;
      for (const double gain : gains) {
        const double electrons = kFilterElectrons * kFilterGain * light * gain;
        const double counted =
            electrons > 0 ? std::poisson_distribution<int>(electrons)(random) : 0;
        dn.push_back(counted / kFilterElectrons + kFilterBlack + kFilterRead * gauss(random));
      }
      Image image{.width_px = kFilterColumns, .height_px = kFilterRows, .bits = 16};
      for (int v = 0; v < kFilterRows; ++v) {
        for (int u = 0; u < kFilterColumns; ++u) {
          double sum = 0;
          for (int i = -1; i <= 1; ++i) {
            for (int j = -1; j <= 1; ++j) {
              const int at_v = std::clamp(v + i, 0, kFilterRows - 1),
                        at_u = std::clamp(u + j, 0, kFilterColumns - 1);
              sum += filter_share(along_columns, i) * filter_share(along_rows, j) *
                     dn[static_cast<size_t>(at_v * kFilterColumns + at_u)];
            }
          }
          image.samples.push_back(static_cast<uint16_t>(std::clamp(std::round(sum), 0.0, 4095.0)));
        }
      }
      write_png(folder / fmt::format("{}.png", frame), image);
      table += fmt::format("{0},{0}.png,{1},0.01,{2}\n", frame, 0.1 * frame, light);
    }
  }
  write_file_atomically(folder / "frames.csv", table);
  write_file_atomically(
      folder / "measurement.yaml",
      fmt::format("format: seam-measurement/1\nkind: photometry\ntitle: filter\ncamera: "
                  "{{width_px: {}, height_px: {}, bits: 12}}\ngroup: frame\nfiles: {{frames: "
                  "frames.csv}}\n",
                  kFilterColumns, kFilterRows));
  return folder;
}

Model before_filter() {
  return Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects: {linear_response: {gain_dn: {value: 2900, free: true}, "
      "black_dn: {value: 95, free: true}}, read_noise: {sigma_dn: {value: 5, free: true}}, "
      "shot_noise: {electrons_per_dn: {value: 3, free: true}}}\n",
      "model"));
}

std::string steps_beside_filter(const SearchResult& result) {
  std::string steps;
  for (const Step& step : result.steps) steps += step.effect + " ";
  return steps;
}

TEST(NoiseFilterSlow, IsFoundAndTheGainIsThatOfTheNoiseBeforeIt) {
  constexpr double kAlongRows = 0.12, kAlongColumns = 0.05;
  const auto folder = filtered_fields(kAlongRows, kAlongColumns);
  const auto problem = open_problem(folder);
  const SearchResult result = search(*problem, before_filter(), {}, [](const std::string&) {});
  const Model& model = result.best.assessment.model;
  ASSERT_TRUE(model.has("noise_filter")) << steps_beside_filter(result);
  EXPECT_EQ(result.steps.size(), 2u) << steps_beside_filter(result);
  for (const auto& [effect, parameter, truth, off] :
       {std::tuple{"noise_filter", "along_rows", kAlongRows, 0.006},
        {"noise_filter", "along_columns", kAlongColumns, 0.006},
        {"shot_noise", "electrons_per_dn", kFilterElectrons, 0.06},
        {"read_noise", "sigma_dn", kFilterRead, 0.15},
        {"pixel_gain_spread", "sigma", kFilterSpread, 6e-4}}) {
    const effects::ModelEffect* found = model.find(effect);
    ASSERT_NE(found, nullptr) << effect << ": " << steps_beside_filter(result);
    EXPECT_NEAR(found->value(parameter), truth, off) << effect << "." << parameter;
  }
  EXPECT_NEAR(result.best.assessment.error, 1, 0.02);
  const Groups all(problem->facts().groups.size(), 1);
  EXPECT_THAT(problem->structure(model, all, 0), testing::IsEmpty());
  // What no model asks says that the noise is shared.
  EXPECT_THAT(problem->facts().notes,
              testing::Contains(testing::HasSubstr("alike in neighbouring pixels")));
  std::filesystem::remove_all(folder);
}

TEST(NoiseFilterSlow, IsNotFoundWhereNeighboursAreIndependent) {
  const auto folder = filtered_fields(0, 0);
  const auto problem = open_problem(folder);
  const SearchResult result = search(*problem, before_filter(), {}, [](const std::string&) {});
  EXPECT_FALSE(result.best.assessment.model.has("noise_filter")) << steps_beside_filter(result);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace seam::measurement
