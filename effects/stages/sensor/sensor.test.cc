#include "effects/stages/sensor/sensor.h"

#include <gtest/gtest.h>

#include <cmath>

#include "effects/registry.h"
#include "effects/stages/optics.h"
#include "sim_core/base/config.h"

namespace seam::effects {
namespace {

Model model_of(const std::string& effects) {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects: {" + effects + "}\n", "test"));
}

struct Sampled {
  Moments moments;
  double count = 0;
};

// Mean and variance of the file's values over frames of a uniform field.
Sampled sample(const SensorChain& chain, double light, const SensorExposure& exposure,
               int frames = 12) {
  const RandomStream camera{.seed = 7, .stream = 1};
  const FixedPattern pattern = fixed_pattern(chain, 100, 100, 1, camera);
  const std::vector<float> illumination(10000, static_cast<float>(light));
  double n = 0, sum = 0, square = 0;
  for (int frame = 0; frame < frames; ++frame) {
    const auto noise = camera.child("frame").child(static_cast<uint64_t>(frame));
    const Image image = expose(chain, pattern, illumination, exposure, noise);
    for (const uint16_t dn : image.samples) n += 1, sum += dn, square += double(dn) * dn;
  }
  const double mean = sum / n;
  return {{mean, square / n - mean * mean}, n};
}

// The moments of the definition agree with samples within 4.5 standard errors (false alarm of a
// case: 7e-6 a moment).
void expect_moments(const std::string& effects, double light, double gain = 1, int bits = 8) {
  const SensorChain chain = sensor_of(model_of(effects));
  const SensorExposure exposure{.exposure_s = 0.01, .gain = gain, .file_bits = bits};
  const Sampled sampled = sample(chain, light, exposure);
  Moments value = response_moments(chain, signal_dn(chain, light, exposure), 1, exposure);
  value.variance_dn2 += chain.read_sigma_dn * chain.read_sigma_dn;
  const Moments expected = file_moments(chain, value, bits);
  const double sd = std::sqrt(expected.variance_dn2);
  EXPECT_NEAR(sampled.moments.mean_dn, expected.mean_dn, 4.5 * sd / std::sqrt(sampled.count) + 1e-9)
      << effects << " light " << light;
  EXPECT_NEAR(sampled.moments.variance_dn2, expected.variance_dn2,
              4.5 * std::sqrt(2.5 / sampled.count) * expected.variance_dn2 + 1e-9)
      << effects << " light " << light;
}

TEST(Sensor, SampledMomentsAgreeWithTheDefinition) {
  const std::string base = "linear_response: {gain_dn: 200, black_dn: 8}, ";
  for (const double light : {0.1, 0.5, 0.9}) {
    expect_moments(base + "read_noise: {sigma_dn: 1.4}", light);
    expect_moments(base + "read_noise: {sigma_dn: 0.35}", light + 0.00123);
    expect_moments(base + "read_noise: {sigma_dn: 1}, shot_noise: {electrons_per_dn: 20}", light);
    expect_moments(base + "read_noise: {sigma_dn: 1}, shot_noise: {electrons_per_dn: 20}", light,
                   1.2);
    expect_moments(base +
                       "read_noise: {sigma_dn: 1}, shot_noise: {electrons_per_dn: 12}, "
                       "dark_current: {electrons_per_s: 3000}",
                   light);
    expect_moments(base + "read_noise: {sigma_dn: 1}, dark_current: {electrons_per_s: 300}", light);
    expect_moments(base +
                       "read_noise: {sigma_dn: 1}, shot_noise: {electrons_per_dn: 9}, "
                       "response_gamma: {gamma: 0.7}",
                   light);
    expect_moments(base + "read_noise: {sigma_dn: 1.4}, quantisation: {bits: 5}", light);
    expect_moments(base +
                       "read_noise: {sigma_dn: 2}, quantisation: {bits: 6}, "
                       "saturation: {full_dn: 108.4}",
                   light);
    expect_moments(base + "read_noise: {sigma_dn: 3}, saturation: {full_dn: 186}", light);
  }
  // The ends of the file's range.
  expect_moments("linear_response: {gain_dn: 300, black_dn: 0.4}, read_noise: {sigma_dn: 1.4}", 0);
  expect_moments("linear_response: {gain_dn: 255, black_dn: 0}, read_noise: {sigma_dn: 2}", 1);
  // 16 bits: many steps a sigma.
  expect_moments("linear_response: {gain_dn: 50000, black_dn: 100}, read_noise: {sigma_dn: 90}",
                 0.0003, 1, 16);
}

// Noise of many steps, where no sum goes over the values: what is far below or above is the file's
// lowest or highest value.
TEST(Sensor, MeansOfFieldsBeyondTheFilesEndsAreItsEnds) {
  const SensorChain chain = sensor_of(model_of("linear_response: {gain_dn: 65535, black_dn: 0}"));
  for (const double sigma : {20.0, 300.0}) {
    EXPECT_NEAR(file_moments(chain, {65535 + 12 * sigma, sigma * sigma}, 16).mean_dn, 65535, 1e-6);
    EXPECT_NEAR(file_moments(chain, {-12 * sigma, sigma * sigma}, 16).mean_dn, 0, 1e-6);
    EXPECT_NEAR(file_moments(chain, {0, sigma * sigma}, 16).mean_dn, 0.39894228 * sigma, 0.01);
    // A response that a fit lets run away leaves no digit of its difference from the end.
    EXPECT_EQ(file_moments(chain, {1e22, sigma * sigma}, 16).mean_dn, 65535);
    EXPECT_EQ(file_moments(chain, {-1e22, 1e30}, 16).mean_dn, 0);
    EXPECT_EQ(file_moments(chain, {1e22, 1e30}, 16).variance_dn2, 0);
  }
}

TEST(Sensor, GammaOfFewElectronsIsExact) {
  // Brute force over the Poisson distribution at the point where the expansion takes over.
  const SensorChain chain =
      sensor_of(model_of("linear_response: {gain_dn: 200}, shot_noise: {electrons_per_dn: 4}, "
                         "response_gamma: {gamma: 0.6}"));
  for (const double electrons : {0.5, 39.0, 41.0, 200.0}) {
    double mean = 0, square = 0, weight = std::exp(-electrons);
    for (int k = 0; k < 700; ++k, weight *= electrons / k) {
      const double dn = k ? 200 * std::pow(k / 4.0 / 200, 0.6) : 0;
      mean += weight * dn, square += weight * dn * dn;
    }
    const Moments got = response_moments(chain, electrons / 4, 1, {});
    EXPECT_NEAR(got.mean_dn, mean, 2e-4) << electrons;
    EXPECT_NEAR(got.variance_dn2, square - mean * mean, 2e-3 * (square - mean * mean)) << electrons;
  }
}

TEST(Sensor, AResponseRisesAsFarAsTheCameraDoesNotClip) {
  // 200 s (1 + k2 s + k3 s^2) with s = signal / 255: rises up to s = 0.5 with k2 = -1, k3 = 0.
  const auto rises = [](const std::string& effects, double signal) {
    return rises_with_light(
        sensor_of(model_of("linear_response: {gain_dn: 200, black_dn: 9}, " + effects)), signal, 1,
        8);
  };
  const std::string falls = "response_cubic: {k2: -1, k3: 0}";
  EXPECT_TRUE(rises(falls, 127));
  EXPECT_FALSE(rises(falls, 129));
  // 72.75 DN at s = 0.5; below 60 DN, where it clips, again from s (1 - s) = 0.2 on, s = 0.7236.
  EXPECT_TRUE(rises(falls + ", saturation: {full_dn: 60}", 184));
  EXPECT_FALSE(rises(falls + ", saturation: {full_dn: 60}", 185));
  // Falls between s = 0.2 and 0.5 alone, and is higher in the end than before.
  const std::string dips = "response_cubic: {k2: -3.5, k3: 3.3333}";
  EXPECT_TRUE(rises(dips, 50));
  EXPECT_FALSE(rises(dips, 100));
  EXPECT_FALSE(rises(dips, 255));
  EXPECT_TRUE(rises("response_cubic: {k2: -1, k3: 0.4}", 1000));  // No slope is zero.
  EXPECT_TRUE(rises("response_gamma: {gamma: 0.5}", 1000));
  // The root of 0.5 x 200 / 200 is where a signal of 50 is bent.
  EXPECT_TRUE(rises("response_gamma: {gamma: 0.5}, " + falls, 50));
  EXPECT_FALSE(rises("response_gamma: {gamma: 0.5}, " + falls, 100));
}

TEST(Sensor, EffectsDrawFromStreamsOfTheirOwn) {
  // Adding an effect that adds nothing visible to a sample leaves the others' noise as it was:
  // the difference of two models is the added effect's own draw, whatever else is on.
  const std::string all =
      "linear_response: {gain_dn: 30000, black_dn: 9000}, read_noise: {sigma_dn: 40}, "
      "pixel_offset_spread: {sigma_dn: 50}, row_noise: {sigma_dn: 60}";
  const RandomStream camera{.seed = 3, .stream = 9};
  const std::vector<float> light(64 * 48, 0.4f);
  const auto render = [&](const std::string& effects) {
    const SensorChain chain = sensor_of(model_of(effects));
    return expose(chain, fixed_pattern(chain, 64, 48, 1, camera), light, {.file_bits = 16},
                  camera.child("frame").child(5));
  };
  const Image base = render(all);
  const Image columns = render(all + ", column_offsets: {sigma_dn: 500}");
  const Image alone_0 = render("linear_response: {gain_dn: 30000, black_dn: 9000}");
  const Image alone_1 =
      render("linear_response: {gain_dn: 30000, black_dn: 9000}, column_offsets: {sigma_dn: 500}");
  for (size_t i = 0; i < base.samples.size(); ++i) {
    // Rounding is all that differs.
    EXPECT_NEAR(columns.samples[i] - base.samples[i], alone_1.samples[i] - alone_0.samples[i],
                1.01);
  }
}

// Each pixel's own, in proportion to the exposure, and the same in the next frame.
TEST(Sensor, DarkCurrentsOfPixelsGrowWithTheExposure) {
  const SensorChain chain =
      sensor_of(model_of("linear_response: {gain_dn: 100, black_dn: 20000}, dark_current_spread: "
                         "{sigma_dn_per_s: 3000}"));
  const FixedPattern pattern = fixed_pattern(chain, 64, 48, 1, {.seed = 3});
  const auto at = [&](double exposure_s, uint64_t frame) {
    return expose(chain, pattern, std::vector<float>(64 * 48, 0.0f),
                  {.exposure_s = exposure_s, .file_bits = 16}, RandomStream{.seed = frame});
  };
  const Image once = at(0.5, 1), again = at(0.5, 2), longer = at(2, 3);
  EXPECT_EQ(once.samples, again.samples);
  double square = 0;
  for (size_t i = 0; i < once.samples.size(); ++i) {
    const double dark_dn = once.samples[i] - 20000.0;
    EXPECT_NEAR(longer.samples[i] - 20000.0, 4 * dark_dn, 2.6);  // Both are rounded.
    square += dark_dn * dark_dn / static_cast<double>(once.samples.size());
  }
  // 3072 pixels know their deviation to 1.3 %.
  EXPECT_NEAR(std::sqrt(square), 1500, 4 * 0.013 * 1500);
}

TEST(Sensor, NeutralSensorIsTheScaledLight) {
  const SensorChain chain = sensor_of(model_of(""));
  const FixedPattern pattern = fixed_pattern(chain, 4, 1, 1, {});
  const std::vector<float> light = {0, 0.5f, 1, 2};
  const Image image = expose(chain, pattern, light, {}, {});
  EXPECT_EQ(image.samples, (std::vector<uint16_t>{0, 128, 255, 255}));
}

TEST(Optics, FlickerIsTheMeanOverTheWindow) {
  const Model model = model_of("lamp_flicker: {frequency_hz: 100, depth: 0.2, phase_rad: 0.4}");
  double sum = 0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const double t = 0.013 + 0.006 * (i + 0.5) / kSteps;
    sum += 1 + 0.2 * std::sin(2 * M_PI * 100 * t + 0.4);
  }
  EXPECT_NEAR(lamp_brightness(model, {.start_s = 0.013, .exposure_s = 0.006}), sum / kSteps, 1e-9);
  EXPECT_NEAR(lamp_brightness(model, {.start_s = 0.1, .exposure_s = 0.02}), 1, 1e-12);
}

TEST(Optics, GainFieldsFollowTheirFormulas) {
  const Model model =
      model_of("vignetting: {a2: 0.3, a4: 0.1}, uneven_lighting: {gx: 0.2, gy: -0.1}");
  const GainField lens(model, Stage::radiometry, 178, 144);
  const GainField lamps(model, Stage::light, 178, 144);
  EXPECT_DOUBLE_EQ(lens.at(88.5, 71.5), 1);
  const double r2 = (88.5 * 88.5 + 71.5 * 71.5) / (89.0 * 89.0 + 72.0 * 72.0);
  EXPECT_NEAR(lens.at(0, 143), 1 - 0.3 * r2 - 0.1 * r2 * r2, 1e-12);
  EXPECT_NEAR(lamps.at(177, 0), 1 + 0.1 + 0.05, 1e-12);
}

}  // namespace
}  // namespace seam::effects
