// Frames: one instant without effects against the whole chain; the names are those of the project's
// benchmark list. Times are of one frame; frame_full_parallel is wall time over all frames made.
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <cmath>
#include <thread>

#ifdef SEAM_HAVE_OPENCV
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#endif

#include "bench/match_frames.h"
#include "render/filter/camera_filter.h"
#include "render/gl/device.h"
#include "render/renderer.h"
#include "render/test_scenes.h"

namespace seam::bench {
namespace {

constexpr int kFrames = 8;

effects::Model model_scaled(const char* file, double scale) {
  effects::Model model =
      effects::Model::from_file(std::string(SEAM_SOURCE_DIR) + "/models/" + file);
  if (scale == 1) return model;
  const effects::ModelEffect pinhole = *model.find("pinhole");
  for (size_t i = 0; i < 4; ++i) model.set_value("pinhole", i, pinhole.values()[i] * scale);
  if (model.has("rolling_shutter")) {
    model.set_value("rolling_shutter", 0, model.find("rolling_shutter")->values()[0] / scale);
  }
  return model;
}

effects::Model instant_model(double scale) {
  effects::Model model = model_scaled("ers210_full.yaml", scale);
  std::vector<std::string> names;
  for (const auto& effect : model.effects()) names.push_back(effect.definition->name);
  for (const std::string& name : names) {
    if (name != "pinhole") model.remove(name);
  }
  return model;
}

void run(benchmark::State& state, const effects::Model& model, int width, int height,
         int instants) {
  const MatchJobs match = match_jobs(model, height, instants, kFrames);
  const std::vector<FrameJob>& jobs = match.jobs;
  const render::Renderer renderer(model, width, height);
  size_t next = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(renderer.render(jobs[next++ % kFrames]).fingerprint);
  state.SetItemsProcessed(state.iterations());
}

// A ring of shared vertices.
render::Mesh ring(int triangles) {
  const auto tube = static_cast<uint32_t>(std::sqrt(triangles / 8.0));
  const uint32_t around = 4 * tube;
  render::Mesh mesh;
  mesh.vertices.reserve(size_t{around} * tube), mesh.indices.reserve(size_t{6} * around * tube);
  for (uint32_t a = 0; a < around; ++a) {
    for (uint32_t b = 0; b < tube; ++b) {
      const double s = 6.283185307179586 * a / around, t = 6.283185307179586 * b / tube;
      const double out = 0.2 + 0.08 * std::cos(t);
      render::MeshVertex vertex{};
      const double p[3] = {out * std::cos(s), out * std::sin(s), 0.08 * std::sin(t)};
      const double n[3] = {std::cos(t) * std::cos(s), std::cos(t) * std::sin(s), std::sin(t)};
      for (int k = 0; k < 3; ++k) {
        vertex.p[k] = static_cast<float>(p[k]), vertex.n[k] = static_cast<float>(n[k]);
        vertex.rgb[k] = 0.5f;
      }
      mesh.vertices.push_back(vertex);
      const uint32_t next_a = (a + 1) % around, next_b = (b + 1) % tube;
      const uint32_t i = a * tube + b, j = next_a * tube + b, k = next_a * tube + next_b,
                     l = a * tube + next_b;
      for (const uint32_t index : {i, j, k, i, k, l}) mesh.indices.push_back(index);
    }
  }
  mesh.parts = {{.first = 0, .count = static_cast<uint32_t>(mesh.indices.size())}};
  mesh.radius_m = 0.28;
  return mesh;
}

void frame_instant(benchmark::State& state) {
  run(state, instant_model(1), 178, 144, 1);
}
BENCHMARK(frame_instant)->Name("frame_instant/178x144")->Unit(benchmark::kMillisecond);

void frame_full(benchmark::State& state) {
  run(state, model_scaled("ers210_full.yaml", 1), 178, 144, 8);
}
BENCHMARK(frame_full)->Name("frame_full/178x144")->Unit(benchmark::kMillisecond);

void frame_full_parallel(benchmark::State& state) {
  const effects::Model model = model_scaled("ers210_full.yaml", 1);
  const MatchJobs match = match_jobs(model, 144, 8, kFrames);
  const std::vector<FrameJob>& jobs = match.jobs;
  const render::Renderer renderer(model, 178, 144);
  const unsigned workers = std::max(1u, std::thread::hardware_concurrency());
  for (auto _ : state) {
    std::vector<std::jthread> threads;
    for (unsigned worker = 0; worker < workers; ++worker) {
      threads.emplace_back([&, worker] {
        for (size_t k = worker; k < 4 * kFrames; k += workers) {
          benchmark::DoNotOptimize(renderer.render(jobs[k % kFrames]).fingerprint);
        }
      });
    }
    threads.clear();
  }
  // Seconds a frame stand beside the time of a batch of 32 frames.
  state.counters["s_per_frame"] = benchmark::Counter(
      4 * kFrames, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["frames_per_s"] =
      benchmark::Counter(4 * kFrames, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(frame_full_parallel)
    ->Name("frame_full_parallel/178x144")
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

void frame_full_large(benchmark::State& state) {
  run(state, model_scaled("ers210_full.yaml", 640.0 / 178), 640, 480, 8);
}
BENCHMARK(frame_full_large)->Name("frame_full/640x480")->Unit(benchmark::kMillisecond);

template <int kInstants>
void frame_full_instants(benchmark::State& state) {
  run(state, model_scaled("ers210_full.yaml", 1), 178, 144, kInstants);
}
BENCHMARK(frame_full_instants<1>)
    ->Name("frame_full/178x144/instants:1")
    ->Unit(benchmark::kMillisecond);
BENCHMARK(frame_full_instants<8>)
    ->Name("frame_full/178x144/instants:8")
    ->Unit(benchmark::kMillisecond);
BENCHMARK(frame_full_instants<32>)
    ->Name("frame_full/178x144/instants:32")
    ->Unit(benchmark::kMillisecond);

// The same frames drawn by OpenGL, and with a mesh of so many triangles beside the robots.
void draw(benchmark::State& state, int mesh_triangles, int frames = kFrames, int width = 178,
          int height = 144) {
  const effects::Model model = model_scaled("ers210_full.yaml", width / 178.0);
  MatchJobs match = match_jobs(model, height, 8, frames);
  std::vector<FrameJob>& jobs = match.jobs;
  render::Assets assets;
  if (mesh_triangles > 0) {
    assets.meshes.push_back(ring(mesh_triangles));
    for (FrameJob& job : jobs) {
      for (SceneInstant& instant : job.instants)
        instant.primitives.push_back({.shape = Shape::mesh,
                                      .X_WO = translation({0.2, 0.2, 0.2}),
                                      .size = Vec3(0.3),
                                      .rgb = {1, 1, 1},
                                      .asset = 1});
    }
  }
  const render::GlDevice device(std::move(assets), render::testing::gl_source());
  const render::Renderer renderer(model, width, height, {.opengl = &device});
  // A context and its shaders are made once.
  benchmark::DoNotOptimize(renderer.render(jobs[0]).fingerprint);
  size_t next = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(renderer.render(jobs[next++ % jobs.size()]).fingerprint);
}
void frame_opengl(benchmark::State& state) {
  draw(state, static_cast<int>(state.range(0)));
}
BENCHMARK(frame_opengl)
    ->Name("frame_opengl/178x144/triangles")
    ->Arg(0)
    ->Arg(8'000)
    ->Arg(100'000)
    ->Unit(benchmark::kMillisecond);

void frame_opengl_large(benchmark::State& state) {
  draw(state, 0, kFrames, 640, 480);
}
BENCHMARK(frame_opengl_large)->Name("frame_opengl/640x480")->Unit(benchmark::kMillisecond);

// What a million triangles take: the process's memory at its highest, all of it.
void frame_opengl_memory(benchmark::State& state) {
  draw(state, 1'000'000, 2);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  state.counters["peak_mib"] = static_cast<double>(usage.ru_maxrss) / 1024;
}
BENCHMARK(frame_opengl_memory)
    ->Name("frame_opengl/178x144/million")
    ->Iterations(2)
    ->Unit(benchmark::kMillisecond);

// Frames of two contexts at once against those of one: wall time for as many frames each.
void frame_opengl_contexts(benchmark::State& state) {
  const effects::Model model = model_scaled("ers210_full.yaml", 1);
  const MatchJobs match = match_jobs(model, 144, 8, kFrames);
  const std::vector<FrameJob>& jobs = match.jobs;
  const render::GlDevice device({}, render::testing::gl_source());
  const render::Renderer renderer(model, 178, 144, {.opengl = &device});
  const auto contexts = static_cast<size_t>(state.range(0));
  const auto draw_all = [&] {
    std::vector<std::jthread> threads;
    for (size_t context = 0; context < contexts; ++context) {
      threads.emplace_back([&] {
        for (const FrameJob& job : jobs) benchmark::DoNotOptimize(renderer.render(job).fingerprint);
      });
    }
  };
  draw_all();
  for (auto _ : state) draw_all();
  state.counters["frames_per_s"] = benchmark::Counter(
      static_cast<double>(contexts * kFrames), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(frame_opengl_contexts)
    ->Name("frame_opengl/178x144/contexts")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

// The camera's filter on a finished pinhole image: distortion, blur 5x5, vignetting, noise, 8 bits.
effects::Model filter_model() {
  return effects::Model::from_config(
      ConfigNode::from_text("format: seam-model/1\nname: filter\neffects:\n"
                            "  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}\n"
                            "  radial_distortion: {kappa: -0.05}\n"
                            "  lens_blur: {sigma_px: 1.0, window_px: 5}\n"
                            "  vignetting: {a2: 0.25, a4: 0.05}\n"
                            "  read_noise: {sigma_dn: 2}\n",
                            "filter"));
}

render::LinearImage ideal_image() {
  const effects::Model pinhole = instant_model(1);
  return render::Renderer(pinhole, 178, 144).render_scene(match_jobs(pinhole, 144, 1, 1).jobs[0]);
}

void filter_fused(benchmark::State& state) {
  const render::LinearImage ideal = ideal_image();
  const render::ImageFilter filter(filter_model(), 178, 144, {});
  std::vector<uint8_t> rgb;
  uint64_t frame = 0;
  for (auto _ : state) {
    filter.apply(ideal, RandomStream{}.child(frame++), rgb);
    benchmark::DoNotOptimize(rgb.data());
  }
}
BENCHMARK(filter_fused)->Name("filter_fused/178x144")->Unit(benchmark::kMillisecond);

void filter_passes(benchmark::State& state) {
  const render::LinearImage ideal = ideal_image();
  const render::ImageFilter filter(filter_model(), 178, 144, {});
  std::vector<uint8_t> rgb;
  uint64_t frame = 0;
  for (auto _ : state) {
    filter.apply_in_passes(ideal, RandomStream{}.child(frame++), rgb);
    benchmark::DoNotOptimize(rgb.data());
  }
}
BENCHMARK(filter_passes)->Name("filter_passes/178x144")->Unit(benchmark::kMillisecond);

#ifdef SEAM_HAVE_OPENCV
void opencv_passes(benchmark::State& state) {
  cv::setNumThreads(1);
  constexpr int kWidth = 178, kHeight = 144;
  const render::LinearImage ideal = ideal_image();
  cv::Mat image(kHeight, kWidth, CV_32FC3), map_u(kHeight, kWidth, CV_32F),
      map_v(kHeight, kWidth, CV_32F);
  cv::Mat gain(kHeight, kWidth, CV_32FC3), noise(kHeight, kWidth, CV_32FC3), bent, soft, shaded,
      noisy, bytes;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      map_u.at<float>(v, u) = static_cast<float>(u) * 1.01f,
                         map_v.at<float>(v, u) = static_cast<float>(v) * 1.01f;
      for (int c = 0; c < 3; ++c) {
        image.at<cv::Vec3f>(v, u)[c] = 255 * ideal.planes[c][static_cast<size_t>(v) * kWidth + u];
        gain.at<cv::Vec3f>(v, u)[c] = 0.9f;
      }
    }
  }
  for (auto _ : state) {
    cv::remap(image, bent, map_u, map_v, cv::INTER_LINEAR);
    cv::GaussianBlur(bent, soft, cv::Size(5, 5), 1.0);
    cv::multiply(soft, gain, shaded);
    cv::randn(noise, 0, 2.0);
    cv::add(shaded, noise, noisy);
    noisy.convertTo(bytes, CV_8U);
    benchmark::DoNotOptimize(bytes.data);
  }
}
BENCHMARK(opencv_passes)->Name("opencv_passes/178x144")->Unit(benchmark::kMillisecond);
#endif

}  // namespace
}  // namespace seam::bench

BENCHMARK_MAIN();
