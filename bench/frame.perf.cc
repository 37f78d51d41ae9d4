// Frames: one instant without effects against the whole chain; the names are those of the project's
// benchmark list. Times are of one frame; frame_full_parallel is wall time over all frames made.
#include <benchmark/benchmark.h>

#include <thread>

#include "bench/match_frames.h"
#include "render/renderer.h"

namespace seam::bench {
namespace {

constexpr int kFrames = 8;

effects::Model model_scaled(const char* file, double scale) {
  effects::Model model = effects::Model::from_file(std::string(SEAM_SOURCE_DIR) + "/models/" + file);
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

void run(benchmark::State& state, const effects::Model& model, int width, int height, int instants) {
  const std::vector<FrameJob> jobs = match_jobs(model, height, instants, kFrames);
  const render::Renderer renderer(model, width, height);
  size_t next = 0;
  for (auto _ : state) benchmark::DoNotOptimize(renderer.render(jobs[next++ % kFrames]).fingerprint);
  state.SetItemsProcessed(state.iterations());
}

void frame_instant(benchmark::State& state) { run(state, instant_model(1), 178, 144, 1); }
BENCHMARK(frame_instant)->Name("frame_instant/178x144")->Unit(benchmark::kMillisecond);

void frame_full(benchmark::State& state) { run(state, model_scaled("ers210_full.yaml", 1), 178, 144, 8); }
BENCHMARK(frame_full)->Name("frame_full/178x144")->Unit(benchmark::kMillisecond);

void frame_full_parallel(benchmark::State& state) {
  const effects::Model model = model_scaled("ers210_full.yaml", 1);
  const std::vector<FrameJob> jobs = match_jobs(model, 144, 8, kFrames);
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
  state.counters["frames_per_s"] = benchmark::Counter(4 * kFrames, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(frame_full_parallel)->Name("frame_full_parallel/178x144")->UseRealTime()->Unit(benchmark::kMillisecond);

void frame_full_large(benchmark::State& state) {
  run(state, model_scaled("ers210_full.yaml", 640.0 / 178), 640, 480, 8);
}
BENCHMARK(frame_full_large)->Name("frame_full/640x480")->Unit(benchmark::kMillisecond);

template <int kInstants>
void frame_full_instants(benchmark::State& state) {
  run(state, model_scaled("ers210_full.yaml", 1), 178, 144, kInstants);
}
BENCHMARK(frame_full_instants<1>)->Name("frame_full/178x144/instants:1")->Unit(benchmark::kMillisecond);
BENCHMARK(frame_full_instants<8>)->Name("frame_full/178x144/instants:8")->Unit(benchmark::kMillisecond);
BENCHMARK(frame_full_instants<32>)->Name("frame_full/178x144/instants:32")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace seam::bench

BENCHMARK_MAIN();
