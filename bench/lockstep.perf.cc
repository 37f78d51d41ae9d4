// The lockstep on direct lines and over gRPC: rounds with clients in processes of their own, beside
// a bare unary call of the same machine in the same run.
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <grpcpp/grpcpp.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>

#include "app/simulator.h"
#include "scheduler/clients/client_hub.h"
#include "scheduler/loop/simulation.h"
#include "scheduler/server/server.h"
#include "seam/v1/simulation.grpc.pb.h"

namespace {

using namespace seam;  // NOLINT: a program of its own.

enum class Cameras { none, ers210, all_effects };

// `robots` head swings; half of the teams' places each, no two frames at one instant.
std::string scenario_yaml(int64_t robots, int64_t decision_ms, Cameras cameras) {
  const bool frames = cameras != Cameras::none;
  const char* model = cameras == Cameras::all_effects ? "ers210_full" : "ers210";
  std::string yaml = fmt::format(
      "format: seam-scenario/1\nname: bench\nduration_s: 100000\nseed: 1\n"
      "field: {}/models/field_2002.yaml\nball: {{x_m: 0.1, y_m: 0.2}}\nrobots:\n",
      SEAM_SOURCE_DIR);
  for (int64_t i = 0; i < robots; ++i)
    yaml += fmt::format(
        "  - id: r{0}\n    team: {1}\n    pose: {{x_m: {2}, y_m: {3}, theta_rad: {4}}}\n"
        "    body: {5}/models/robot_ers210.yaml\n"
        "    camera: {{model: {5}/models/{9}.yaml, every_frame: {6}, clock: {{phase_s: {7}}}}}\n"
        "    behaviour: {{clock: {{period_s: {8}}}}}\n",
        i, i % 2 == 0 ? "red" : "blue", -1.8 + 0.5 * static_cast<double>(i % 8),
        0.9 - 0.6 * static_cast<double>(i / 8), 0.4 * static_cast<double>(i), SEAM_SOURCE_DIR,
        frames, 0.005 * static_cast<double>(i % 8), 0.001 * static_cast<double>(decision_ms),
        model);
  return yaml;
}

enum class Way { direct_line, grpc };

// head_swing in a process a robot, as `seam run` has it.
class Clients {
 public:
  Clients(const std::string& address, const std::string& line, int64_t robots) {
    const std::string program = std::string(SEAM_BINARY_DIR) + "/behaviours/head_swing";
    for (int64_t i = 0; i < robots; ++i) {
      const std::string id = fmt::format("r{}", i), token = "token-" + id;
      const pid_t pid = fork();
      if (pid == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        setenv("SEAM_ADDRESS", address.c_str(), 1);
        setenv("SEAM_LINE", line.c_str(), 1);
        execl(program.c_str(), "head_swing", "--no-frames", "--robot", id.c_str(), "--token",
              token.c_str(), nullptr);
        _exit(127);
      }
      pids_.push_back(pid);
    }
  }
  // Processor time so far.
  double cpu_s() const {
    double ticks = 0;
    for (const pid_t pid : pids_) {
      std::ifstream file(fmt::format("/proc/{}/stat", pid));
      std::string word;  // 14 and 15 are user and system time; the name has no spaces here.
      for (int field = 1; file >> word; ++field)
        if (field == 14 || field == 15) ticks += std::stod(word);
    }
    return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
  }
  ~Clients() {
    for (const pid_t pid : pids_) {
      kill(pid, SIGTERM);
      waitpid(pid, nullptr, 0);
    }
  }

 private:
  std::vector<pid_t> pids_;
};

// One run that the benchmark's iterations advance piece by piece.
struct Live {
  Live(int64_t robots, int64_t decision_ms, Cameras cameras, Way way)
      : simulator(app::make_simulator(
            Scenario::from_text(scenario_yaml(robots, decision_ms, cameras), "bench.yaml"))),
        hub(hub_robots(simulator.scenario), control),
        address(fmt::format("unix:{}/seam-bench-{}",
                            std::filesystem::temp_directory_path().string(), getpid())),
        line(address.substr(5) + "-lines"),
        server({.addresses = {address}, .supervisor_token = "boss", .lines = line},
               simulator.scenario, simulator.world, hub, control),
        clients(address, way == Way::direct_line ? line : "", robots),
        simulation({simulator.scenario,
                    simulator.world,
                    hub,
                    control,
                    cameras == Cameras::none ? nullptr : simulator.renderer.get(),
                    {},
                    simulator.header}) {
    simulation.run_to(SimTime::from_s(1));  // All connected, all warm.
  }
  ~Live() { hub.finish(simulation.now(), "done"); }

  static std::vector<scheduler::HubRobot> hub_robots(const Scenario& scenario) {
    std::vector<scheduler::HubRobot> robots;
    for (const RobotSpec& robot : scenario.robots)
      robots.push_back({robot.id, "token-" + robot.id});
    return robots;
  }

