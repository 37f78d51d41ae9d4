// What `seam diagnose` costs over the whole catalogue: 8,000 points, and 168 flat fields of 178 x
// 144, each with two effects hidden, so that several looks at the catalogue are needed; and the
// studies' protocol of each kind with an effect of the mean hidden beside a noise. Reading the set
// is part of it. The baseline, in the same run: to read the set and to score it once by the model
// given, which no diagnosis can do without (`readings`: as many of it are one diagnosis).
//
// `bench_diagnose FOLDER...` has the sets of any size that `scripts/growth.py --keep` made beside
// them: a folder has the set in data/ and its model in given.yaml.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>

#include "app/predictors/instruments.h"
#include "measurement/kinds/kinds.h"
#include "measurement/search/search.h"
#include "measurement/study/study.h"
#include "sim_core/base/output.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;

Model model_of(const std::string& effects) {
  return Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\nname: nominal\neffects: {" + effects + "}\n", "nominal"));
}

// 24 frames at each of seven levels of light.
void write_flat_fields(const fs::path& folder, const std::string& channels) {
  std::string table = "frame,file,time_s,exposure_s,illumination\n";
  int frame = 0;
  for (const double light : {0.0, 0.02, 0.06, 0.15, 0.3, 0.5, 0.75}) {
    for (int k = 0; k < 24; ++k, ++frame)
      table +=
          fmt::format("{},frames/{:04}.png,{:.6f},0.005,{}\n", frame, frame, 0.04 * frame, light);
  }
  write_file_atomically(folder / "frames.csv", table);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: photometry\ntitle: Flat fields\n"
                        "camera: {width_px: 178, height_px: 144, frame_period_s: 0.04, channels: " +
                            channels + ", bits: 8}\ngroup: frame\nfiles: {frames: frames.csv}\n");
}

// A head that nods and swings before 80 points, 100 frames.
void write_points(const fs::path& folder) {
  std::string joints = "time_s,tilt_rad,pan_rad\n", table = "frame,time_s,point,x_m,y_m,z_m\n";
  for (int i = 0; i <= 1100; ++i) {
    const double t = 0.008 * i;
    joints += fmt::format("{:.6f},{:.7f},{:.7f}\n", t, 0.25 * std::sin(3.3 * t + 0.4),
                          0.8 * std::sin(5.1 * t) + 0.1 * std::sin(17 * t));
  }
  for (int frame = 0; frame < 100; ++frame) {
    for (int point = 0; point < 290; ++point) {
      const double bearing = 2.6 * std::fmod(0.618034 * point, 1.0) - 1.3,
                   range = 0.7 + 2.3 * std::fmod(0.754878 * point, 1.0);
      table += fmt::format("{},{:.6f},{},{:.5f},{:.5f},{:.5f}\n", frame, 0.15 + 0.08 * frame, point,
                           range * std::cos(bearing), range * std::sin(bearing),
                           0.25 + range * (1.1 * std::fmod(0.569840 * point, 1.0) - 0.55));
    }
  }
  write_file_atomically(folder / "joints.csv", joints);
  write_file_atomically(folder / "points.csv", table);
  write_file_atomically(
      folder / "measurement.yaml",
      "format: seam-measurement/1\nkind: points\ntitle: Points\n"
      "camera: {width_px: 178, height_px: 144, frame_period_s: 0.08}\nnoise: {u_px: 0.15, v_px: "
      "0.15}\n"
      "group: frame\nfiles: {points: points.csv, joints: joints.csv}\n" +
          head_rig("[0, -1, 0]"));
}

double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void search_timed(benchmark::State& state, const fs::path& set, const Model& model) {
  const auto open = [&] { return open_problem(set, app::instruments()); };
  double one = std::numeric_limits<double>::infinity(), all = 0;
  for (int i = 0; i < 3; ++i) {
    one = std::min(one, seconds_of([&] {
                     const auto problem = open();
                     problem->prepare(model);
                     benchmark::DoNotOptimize(problem->score(model, problem->all_groups()));
                   }));
  }
  for (auto _ : state) {
    all = seconds_of([&] {
      const auto problem = open();
      const SearchResult result = search(*problem, model, {}, [](const std::string&) {});
      state.counters["steps"] = static_cast<double>(result.steps.size());
      state.counters["error"] = result.best.assessment.error;
      state.counters["residuals"] = static_cast<double>(problem->facts().scalars());
    });
  }
  state.counters["readings"] = all / one;
}

