// Each sensor effect alone, seen in finished 8-bit frames of even fields, and the independence of
// noise. Statistics are held to 4.5 standard errors: each such comparison fails by chance in 7 of a
// million seeds, and the seeds are fixed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "render/renderer.h"
#include "render/test_scenes.h"

namespace seam::render {
namespace {

using namespace testing;

constexpr int kPixels = kWidth * kHeight;
constexpr double kSure = 4.5;

// Frames of an even field by one camera, as one channel's values.
struct Camera {
  Camera(const std::string& effects, uint64_t robot = 1)
      : model(model_of("  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}\n" +
                       effects)),
        renderer(model, kWidth, kHeight),
        robot(robot) {}

  std::vector<double> frame(double light, uint64_t index, int channel = 1) const {
    MovingScene scene;
    scene.background = {light, light, light};
    scene.camera = [](double) { return head_camera(0, 0, 0, 0); };
    scene.primitives = [](double) { return std::vector<Primitive>(); };
    FrameJob job = job_of(scene, model, kHeight, 0);
    job.frame_index = index;
    job.camera_noise = RandomStream{.seed = 5}.child(robot).child("noise");
    job.frame_noise = job.camera_noise.child("frame").child(index);
    const Frame frame = renderer.render(job);
    std::vector<double> values;
    for (int i = 0; i < kPixels; ++i) values.push_back(frame.rgb[3 * i + channel]);
    return values;
  }

  effects::Model model;
  Renderer renderer;
  uint64_t robot;
};

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}
double variance_of(const std::vector<double>& values) {
  const double mean = mean_of(values);
  double sum = 0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return sum / static_cast<double>(values.size() - 1);
}
double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const double mean_a = mean_of(a), mean_b = mean_of(b);
  double ab = 0, aa = 0, bb = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - mean_a) * (b[i] - mean_b);
    aa += (a[i] - mean_a) * (a[i] - mean_a), bb += (b[i] - mean_b) * (b[i] - mean_b);
  }
  return ab / std::sqrt(aa * bb);
}
void expect_independent(const std::vector<double>& a, const std::vector<double>& b,
                        const std::string& what) {
  EXPECT_LT(std::abs(correlation(a, b)), kSure / std::sqrt(static_cast<double>(a.size()))) << what;
}
// A variance that n normal values have by chance when it is `expected`.
void expect_variance(double found, double expected, double n, const std::string& what) {
  EXPECT_NEAR(found, expected, kSure * expected * std::sqrt(2 / n)) << what;
}
std::vector<double> difference(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> result;
  for (size_t i = 0; i < a.size(); ++i) result.push_back(a[i] - b[i]);
  return result;
}
// Of each row or each column.
std::vector<double> row_means(const std::vector<double>& frame) {
  std::vector<double> means(kHeight);
  for (int i = 0; i < kPixels; ++i)
    means[static_cast<size_t>(i / kWidth)] += frame[static_cast<size_t>(i)] / kWidth;
  return means;
}
std::vector<double> column_means(const std::vector<double>& frame) {
  std::vector<double> means(kWidth);
  for (int i = 0; i < kPixels; ++i)
    means[static_cast<size_t>(i % kWidth)] += frame[static_cast<size_t>(i)] / kHeight;
  return means;
}
const std::string kRead = "  read_noise: {sigma_dn: 2}\n";
constexpr double kReadVariance = 4 + 1.0 / 12;  // With the rounding's.

TEST(SensorImages, ResponseGammaBalanceAndClip) {
  EXPECT_EQ(Camera("  linear_response: {gain_dn: 180, black_dn: 12}\n").frame(0.5, 0)[7], 102);
  EXPECT_EQ(Camera("  response_gamma: {gamma: 0.6}\n").frame(0.3, 0)[7],
            std::round(255 * std::pow(0.3, 0.6)));
  EXPECT_EQ(Camera("  white_balance: {red_gain: 1.2, blue_gain: 0.8}\n").frame(0.5, 0, 0)[7], 153);
  EXPECT_EQ(Camera("  white_balance: {red_gain: 1.2, blue_gain: 0.8}\n").frame(0.5, 0, 2)[7], 102);
  EXPECT_EQ(Camera("  saturation: {full_dn: 200}\n").frame(0.9, 0)[7], 200);
  EXPECT_EQ(Camera("  quantisation: {bits: 4}\n").frame(0.5, 0)[7],
            128);  // 127.5 to multiples of 16.
}

