// Frames made elsewhere (docs/reference/server.md): what one frame's job and pixels take on the
// wire, and what packing and unpacking the job costs beside rendering it.
#include <benchmark/benchmark.h>

#include "bench/match_frames.h"
#include "render/renderer.h"
#include "scheduler/wire/render_wire.h"
#include "seam/v1/render.pb.h"

namespace seam::bench {
namespace {

constexpr int kWidth = 178, kHeight = 144;

struct Match {
  effects::Model model =
      effects::Model::from_file(std::string(SEAM_SOURCE_DIR) + "/models/ers210_full.yaml");
  MatchJobs match = match_jobs(model, kHeight, 8, 8);
  const std::vector<FrameJob>& jobs = match.jobs;
  scheduler::RenderSetup setup;

  Match() {
    setup.cameras = {{.robot = "viewer",
                      .width_px = kWidth,
                      .height_px = kHeight,
                      .model_yaml = {},
                      .model_name = {}}};
    setup.scene = all_primitives(jobs[0], jobs[0].instants[0]);
    setup.background = jobs[0].background;
    setup.lighting = jobs[0].lighting;
  }
};

// A job packed, sent as bytes, parsed and unpacked: both ends' work.
void job_over_wire(benchmark::State& state) {
  const Match match;
  size_t next = 0;
  double bytes = 0, jobs = 0;
  for (auto _ : state) {
    const FrameJob& job = match.jobs[next++ % match.jobs.size()];
    v1::RenderJob sent, received;
    scheduler::job_to_wire(match.setup, next, 0, job, sent);
    const std::string message = sent.SerializeAsString();
    received.ParseFromString(message);
    benchmark::DoNotOptimize(scheduler::job_from_wire(match.setup, received).stamp);
    bytes += static_cast<double>(message.size()), ++jobs;
  }
  state.counters["job_bytes"] = bytes / jobs;
  state.counters["pixel_bytes"] = 3.0 * kWidth * kHeight;
}
BENCHMARK(job_over_wire)->Name("job_over_wire/178x144")->Unit(benchmark::kMillisecond);

void rendering(benchmark::State& state) {
  const Match match;
  const render::Renderer renderer(match.model, kWidth, kHeight);
  size_t next = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(renderer.render(match.jobs[next++ % match.jobs.size()]).fingerprint);
}
BENCHMARK(rendering)->Name("rendering/178x144")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace seam::bench

BENCHMARK_MAIN();