void diagnose(benchmark::State& state, void (*write)(const fs::path&), const std::string& nominal,
              const std::string& hidden) {
  const fs::path folder = fs::path(SEAM_BINARY_DIR) / "bench_diagnose";
  fs::remove_all(folder);
  fs::create_directories(folder / "protocol");
  write(folder / "protocol");
  const MeasurementSet protocol = MeasurementSet::open(folder / "protocol");
  measure_set(model_of(nominal + ", " + hidden), protocol, {.seed = 1, .out = folder / "set"});
  search_timed(state, folder / "set", model_of(nominal));
  fs::remove_all(folder);
}

// A kind by its name, as studies have it.
void kind(benchmark::State& state, const std::string& name, const std::string& hidden) {
  const fs::path folder = fs::path(SEAM_BINARY_DIR) / "bench_diagnose";
  fs::remove_all(folder);
  const Model nominal = write_study_protocol(name, folder / "protocol");
  Model truth = nominal;
  const Model hidden_model = model_of(hidden);
  for (const effects::ModelEffect& effect : hidden_model.effects())
    truth.set(effect.definition, effect.parameters);
  measure_set(truth, MeasurementSet::open(folder / "protocol"), {.seed = 1, .out = folder / "set"},
              app::instruments());
  search_timed(state, folder / "set", nominal);
  fs::remove_all(folder);
}

void every_kind() {
  const std::pair<const char*, const char*> kinds[] = {
      {"points",
       "rolling_shutter: {line_delay_s: 0.0002}, point_scatter: {fraction: 0.05, "
       "sigma_px: 0.8}"},
      {"board", "tangential_distortion: {p1: 0.001, p2: 0.001}"},
      {"joints", "servo_lag: {tau_s: 0.03}, joint_wander: {sigma_rad: 0.0012, tau_s: 0.1}"},
      {"odometry", "walk_lag: {tau_s: 0.1}, walk_noise: {xy_sigma: 0.01, theta_sigma: 0.02}"},
      {"landmarks", "range_scale: {scale: 0.04}, heading_wander: {sigma_rad: 0.02, tau_s: 2}"},
      {"photometry", "vignetting: {a2: 0.2, a4: 0.05}, row_noise: {sigma_dn: 0.5}"},
      {"frames", "frame_latency: {latency_s: 0.01}"}};
  for (const auto& [name, hidden] : kinds) {
    benchmark::RegisterBenchmark((std::string("kind/") + name).c_str(),
                                 [name = std::string(name), hidden = std::string(hidden)](
                                     benchmark::State& state) { kind(state, name, hidden); })
        ->Unit(benchmark::kSecond)
        ->Iterations(1)
        ->UseRealTime();
  }
}

void flat_fields(benchmark::State& state) {
  diagnose(
      state, [](const fs::path& folder) { write_flat_fields(folder, "grey"); },
      "linear_response: {gain_dn: 220, black_dn: 8}, read_noise: {sigma_dn: 1.4}",
      "vignetting: {a2: 0.2, a4: 0.05}, shot_noise: {electrons_per_dn: 40}");
}
BENCHMARK(flat_fields)->Unit(benchmark::kSecond)->Iterations(1)->UseRealTime();

void flat_fields_in_colour(benchmark::State& state) {
  diagnose(
      state, [](const fs::path& folder) { write_flat_fields(folder, "rgb"); },
      "linear_response: {gain_dn: 220, black_dn: 8}, read_noise: {sigma_dn: 1.4}",
      "vignetting: {a2: 0.2, a4: 0.05}, shot_noise: {electrons_per_dn: 40}");
}
BENCHMARK(flat_fields_in_colour)->Unit(benchmark::kSecond)->Iterations(1)->UseRealTime();

void points(benchmark::State& state) {
  diagnose(state, write_points, "pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}",
           "rolling_shutter: {line_delay_s: 0.0002}, radial_distortion: {kappa: -0.1}");
}
BENCHMARK(points)->Unit(benchmark::kSecond)->Iterations(1)->UseRealTime();

void given_sets(int count, char** folders) {
  for (int i = 1; i < count; ++i) {
    const fs::path folder = folders[i];
    benchmark::RegisterBenchmark(("set/" + folder.filename().string()).c_str(),
                                 [folder](benchmark::State& state) {
                                   search_timed(state, folder / "data",
                                                Model::from_file(folder / "given.yaml"));
                                 })
        ->Unit(benchmark::kSecond)
        ->Iterations(1)
        ->UseRealTime();
  }
}

}  // namespace
}  // namespace seam::measurement

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  seam::measurement::every_kind();
  seam::measurement::given_sets(argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
