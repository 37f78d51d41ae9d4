// The practice set `frames-a` with its answer added: whole images by an independent brute-force ray
// caster. This checks every convention at once: rig, signs, stamps, units of light.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "render/renderer.h"
#include "render/test_scenes.h"
#include "sim_core/base/image.h"

namespace seam::render {
namespace {

using namespace testing;

std::filesystem::path measurements() {
  const char* given = std::getenv("SEAM_MEASUREMENTS");
  return given ? std::filesystem::path(given)
               : std::filesystem::path(SEAM_SOURCE_DIR) / "../shared/measurements";
}

std::vector<std::vector<std::string>> csv_rows(const std::filesystem::path& path) {
  std::vector<std::vector<std::string>> rows;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::vector<std::string> cells;
    std::stringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    rows.push_back(cells);
  }
  rows.erase(rows.begin());
  return rows;
}

// Joint log, 8 ms apart, by cubic (Catmull-Rom) interpolation.
class JointLog {
 public:
  explicit JointLog(const std::filesystem::path& path) {
    for (const auto& row : csv_rows(path)) {
      tilt_.push_back(std::stod(row[1]));
      pan_.push_back(std::stod(row[2]));
    }
  }
  double tilt(double t_s) const { return at(tilt_, t_s); }
  double pan(double t_s) const { return at(pan_, t_s); }

 private:
  static double at(const std::vector<double>& q, double t_s) {
    const double place = t_s / 0.008;
    const auto k = static_cast<size_t>(std::clamp(place, 1.0, double(q.size()) - 3));
    const double f = place - double(k);
    const double a = q[k - 1], b = q[k], c = q[k + 1], d = q[k + 2];
    return b + 0.5 * f * (c - a + f * (2 * a - 5 * b + 4 * c - d + f * (3 * (b - c) + d - a)));
  }
  std::vector<double> tilt_, pan_;
};

TEST(FramesA, AnswerAddedLeavesTheNoiseAlone) {
  const auto folder = measurements() / "frames-a";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const JointLog joints(folder / "joints.csv");
  MovingScene scene;
  scene.camera = [&](double t_s) {
    return translation({0, 0, 0.195}) * rotation(rotation_about({0, 1, 0}, joints.tilt(t_s))) *
           translation({0, 0, 0.048}) * rotation(rotation_about({0, 0, 1}, joints.pan(t_s))) *
           translation({0.0666, 0, 0}) * rotation(link_to_camera_axes());
  };
  scene.primitives = [](double t_s) {
    return std::vector<Primitive>{ground({0, 0, 0}, 4.2, 2.7, {0.05, 0.35, 0.08}),
                                  sphere({0.8, -0.2 + 0.5 * t_s, 0.042}, 0.042, {0.9, 0.3, 0.02}),
                                  sphere({0.6, 0.25, 0.09}, 0.09, {0.1, 0.2, 0.8}),
                                  upright_cylinder({1.2, 0.6, 0}, 0.05, 0.4, {0.9, 0.4, 0.5}),
                                  upright_cylinder({1.4, -0.5, 0}, 0.05, 0.4, {0.9, 0.85, 0.1}),
                                  upright_cylinder({1, 0, 0}, 0.03, 0.5, {0.2, 0.6, 0.9})};
  };
  const effects::Model model = model_of(
      "  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}\n"
      "  rolling_shutter: {line_delay_s: 2.6e-4}\n"
      "  exposure: {exposure_s: 0.005}\n");
  const Renderer renderer(model, 178, 144, {.edge_samples_per_pixel = 128});
  double sum = 0;
  size_t count = 0;
  for (const auto& row : csv_rows(folder / "frames.csv")) {
    const Image truth = read_png(folder / row[1]);
    const LinearImage light =
        renderer.render_linear(job_of(scene, model, 144, std::stod(row[2]), 16));
    for (size_t i = 0; i < truth.samples.size(); ++i) {
      const double residual = truth.samples[i] - 255.0 * light.planes[i % 3][i / 3];
      // Dark values are clipped at 0, which no residual of an unclipped mean can follow.
      if (light.planes[i % 3][i / 3] * 255 < 6) continue;
      sum += residual * residual / (1.5 * 1.5 + 1.0 / 12);
      ++count;
    }
  }
  EXPECT_NEAR(std::sqrt(sum / double(count)), 1.0, 0.03);
  RecordProperty("error", std::to_string(std::sqrt(sum / double(count))));
  std::printf("frames-a error %.4f over %zu values\n", std::sqrt(sum / double(count)), count);
}

}  // namespace
}  // namespace seam::render
