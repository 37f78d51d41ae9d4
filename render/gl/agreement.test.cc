// The OpenGL renderer against the ray caster, on scenes of shapes: two renderers that share no
// drawing code check each other.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <thread>

#include "render/gl/device.h"
#include "render/golden/golden_frames.h"
#include "render/golden/moving_scenes.h"
#include "render/renderer.h"

namespace seam::render {
namespace {

using namespace testing;

struct Difference {
  double mean = 0, worst = 0, within_6 = 0;
};

Difference between(const LinearImage& a, const LinearImage& b) {
  Difference found;
  size_t count = 0;
  for (int c = 0; c < 3; ++c) {
    for (size_t i = 0; i < a.planes[c].size(); ++i, ++count) {
      const double off = 255 * std::abs(a.planes[c][i] - b.planes[c][i]);
      found.mean += off, found.within_6 += off <= 6;
      found.worst = std::max(found.worst, off);
    }
  }
  found.mean /= static_cast<double>(count), found.within_6 /= static_cast<double>(count);
  return found;
}

// Beside a lens without blur a frame's own samples are seen, of both renderers; many of them leave
// what the renderers themselves differ by.
Difference compare(const char* name, const effects::Model& model, const FrameJob& job,
                   int cast_samples, int drawn_samples) {
  const GlDevice device({}, gl_source());
  const Renderer cast(model, kWidth, kHeight, {.edge_samples_per_pixel = cast_samples});
  const Renderer drawn(model, kWidth, kHeight,
                       {.edge_samples_per_pixel = drawn_samples, .opengl = &device});
  const Difference found = between(cast.render_linear(job), drawn.render_linear(job));
  std::printf("%-22s mean %.3f DN, worst %.1f, within 6 DN %.5f\n", name, found.mean, found.worst,
              found.within_6);
  return found;
}

void expect_agreement(const Difference& found) {
  EXPECT_LE(found.mean, 0.3);
  EXPECT_GE(found.within_6, 0.999);
}

TEST(OpenGl, AgreesOnGoldenFrames) {
  for (const GoldenFrame& golden : golden_frames())
    expect_agreement(compare(golden.name, golden.model, golden.job, 2048, 512));
}

TEST(OpenGl, AgreesBehindALensOfOnePixelBlurByDefault) {
  for (const Case& scene : cases()) {
    const effects::Model model = model_for(scene, 1);
    expect_agreement(compare(scene.name, model, job_of(scene.scene, model, kHeight, 0), 64, 64));
  }
}

TEST(OpenGl, AgreesOnSharpScenesOfManySamples) {
  for (const size_t i : {2, 4}) {
    const Case scene = cases()[i];
    const effects::Model model = model_for(scene, 0);
    expect_agreement(compare(scene.name, model, job_of(scene.scene, model, kHeight, 0), 2048, 512));
  }
}

// A lens whose rays have no common plane: the sides of a cube, each drawn for itself.
TEST(OpenGl, AgreesBehindAFisheyeAndALensOfSplines) {
  for (const std::string lens :
       {"fisheye: {k1: -0.02}", "spline_lens: {fov_x_deg: 106, x_2_3: 0.05, y_3_4: -0.04}"}) {
    const effects::Model model =
        model_of("  pinhole: {fx_px: 85, fy_px: 85, cx_px: 88.5, cy_px: 71.5}\n  " + lens +
                 "\n  rolling_shutter: {line_delay_s: 2.78e-4}\n  exposure: {exposure_s: 0.005}\n");
    expect_agreement(
        compare(lens.c_str(), model, job_of(cases()[0].scene, model, kHeight, 0), 512, 200));
  }
}

TEST(OpenGl, GroundTruthAgrees) {
  const GlDevice device({}, gl_source());
  GoldenFrame golden = golden_frames()[0];
  for (SceneInstant& scene : golden.job.instants) {
    for (size_t i = 0; i < scene.primitives.size(); ++i)
      scene.primitives[i].object_id = static_cast<uint16_t>(i + 1);
  }
  const GroundTruth cast = Renderer(golden.model, kWidth, kHeight).ground_truth(golden.job);
  const GroundTruth drawn =
      Renderer(golden.model, kWidth, kHeight, {.opengl = &device}).ground_truth(golden.job);
  int differ = 0, edges = 0;
  for (int v = 1; v < kHeight - 1; ++v) {
    for (int u = 1; u < kWidth - 1; ++u) {
      const int i = v * kWidth + u;
      bool edge = false;
      for (const int j : {i - 1, i + 1, i - kWidth, i + kWidth})
        edge |= cast.label[i] != cast.label[j] || cast.object_id[i] != cast.object_id[j] ||
                std::abs(cast.depth_m[i] - cast.depth_m[j]) > 0.2f * cast.depth_m[i];
      if (edge) {
        ++edges;
        continue;
      }
      differ += cast.label[i] != drawn.label[i] || cast.object_id[i] != drawn.object_id[i];
      if (cast.object_id[i] == 0 && std::isinf(cast.depth_m[i])) continue;
      EXPECT_NEAR(drawn.depth_m[i], cast.depth_m[i], 0.02 * cast.depth_m[i]) << u << " " << v;
      EXPECT_NEAR(drawn.flow_u_px[i], cast.flow_u_px[i], 0.05) << u << " " << v;
    }
  }
  EXPECT_EQ(differ, 0);
  EXPECT_GT(edges, 100);
}

TEST(OpenGl, SameBitsAgainOnAnyThreadsAndSideBySide) {
  const GlDevice device({}, gl_source());
  const GoldenFrame golden = golden_frames()[2];
  const auto frame = [&](int threads) {
    const Renderer renderer(golden.model, kWidth, kHeight, {.threads = threads, .opengl = &device});
    return renderer.render(golden.job).fingerprint;
  };
  const uint64_t first = frame(1);
  EXPECT_EQ(frame(1), first);
  EXPECT_EQ(frame(3), first);
  std::array<uint64_t, 3> beside{};
  {
    std::vector<std::jthread> threads;
    for (uint64_t& fingerprint : beside) threads.emplace_back([&] { fingerprint = frame(1); });
  }
  for (const uint64_t fingerprint : beside) EXPECT_EQ(fingerprint, first);
}

// What a graphics processor does with its pages, here by Mesa.
TEST(OpenGl, ShadersSumWhatTheProcessorSums) {
  const GlDevice processor({}, gl_source(), Gathering::on_processor);
  const GlDevice shaders({}, gl_source(), Gathering::in_shaders);
  for (const GoldenFrame& golden : golden_frames()) {
    const auto light = [&](const GlDevice& device) {
      return Renderer(golden.model, kWidth, kHeight, {.opengl = &device}).render_linear(golden.job);
    };
    const Difference found = between(light(processor), light(shaders));
    // A sample at a texel's border may be taken for the next one's.
    EXPECT_LE(found.mean, 1e-3) << golden.name;
    EXPECT_LE(found.worst, 6) << golden.name;
    EXPECT_GT(found.within_6, 0) << golden.name;
  }
}

TEST(OpenGl, EglGivesTheBitsOfOsMesaOfOneVersion) {
  if (!opengl_is_here("egl")) GTEST_SKIP() << "no EGL";
  const GlDevice osmesa({}, "osmesa"), egl({}, "egl");
  EXPECT_EQ(osmesa.source(), "osmesa");
  EXPECT_EQ(egl.source(), "egl");
  if (egl.version() != osmesa.version() || egl.renderer() != osmesa.renderer())
    GTEST_SKIP() << egl.renderer() << " beside " << osmesa.renderer();
  const GoldenFrame golden = golden_frames()[2];
  uint64_t fingerprints[2] = {};
  for (const GlDevice* device : {&osmesa, &egl}) {
    const Renderer renderer(golden.model, kWidth, kHeight, {.threads = 1, .opengl = device});
    fingerprints[device == &egl] = renderer.render(golden.job).fingerprint;
  }
  EXPECT_EQ(fingerprints[0], fingerprints[1]);
}

TEST(OpenGl, LeavesNothingInTheEnvironment) {
  setenv("LP_NUM_THREADS", "1", 1);
  const GlDevice device;
  EXPECT_EQ(std::getenv("GALLIUM_OVERRIDE_CPU_CAPS"), nullptr);
  EXPECT_STREQ(std::getenv("LP_NUM_THREADS"), "1");
  unsetenv("LP_NUM_THREADS");
  EXPECT_NE(device.version().find("Mesa"), std::string::npos);
  // 128 bits: SSE, whatever this processor has.
  EXPECT_NE(device.renderer().find("llvmpipe"), std::string::npos);
  EXPECT_NE(device.renderer().find("128 bits"), std::string::npos) << device.renderer();
}

}  // namespace
}  // namespace seam::render