TEST(SensorImages, ReadNoiseIsThereInTheDarkAndInTheLight) {
  const Camera camera("  linear_response: {gain_dn: 200, black_dn: 20}\n" + kRead);
  for (const double light : {0.0, 0.8}) {
    const std::vector<double> frame = camera.frame(light, 3);
    expect_variance(variance_of(frame), kReadVariance, kPixels, "light " + std::to_string(light));
    EXPECT_NEAR(mean_of(frame), 20 + 200 * light, kSure * 2.02 / std::sqrt(kPixels));
  }
}

TEST(SensorImages, ShotNoiseMakesTheMeanVarianceLine) {
  const Camera camera("  shot_noise: {electrons_per_dn: 8}\n");
  for (const double light : {0.1, 0.3, 0.5, 0.7}) {
    const double mean = 255 * light;
    expect_variance(variance_of(camera.frame(light, 2)), mean / 8 + 1.0 / 12, kPixels,
                    "light " + std::to_string(light));
  }
}

TEST(SensorImages, DarkCurrentGrowsWithTheExposure) {
  // 800 electrons a second, 4 a DN: 2 DN in 10 ms, 6 DN in 30 ms. The read noise evens out the
  // rounding.
  for (const auto& [exposure, expected_dn] : {std::pair{"0.01", 2.0}, {"0.03", 6.0}}) {
    const Camera camera(
        "  linear_response: {gain_dn: 200, black_dn: 20}\n  shot_noise: {electrons_per_dn: 4}\n"
        "  dark_current: {electrons_per_s: 800}\n  exposure: {exposure_s: " +
        std::string(exposure) + "}\n" + kRead);
    const std::vector<double> frame = camera.frame(0, 1);
    const double variance = expected_dn / 4 + kReadVariance;
    EXPECT_NEAR(mean_of(frame), 20 + expected_dn, kSure * std::sqrt(variance / kPixels))
        << exposure;
    expect_variance(variance_of(frame), variance, kPixels, exposure);
  }
}

TEST(SensorImages, FixedPatternsStayAndGainGrowsWithTheLight) {
  const Camera gain("  pixel_gain_spread: {sigma: 0.03}\n"),
      offset(
          "  linear_response: {gain_dn: 200, black_dn: 20}\n"
          "  pixel_offset_spread: {sigma_dn: 3}\n");
  EXPECT_EQ(gain.frame(0.6, 1), gain.frame(0.6, 2));
  for (const double light : {0.2, 0.6})
    expect_variance(variance_of(gain.frame(light, 1)), std::pow(0.03 * 255 * light, 2) + 1.0 / 12,
                    kPixels, "gain spread");
  EXPECT_EQ(offset.frame(0, 1), offset.frame(0, 2));
  for (const double light : {0.0, 0.7})
    expect_variance(variance_of(offset.frame(light, 1)), 9 + 1.0 / 12, kPixels, "offset spread");
}

TEST(SensorImages, ColumnsAreStripesThatStayRowsStripesThatChange) {
  const Camera columns("  column_offsets: {sigma_dn: 4}\n"), rows("  row_noise: {sigma_dn: 4}\n");
  const std::vector<double> a = columns.frame(0.5, 1);
  EXPECT_EQ(a, columns.frame(0.5, 2));
  for (int i = kWidth; i < kPixels; ++i)
    ASSERT_EQ(a[static_cast<size_t>(i)], a[static_cast<size_t>(i - kWidth)]);
  expect_variance(variance_of(column_means(a)), 16, kWidth, "columns");

  const std::vector<double> b = rows.frame(0.5, 1), c = rows.frame(0.5, 2);
  for (int i = 0; i < kPixels; ++i)
    ASSERT_EQ(b[static_cast<size_t>(i)], b[static_cast<size_t>(i / kWidth * kWidth)]);
  expect_variance(variance_of(row_means(b)), 16, kHeight, "rows");
  expect_independent(row_means(b), row_means(c), "rows of two frames");
}

