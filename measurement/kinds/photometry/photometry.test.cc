// Photometry against an independent generator (plain loops and the standard library's random
// numbers, none of effects/sensor) and against the dense form of the likelihood.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>

#include "effects/registry.h"
#include "measurement/imaging/sensor_response.h"
#include "measurement/kinds/photometry/photometry_problem.h"
#include "sim_core/base/image.h"

namespace seam::measurement {
namespace {

// What is hidden in a generated set; neutral unless said.
struct Hidden {
  double a2 = 0, gx = 0, electrons = 0, prnu = 0, dsnu = 0, columns = 0, rows = 0, gamma = 1,
         full = 1e9;
  double dark_offset = 0, depth = 0, hot_fraction = 0, hot_level = 0;
  double k2 = 0, wave = 0, lamp = 0, weak_fraction = 0, weak_gain = 1;
  int step = 1;
  std::function<double(int u, int v, int frame)> extra;  // A factor of the light.
};

constexpr int kWidth = 48, kHeight = 40, kPerLevel = 12;

std::filesystem::path generate(const std::string& name, const Hidden& hidden, unsigned seed) {
  const auto folder = std::filesystem::temp_directory_path() / ("seam_photometry_" + name);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  std::ranlux48_base random(seed);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> uniform;
  std::vector<double> gain(kWidth * kHeight), offset(kWidth * kHeight), column(kWidth);
  for (double& c : column) c = hidden.columns * gauss(random);
  for (size_t i = 0; i < gain.size(); ++i) {
    gain[i] = 1 + hidden.prnu * gauss(random);
    offset[i] = hidden.dsnu * gauss(random) + column[i % kWidth];
    if (uniform(random) < hidden.hot_fraction) offset[i] += hidden.hot_level;
    if (hidden.weak_fraction > 0 && uniform(random) < hidden.weak_fraction)
      gain[i] *= hidden.weak_gain;
    // A wave of 7.3 pixels in the direction (0.8, 0.6).
    const auto u = static_cast<double>(i % kWidth), v = static_cast<double>(i / kWidth);
    offset[i] += hidden.wave * std::sin(2 * M_PI * (0.8 * u + 0.6 * v) / 7.3 + 0.7);
  }
  std::ofstream csv(folder / "frames.csv");
  csv << "frame,file,time_s,exposure_s,illumination\n";
  int frame = 0;
  for (const double light : {0.0, 0.1, 0.3, 0.5, 0.75}) {
    for (int k = 0; k < kPerLevel; ++k, ++frame) {
      Image image{.width_px = kWidth, .height_px = kHeight};
      const double frame_light = hidden.lamp > 0 ? 1 + hidden.lamp * gauss(random) : 1;
      for (int v = 0; v < kHeight; ++v) {
        const double row = hidden.rows * gauss(random);
        const double t = 0.04 * frame + 0.0005 * v + 0.0025;
        const double lamp = 1 + hidden.depth * std::sin(M_PI * 90 * 0.005) / (M_PI * 90 * 0.005) *
                                    std::sin(2 * M_PI * 90 * t + 0.4);
        for (int u = 0; u < kWidth; ++u) {
          const double du = u - 0.5 * (kWidth - 1), dv = v - 0.5 * (kHeight - 1);
          const double rho2 = (du * du + dv * dv) / (0.25 * (kWidth * kWidth + kHeight * kHeight));
          double signal = 220 * light * lamp * frame_light * (1 - hidden.a2 * rho2) *
                          (1 + hidden.gx * (u / (kWidth - 1.0) - 0.5));
          if (hidden.extra) signal *= hidden.extra(u, v, frame);
          signal *= gain[v * kWidth + u];
          signal += hidden.dark_offset;
          if (hidden.electrons > 0 && signal > 0) {
            signal = std::poisson_distribution<int>(signal * hidden.electrons)(random) /
                     hidden.electrons;
          }
          signal *= 1 + hidden.k2 * signal / 255;
          signal = signal > 0 ? 220 * std::pow(signal / 220, hidden.gamma) : 0;
          double dn = std::min(signal + 9 + offset[v * kWidth + u] + row + 1.3 * gauss(random),
                               hidden.full);
          dn = hidden.step * std::round(dn / hidden.step);
          image.samples.push_back(static_cast<uint16_t>(std::clamp(std::round(dn), 0.0, 255.0)));
        }
      }
      const std::string file = std::to_string(frame) + ".png";
      write_png(folder / file, image);
      csv << frame << ',' << file << ',' << 0.04 * frame << ",0.005," << light << '\n';
    }
  }
  std::ofstream(folder / "measurement.yaml")
      << "format: seam-measurement/1\nkind: photometry\ntitle: generated\ncamera: {width_px: 48, "
         "height_px: 40, "
         "frame_period_s: 0.04}\ngroup: frame\nfiles: {frames: frames.csv}\n";
  return folder;
}

Model nominal(bool rows_in_time = false) {
  return Model::from_config(ConfigNode::from_text(
      std::string("format: seam-model/1\neffects:\n  linear_response: {gain_dn: 220, black_dn: 9}\n"
                  "  read_noise: {sigma_dn: 1.3}\n") +
          (rows_in_time ? "  rolling_shutter: {line_delay_s: 5.0e-4}\n" : ""),
      "nominal"));
}

struct Found {
  std::string first;
  double error = 0;
  std::vector<double> value, sigma;
  size_t structures_before = 0, structures_after = 0;
};

// The candidate with the largest held-out likelihood, fitted on training groups.
Found best_candidate(const std::filesystem::path& folder, const Model& model) {
  const PhotometryProblem problem(MeasurementSet::open(folder));
  const Groups held = problem.folds().front(), training = complement(held);
  const auto mean_structures = [&](const Model& m) {
    size_t count = 0;
    for (const Structure& s : problem.structure(m, held, 0)) count += s.moment == "mean";
    return count;
  };
  const double before = problem.score(model, held).log_likelihood;
  Found found{.error = problem.score(model, held).error(),
              .structures_before = mean_structures(model)};
  double best = before + 12;
  Model winner = model;
  for (const auto& effect : effects::catalogue()) {
    if (!problem.acts(*effect) || model.has(effect->name) ||
        effect->stage == effects::Stage::timing)
      continue;
    Model with = model;
    std::vector<effects::ParameterValue> values;
    const auto starts = problem.starts(model, *effect);
    if (starts.empty()) continue;  // The values are no multiples of any coarser step.
    const std::vector<double>& start = starts.front();
    for (const double value : start) values.push_back({.value = value, .sigma = 0});
    with.set(effect, values);
    std::vector<Unknown> unknowns;
    for (size_t i = 0; i < values.size(); ++i) {
      if (!effect->parameters[i].integer) unknowns.push_back({effect->name, i});
    }
    const Fit fit = problem.fit(with, unknowns, training);
    const Score score = problem.score(fit.model, held);
    if (score.log_likelihood < best) continue;
    best = score.log_likelihood;
    winner = fit.model;
    found.first = effect->name, found.error = score.error(), found.value = fit.value,
    found.sigma = fit.sigma;
  }
  found.structures_after = mean_structures(winner);
  std::filesystem::remove_all(folder);
  return found;
}

struct Case {
  std::string effect;
  Hidden hidden;
  double truth;  // Of the first parameter.
};

TEST(Photometry, FindsWhatAnIndependentGeneratorHid) {
  std::vector<Case> cases;
  cases.push_back({"vignetting", {.a2 = 0.06}, 0.06});
  cases.push_back({"uneven_lighting", {.gx = 0.03}, 0.03});
  cases.push_back({"shot_noise", {.electrons = 20}, 20});
  cases.push_back({"pixel_gain_spread", {.prnu = 0.012}, 0.012});
  cases.push_back({"pixel_offset_spread", {.dsnu = 0.7}, 0.7});
  cases.push_back({"column_offsets", {.columns = 0.8}, 0.8});
  cases.push_back({"row_noise", {.rows = 0.7}, 0.7});
  cases.push_back({"response_gamma", {.gamma = 0.95}, 0.95});
  cases.push_back({"saturation", {.full = 160}, 160});
  cases.push_back({"quantisation", {.step = 4}, 6});
  cases.push_back({"dark_current", {.dark_offset = 0.6}, 120});
  cases.push_back({"hot_pixels", {.hot_fraction = 0.01, .hot_level = 30}, 0.01});
  cases.push_back({"response_cubic", {.k2 = -0.06}, -0.06});
  cases.push_back({"periodic_pattern", {.wave = 0.4}, 0.4});
  cases.push_back({"lamp_fluctuation", {.lamp = 0.004}, 0.004});
  cases.push_back({"weak_pixels", {.weak_fraction = 0.01, .weak_gain = 0.6}, 0.01});
  cases.push_back({"lamp_flicker", {.depth = 0.05}, 90});
  unsigned seed = 100;
  for (const Case& c : cases) {
    const Found found =
        best_candidate(generate(c.effect, c.hidden, ++seed), nominal(c.effect == "lamp_flicker"));
    EXPECT_EQ(found.first, c.effect);
    // 35,000 held-out values or fewer: 4 standard deviations of the error are 0.015.
    EXPECT_NEAR(found.error, 1, 0.02) << c.effect;
    EXPECT_EQ(found.structures_after, 0u) << c.effect;
    if (!found.value.empty()) {
      EXPECT_NEAR(found.value[0], c.truth, std::max(4 * found.sigma[0], 0.01 * std::abs(c.truth)))
          << c.effect;
    }
  }
}

TEST(Photometry, NothingHiddenIsAdequate) {
  const Found found = best_candidate(generate("none", {}, 7), nominal());
  EXPECT_EQ(found.first, "");
  EXPECT_NEAR(found.error, 1, 0.02);
  EXPECT_EQ(found.structures_before, 0u);
}

TEST(Photometry, WhatNoEffectExplainsLeavesStructure) {
  const auto band = [](int, int v, int) {
    return 1 + 0.04 * std::exp(-0.5 * (v - 15) * (v - 15) / 9.0);
  };
  EXPECT_GT(best_candidate(generate("band", {.extra = band}, 8), nominal()).structures_after, 0u);
  const auto glow = [](int u, int v, int) { return 1 + 0.2 * std::exp(-(u * u + v * v) / 100.0); };
  EXPECT_GT(best_candidate(generate("glow", {.extra = glow}, 9), nominal()).structures_after, 0u);
  const auto drift = [](int, int, int frame) { return 1 + 0.0008 * frame; };
  EXPECT_GT(best_candidate(generate("drift", {.extra = drift}, 10), nominal()).structures_after,
            0u);
}

// A field beyond the range by more than three noises: the one value in thousands that is not
// clipped would make all of its variance. What a dark value has is its own.
TEST(Photometry, ClippedValuesTellNoSmallerVarianceThanTheSetAllows) {
  const effects::SensorChain chain{
      .gain_dn = 4095, .black_dn = 100, .electrons_per_dn = 3, .read_sigma_dn = 3};
  const effects::SensorExposure exposure{.file_bits = 12};
  const SetNoise noise{.least_at_top_dn2 = 130};
  // A model without noise has none at the end of the range, either: else it would be likeliest with
  // all values there.
  const effects::SensorChain silent{.gain_dn = 4095, .black_dn = 100};
  EXPECT_EQ(respond(silent, exposure, 1, noise, 6000).variance,
            respond(silent, exposure, 1, noise, 3000.5).variance);
  EXPECT_LT(respond(chain, exposure, 1, {}, 4130).variance, 1);
  EXPECT_EQ(respond(chain, exposure, 1, noise, 4130).variance, 130);
  EXPECT_EQ(respond(chain, exposure, 1, noise, 0).variance,
            respond(chain, exposure, 1, {}, 0).variance);
  EXPECT_NEAR(respond(chain, exposure, 1, noise, 3000).variance, 1009, 1);
}

// r' S^-1 r and log det S from the dense covariance of all values.
TEST(Photometry, LikelihoodEqualsTheDenseForm) {
  const auto folder = generate("dense", {}, 11);
  Facts facts;
  PhotometryData data = read_photometry(MeasurementSet::open(folder), facts);
  // A crop of 6 x 5 pixels, 3 levels of 2 frames.
  const int width = 6, height = 5;
  PhotometryData crop{.width_px = width, .height_px = height};
  for (int l = 0; l < 3; ++l) {
    crop.levels.push_back(data.levels[l]);
    crop.levels.back().frames.clear();
    crop.levels.back().exposure_s = 0.01 + 0.03 * l;
    for (int k = 0; k < 2; ++k) {
      const auto& image = data.images[l * kPerLevel + k];
      std::vector<uint16_t> part;
      std::vector<double> rows;
      for (int v = 0; v < height; ++v) {
        double mean = 0;
        for (int u = 0; u < width; ++u)
          part.push_back(image[v * kWidth + u]), mean += part.back() / double(width);
        rows.push_back(mean);
      }
      crop.levels.back().frames.push_back(static_cast<int>(crop.frames.size()));
      crop.frames.push_back({.level = l, .time_s = 0.1 * static_cast<double>(crop.frames.size())});
      crop.images.push_back(part);
      crop.row_mean.push_back(rows);
    }
  }
  std::filesystem::remove_all(folder);
  const PhotometrySums sums = sum_frames(crop, Groups(6, 1), {0, 1, 2, 3, 4, 5});
  const Model model = Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects:\n  linear_response: {gain_dn: 220, "
                            "black_dn: 30}\n  read_noise: {sigma_dn: 1.3}\n"
                            "  pixel_gain_spread: {sigma: 0.03}\n  pixel_offset_spread: {sigma_dn: "
                            "0.9}\n  column_offsets: {sigma_dn: 1.1}\n"
                            "  row_noise: {sigma_dn: 0.8}\n  lamp_fluctuation: {sigma: 0.02}\n"
                            "  dark_current_spread: {sigma_dn_per_s: 18}\n",
                            "model"));
  const auto prediction = predict(crop, sums, model, 0);
  const PhotometryScore score = score_photometry(crop, sums, prediction, true);

