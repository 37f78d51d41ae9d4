// Logs: what recording costs, how large they grow, how fast any moment is reached, and how fast a
// re-run is beside the run that it repeats. 8 robots that walk and swing their heads, no frames.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <fstream>

#include "scheduler/replay/log_testing.h"

namespace seam {
namespace {

using namespace scheduler;
using namespace scheduler::testing;

constexpr int kRobots = 8;

Decision behaviour(const Observation& seen) {
  Decision decision = busy_behaviour(seen);
  decision.frame_requests.clear();
  decision.debug.clear();
  // In small circles: robots that push each other for minutes would measure the physics instead.
  if (decision.command.walk) decision.command.walk->omega_radps += 1;
  return decision;
}

std::string text(double duration_s) {
  return scenario_text(SEAM_SOURCE_DIR, kRobots, duration_s);
}

// One run without log or with one, in memory; returns the log.
std::string run(const Scenario& scenario, const std::string& yaml, bool with_log) {
  World world(scenario);
  RunControl control;
  FunctionSource source(behaviour);
  mcap::MemoryOutput output;
  std::optional<Recorder> recorder;
  std::vector<SimulationObserver*> observers;
  if (with_log) observers.push_back(&recorder.emplace(output, world));
  Simulation simulation(
      {scenario, world, source, control, nullptr, observers, header_of(scenario, yaml)});
  simulation.run();
  return output.bytes();
}

std::string run(double duration_s, bool with_log) {
  const std::string yaml = text(duration_s);
  return run(Scenario::from_text(yaml, "bench"), yaml, with_log);
}

void BM_Run(benchmark::State& state) {
  const double duration_s = 30;
  const bool with_log = state.range(0) != 0;
  size_t bytes = 0;
  for (auto _ : state) bytes = run(duration_s, with_log).size();
  state.counters["sim_s_a_cpu_s"] =
      benchmark::Counter(duration_s, benchmark::Counter::kIsIterationInvariantRate);
  if (with_log) state.counters["MB_a_minute"] = static_cast<double>(bytes) * 60 / duration_s / 1e6;
}
// Wall time: encoding and compression are done in another thread.
BENCHMARK(BM_Run)->ArgName("log")->Arg(0)->Arg(1)->UseRealTime()->Unit(benchmark::kMillisecond);

void BM_Verify(benchmark::State& state) {
  const double duration_s = 30;
  const std::string bytes = run(duration_s, true);
  const Log log = log_of(bytes);
  for (auto _ : state) {
    if (scheduler::testing::verify(log, false).divergence) state.SkipWithError("a divergence");
  }
  state.counters["sim_s_a_cpu_s"] =
      benchmark::Counter(duration_s, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(BM_Verify)->Unit(benchmark::kMillisecond);

// Random times of a match of 20 minutes, read from a file as a user would.
void BM_SeekIn20Minutes(benchmark::State& state) {
  constexpr double kMatch_s = 1200;
  static const std::string path = [] {
    std::string path = SEAM_BINARY_DIR "/bench_replay_20min.mcap";
    std::ofstream(path, std::ios::binary) << run(kMatch_s, true);
    return path;
  }();
  const Log log = Log::open(path);
  state.counters["MB"] = static_cast<double>(log.file().file_bytes()) / 1e6;
  const Scenario scenario = Scenario::from_text(log.header().scenario_text, "log");
  World world(scenario);
  Rewinder rewinder(log, world);
  std::vector<double> ms;
  uint64_t draw = 0;
  for (auto _ : state) {
    const SimTime time = SimTime::from_s(kMatch_s * uniform({3, 1}, draw++));
    const auto start = std::chrono::steady_clock::now();
    rewinder.to(time);
    ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
                     .count());
  }
  std::sort(ms.begin(), ms.end());
  state.counters["median_ms"] = ms[ms.size() / 2];
  state.counters["worst_ms"] = ms.back();
}
BENCHMARK(BM_SeekIn20Minutes)->Iterations(100)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace seam

BENCHMARK_MAIN();