TEST(SensorImages, HotPixelsAreFewAndStay) {
  const Camera camera("  hot_pixels: {fraction: 0.01, level_dn: 60}\n");
  const std::vector<double> frame = camera.frame(0.4, 1);
  EXPECT_EQ(frame, camera.frame(0.4, 2));
  const double usual = 255 * 0.4;
  const auto hot = kPixels - std::count(frame.begin(), frame.end(), usual);
  EXPECT_NEAR(static_cast<double>(hot), 0.01 * kPixels, kSure * std::sqrt(0.01 * kPixels));
}

TEST(SensorImages, NoiseIsIndependentBetweenPixelsRowsChannelsFramesAndRobots) {
  const std::string noise = "  shot_noise: {electrons_per_dn: 10}\n" + kRead;
  const Camera one(noise, 1), other(noise, 2);
  const std::vector<double> frame = one.frame(0.5, 10);
  for (const int lag : {1, 2, 4, 8, 16, 64, kWidth, 2 * kWidth})
    expect_independent({frame.begin(), frame.end() - lag}, {frame.begin() + lag, frame.end()},
                       "pixels " + std::to_string(lag) + " apart");
  expect_independent(frame, one.frame(0.5, 10, 0), "channels");
  expect_independent(frame, one.frame(0.5, 10, 2), "channels");
  for (const uint64_t index : {11, 12, 266, 1010})
    expect_independent(frame, one.frame(0.5, index), "frames");
  expect_independent(frame, other.frame(0.5, 10), "robots");
  // Fixed patterns are each robot's own.
  const std::string pattern =
      "  pixel_gain_spread: {sigma: 0.03}\n  column_offsets: {sigma_dn: 3}\n";
  const std::vector<double> a = Camera(pattern, 1).frame(0.5, 1),
                            b = Camera(pattern, 2).frame(0.5, 1);
  expect_independent(column_means(a), column_means(b), "columns of two robots");
  for (int u = 0; u < 3; ++u) {
    std::vector<double> column_a, column_b;
    for (int v = 0; v < kHeight; ++v) {
      column_a.push_back(a[static_cast<size_t>(v * kWidth + u)]);
      column_b.push_back(b[static_cast<size_t>(v * kWidth + u)]);
    }
    expect_independent(column_a, column_b, "pixels' gains of two robots");
  }
}

// What one effect draws does not depend on which others are there: with an effect more, the image
// changes by what that effect alone does, to the rounding.
TEST(SensorImages, AnEffectLeavesTheNoiseOfAllOthers) {
  const std::vector<std::string> all = {
      "  read_noise: {sigma_dn: 3}\n",        "  row_noise: {sigma_dn: 4}\n",
      "  column_offsets: {sigma_dn: 4}\n",    "  pixel_offset_spread: {sigma_dn: 4}\n",
      "  pixel_gain_spread: {sigma: 0.03}\n", "  hot_pixels: {fraction: 0.01, level_dn: 30}\n"};
  const auto without = [&](size_t left_out) {
    std::string effects;
    for (size_t i = 0; i < all.size(); ++i)
      if (i != left_out) effects += all[i];
    return Camera(effects).frame(0.5, 4);
  };
  const std::vector<double> whole = without(all.size()), ideal = Camera("").frame(0.5, 4);
  for (size_t i = 0; i < all.size(); ++i) {
    const std::vector<double> added = difference(whole, without(i));
    const std::vector<double> alone = difference(Camera(all[i]).frame(0.5, 4), ideal);
    double worst = 0;
    for (size_t pixel = 0; pixel < added.size(); ++pixel)
      worst = std::max(worst, std::abs(added[pixel] - alone[pixel]));
    EXPECT_LE(worst, 2) << all[i];  // Four roundings of half a DN.
  }
}

}  // namespace
}  // namespace seam::render