  const int n = 6 * width * height;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd residual(n);
  const auto signal = [&](int f) { return 220 * crop.levels[f / 2].illumination; };
  const auto dark = [](int f) { return 18 * (0.01 + 0.03 * (f / 2)); };
  for (int a = 0; a < n; ++a) {
    const int fa = a / (width * height), pa = a % (width * height);
    residual[a] = crop.images[fa][pa] - (signal(fa) + 30);
    for (int b = 0; b < n; ++b) {
      const int fb = b / (width * height), pb = b % (width * height);
      double& s = covariance(a, b);
      if (a == b) s += 1.3 * 1.3 + 1.0 / 12;
      if (pa == pb) s += 0.9 * 0.9 + 0.03 * 0.03 * signal(fa) * signal(fb) + dark(fa) * dark(fb);
      if (pa % width == pb % width) s += 1.1 * 1.1;
      if (fa == fb && pa / width == pb / width) s += 0.8 * 0.8;
      if (fa == fb) s += 0.02 * 0.02 * signal(fa) * signal(fb);
    }
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  EXPECT_NEAR(score.chi2, residual.dot(factor.solve(residual)), 0.02 * score.chi2);
}

// Cells of light against every sample, for each part of the likelihood and all together.
TEST(Photometry, CellsOfLightEqualEverySample) {
  const auto folder = generate(
      "cells", {.a2 = 0.3, .electrons = 25, .prnu = 0.01, .hot_fraction = 0.01, .hot_level = 30},
      12);
  const std::string sensor =
      "linear_response: {gain_dn: 219, black_dn: 9}, read_noise: {sigma_dn: 1.3}";
  const std::string lens =
      "vignetting: {a2: 0.31, a4: 0.02}, uneven_lighting: {gx: 0.03, gy: -0.02}, "
      "veiling_glare: {fraction: 0.1}";
  const std::string patterns =
      "pixel_gain_spread: {sigma: 0.011}, pixel_offset_spread: {sigma_dn: 0.6}, "
      "dark_current_spread: {sigma_dn_per_s: 9}";
  const std::vector<std::string> models = {
      sensor,
      sensor + ", " + lens,
      sensor + ", " + lens + ", " + patterns,
      sensor +
          ", shot_noise: {electrons_per_dn: 30}, response_gamma: {gamma: 0.97}, dark_current: "
          "{electrons_per_s: 300}",
      sensor + ", " + lens + ", column_offsets: {sigma_dn: 0.7}",
      sensor + ", " + lens + ", row_noise: {sigma_dn: 0.5}",
      sensor + ", " + lens + ", hot_pixels: {fraction: 0.01, level_dn: 28}",
      sensor + ", " + lens + ", weak_pixels: {fraction: 0.01, gain: 0.7}, hot_pixels: {fraction: " +
          "0.01, level_dn: 28}",
      sensor + ", " + patterns + ", lamp_fluctuation: {sigma: 0.004}, row_noise: {sigma_dn: 0.3}",
      sensor + ", " + lens + ", " + patterns +
          ", periodic_pattern: {amplitude_dn: 0.8, period_px: 6, angle_rad: 0.5, phase_rad: 1}" +
          ", response_cubic: {k2: -0.03, k3: 0.01}, column_offsets: {sigma_dn: 0.7}, " +
          "row_noise: {sigma_dn: 0.5}",
      sensor + ", " + lens + ", lamp_flicker: {frequency_hz: 7, depth: 0.05, phase_rad: 1}",
      sensor + ", " + lens + ", " + patterns +
          ", shot_noise: {electrons_per_dn: 25}, column_offsets: {sigma_dn: 0.7}, " +
          "row_noise: {sigma_dn: 0.5}, hot_pixels: {fraction: 0.01, level_dn: 28}, lamp_flicker: "
          "{frequency_hz: 7, depth: 0.02}"};
  Facts facts;
  PhotometryData data = read_photometry(MeasurementSet::open(folder), facts);
  std::filesystem::remove_all(folder);
  for (size_t l = 0; l < data.levels.size(); ++l) data.levels[l].exposure_s = 0.01 * (1.0 + l);
  const auto compare = [&](bool share) {
    const PhotometrySums sums =
        sum_frames(data, Groups(facts.groups.size(), 1), facts.group_of_row);
    const CellStore store;
    for (const std::string& effects : models) {
      const Model model = Model::from_config(
          ConfigNode::from_text("format: seam-model/1\neffects: {" + effects + "}\n", "model"));
      const double exact =
          score_photometry(data, sums, predict(data, sums, model, 0.1), share).log_likelihood;
      const auto fast = cell_log_likelihood(data, sums, store, model, 0.1, share);
      ASSERT_TRUE(fast.has_value()) << effects;
      EXPECT_NEAR(*fast, exact, 0.5) << effects;  // Of some 10^5; ties begin at 4.6.
    }
  };
  compare(true);
  for (size_t l = 1; l < data.levels.size(); ++l) data.levels[l].illumination = std::nan("");
  compare(true);
  // The same samples as an image of three channels, a third as wide.
  data.channels = 3, data.width_px /= 3;
  for (size_t f = 0; f < data.images.size(); ++f) {
    data.row_mean[f].assign(data.rows(), 0);
    for (size_t i = 0; i < data.samples(); ++i)
      data.row_mean[f][i / kWidth * 3 + i % 3] +=
          data.images[f][i] / static_cast<double>(data.width_px);
  }
  compare(true);
  compare(false);
}

TEST(Photometry, CellsOfLightEqualEverySampleAtStepsAndClipping) {
  const auto folder = generate("clipped", {.a2 = 0.3, .full = 130, .step = 8}, 13);
  Facts facts;
  const PhotometryData data = read_photometry(MeasurementSet::open(folder), facts);
  std::filesystem::remove_all(folder);
  const PhotometrySums sums = sum_frames(data, Groups(facts.groups.size(), 1), facts.group_of_row);
  const CellStore store;
  const Model model = Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects: {linear_response: {gain_dn: 220, black_dn: 9}, read_noise: "
      "{sigma_dn: 1.3}, "
      "vignetting: {a2: 0.3}, saturation: {full_dn: 130}, quantisation: {bits: 5}}\n",
      "model"));
  const double exact =
      score_photometry(data, sums, predict(data, sums, model, 0), true).log_likelihood;
  EXPECT_NEAR(*cell_log_likelihood(data, sums, store, model, 0, true), exact, 1);
}

TEST(Photometry, LightThatMovesOverRowsIsLeftToEverySample) {
  const PhotometryData data;
  const CellStore store;
  const Model model = Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects: {linear_response: {gain_dn: 219, "
                            "black_dn: 9}, rolling_shutter: {line_delay_s: 0.0001}, "
                            "lamp_flicker: {frequency_hz: 90, depth: 0.05}}\n",
                            "model"));
  EXPECT_FALSE(cell_log_likelihood(data, {}, store, model, 0, true).has_value());
}

TEST(Photometry, TheDarkAndEachLevelOfLightAreRegimes) {
  const auto folder = generate("regimes", {}, 1);
  const std::vector<Groups> regimes = PhotometryProblem(MeasurementSet::open(folder)).regimes();
  ASSERT_EQ(regimes.size(), 6u);
  for (const Groups& level : regimes)
    EXPECT_EQ(std::count(level.begin(), level.end(), 1), kPerLevel);
  EXPECT_EQ(regimes.back(), regimes.front());
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace seam::measurement
