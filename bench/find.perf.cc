// `seam replay find` over a match of ten minutes: eight robots without frames, each of which logs
// four values with every decision.
#include <benchmark/benchmark.h>

#include <fstream>

#include "app/logs/log_search.h"
#include "scheduler/replay/log_testing.h"
#include "sim_core/base/maths.h"

namespace seam {
namespace {

using namespace scheduler;
using namespace scheduler::testing;

constexpr double kMatch_s = 600;

Decision talkative(const Observation& seen) {
  Decision decision;
  const double wave = maths::sin(0.7 * seen.time.s() + seen.robot);
  decision.command.joints = {{SimDuration(), {{kPan, wave, 3.0}}}};
  for (const char* name : {"ball_area_px", "x_m", "y_m", "theta_rad"})
    decision.debug.push_back({.kind = DebugItem::Kind::value, .name = name, .value = wave});
  return decision;
}

const std::string& match() {
  static const std::string path = [] {
    const std::string yaml = scenario_text(SEAM_SOURCE_DIR, 8, kMatch_s);
    const Scenario scenario = Scenario::from_text(yaml, "bench");
    World world(scenario);
    RunControl control;
    FunctionSource source(talkative);
    mcap::MemoryOutput output;
    Recorder recorder(output, world);
    Simulation({scenario, world, source, control, nullptr, {&recorder}, header_of(scenario, yaml)})
        .run();
    std::string file = SEAM_BINARY_DIR "/bench_find_10min.mcap";
    std::ofstream(file, std::ios::binary) << output.bytes();
    return file;
  }();
  return path;
}

void find(benchmark::State& state, const char* condition) {
  match();
  size_t hits = 0;
  for (auto _ : state) hits = app::find_in(Log::open(match()), condition).hits.size();
  state.counters["hits"] = static_cast<double>(hits);
}
void BM_FindLogged(benchmark::State& state) {
  find(state, "r1.ball_area_px < 0 for 0.5 s");
}
void BM_FindTruth(benchmark::State& state) {
  find(state, "truth.r1.ball_distance_m < 0.5 && r1.ball_area_px > 0 for 0.5 s");
}
BENCHMARK(BM_FindLogged)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_FindTruth)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace seam

BENCHMARK_MAIN();