  app::Simulator simulator;
  scheduler::RunControl control;
  scheduler::ClientHub hub;
  std::string address;
  std::string line;
  scheduler::Server server;
  Clients clients;
  scheduler::Simulation simulation;
};

// Of this process, the server.
double server_cpu_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

void run_live(benchmark::State& state, Cameras cameras, Way way = Way::direct_line) {
  Live live(state.range(0), state.range(1), cameras, way);
  const uint64_t decisions = live.simulation.decisions(), made = live.simulation.frames();
  const double waited_s = live.hub.wall_waiting_s();
  const SimTime start = live.simulation.now();
  SimTime until = start;
  const double server_s = server_cpu_s(), clients_s = live.clients.cpu_s();
  const auto wall_start = std::chrono::steady_clock::now();
  for (auto _ : state) {
    until = until + SimDuration::from_ns(state.range(1) * 1'000'000);  // One round.
    live.simulation.run_to(until);
  }
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - wall_start;
  using benchmark::Counter;
  const double done = static_cast<double>(live.simulation.decisions() - decisions);
  state.counters["decisions_per_s"] = Counter(done, Counter::kIsRate);
  state.counters["real_time_factor"] = (until - start).s() / wall.count();
  // Processor seconds a simulated second: what counts where the machine has other work too.
  state.counters["server_cpu"] = (server_cpu_s() - server_s) / (until - start).s();
  state.counters["clients_cpu"] = (live.clients.cpu_s() - clients_s) / (until - start).s();
  state.counters["waiting_share"] = (live.hub.wall_waiting_s() - waited_s) / wall.count();
  if (cameras != Cameras::none)
    state.counters["frames_per_s"] =
        Counter(static_cast<double>(live.simulation.frames() - made), Counter::kIsRate);
}

void lockstep(benchmark::State& state) {
  run_live(state, Cameras::none);
}
void lockstep_grpc(benchmark::State& state) {
  run_live(state, Cameras::none, Way::grpc);
}
void lockstep_frames(benchmark::State& state) {
  run_live(state, Cameras::ers210);
}
void lockstep_all_effects(benchmark::State& state) {
  run_live(state, Cameras::all_effects);
}

// Robots, milliseconds between decisions.
BENCHMARK(lockstep)
    ->ArgsProduct({{2, 4, 8, 16}, {32, 8}})
    ->Args({1, 8})
    ->UseRealTime()
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(lockstep_grpc)
    ->ArgsProduct({{1, 8}, {32, 8}})
    ->UseRealTime()
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(lockstep_all_effects)->Args({8, 32})->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(lockstep_frames)
    ->ArgsProduct({{2, 4, 8, 16}, {32}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

// The same loop without clients: what the simulation itself takes.
void loop_alone(benchmark::State& state) {
  app::Simulator simulator = app::make_simulator(Scenario::from_text(
      scenario_yaml(state.range(0), state.range(1), Cameras::none), "bench.yaml"));
  scheduler::RunControl control;
  scheduler::FunctionSource source([](const scheduler::Observation& seen) {
    scheduler::Decision decision;
    decision.command.joints = {{{}, {{kPan, seen.sequence % 20 < 10 ? 0.7 : -0.7, 5.0}}}};
    return decision;
  });
  scheduler::Simulation simulation(
      {simulator.scenario, simulator.world, source, control, nullptr, {}, simulator.header});
  SimTime until;
  const auto wall_start = std::chrono::steady_clock::now();
  for (auto _ : state) {
    until = until + SimDuration::from_ns(state.range(1) * 1'000'000);
    simulation.run_to(until);
  }
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - wall_start;
  state.counters["real_time_factor"] = until.s() / wall.count();
}
BENCHMARK(loop_alone)->Args({8, 32})->Args({8, 8})->UseRealTime()->Unit(benchmark::kMicrosecond);

// The baseline: one empty unary call and its answer, server in a process of its own.
void unary_round_trip(benchmark::State& state) {
  const std::string address = fmt::format(
      "unix:{}/seam-bench-unary-{}", std::filesystem::temp_directory_path().string(), getpid());
  const pid_t child = fork();
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    execl("/proc/self/exe", "bench_lockstep", "--unary-server", address.c_str(), nullptr);
    _exit(127);
  }
  const auto stub =
      v1::Supervisor::NewStub(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
  v1::SupervisorRequest request;
  v1::Status reply;
  {
    grpc::ClientContext context;
    context.set_wait_for_ready(true);
    stub->GetStatus(&context, request, &reply);
  }
  for (auto _ : state) {
    grpc::ClientContext context;
    stub->GetStatus(&context, request, &reply);
  }
  kill(child, SIGTERM);
  waitpid(child, nullptr, 0);
}
BENCHMARK(unary_round_trip)->UseRealTime()->Unit(benchmark::kMicrosecond);

class EmptySupervisor final : public v1::Supervisor::CallbackService {
  grpc::ServerUnaryReactor* GetStatus(grpc::CallbackServerContext* context,
                                      const v1::SupervisorRequest*, v1::Status*) override {
    auto* reactor = context->DefaultReactor();
    reactor->Finish(grpc::Status::OK);
    return reactor;
  }
};

int serve_unary(const std::string& address) {
  EmptySupervisor service;
  grpc::ServerBuilder builder;
  builder.AddListeningPort(address, grpc::InsecureServerCredentials());
  builder.RegisterService(&service);
  const auto server = builder.BuildAndStart();
  if (!server) return 1;
  server->Wait();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3 && std::string_view(argv[1]) == "--unary-server") return serve_unary(argv[2]);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
