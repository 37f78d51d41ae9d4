// What locking the camera's frames to the head's swing does to localisation, and what the rolling
// shutter adds in each direction of swing: theory beside measurement.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "sim_core/base/output.h"
#include "tools/experiments/experiments.h"
#include "tools/experiments/head_swing/swing_explained.h"
#include "tools/experiments/head_swing/swing_studies.h"
#include "tools/experiments/statistics.h"

namespace seam::tools {
namespace {

nlohmann::json bounds(const Interval& interval) {
  return {interval.mean - interval.half_width, interval.mean + interval.half_width};
}

double length(double x, double y) {
  return std::sqrt(x * x + y * y);
}

// What the errors of the sightings explain of the bias that is there without any lock.
nlohmann::json explain(const SwingRuns& runs, const StudySize& size,
                       const std::filesystem::path& folder) {
  std::vector<double> found, from_all, from_bearings, from_ranges, rest;
  for (int seed = 1; seed <= size.seeds; ++seed) {
    for (const Pose2& pose : size.poses) {
      const SwingRun run = runs.read(camera_rate(size, false), pose, seed);
      const auto part = [&](bool bearings, bool ranges) {
        return explained_offset(run.sightings, pose, bearings, ranges);
      };
      const PositionOffset all = part(true, true), bearings = part(true, false),
                           ranges = part(false, true);
      found.push_back(run.bias_mm);
      from_all.push_back(length(all.dx_mm, all.dy_mm));
      from_bearings.push_back(length(bearings.dx_mm, bearings.dy_mm));
      from_ranges.push_back(length(ranges.dx_mm, ranges.dy_mm));
      rest.push_back(length(run.dx_mm - all.dx_mm, run.dy_mm - all.dy_mm));
    }
  }
  const std::string table = fmt::format(
      "| Position bias on the camera's own clock, mm | |\n|---|---|\n| found | {:.1f} |\n"
      "| explained by the errors of ranges and bearings | {:.1f} |\n| by those of ranges alone | "
      "{:.1f} |\n"
      "| by those of bearings alone | {:.1f} |\n| not explained: length of found minus explained | "
      "{:.1f} |\n",
      mean_of(found), mean_of(from_all), mean_of(from_ranges), mean_of(from_bearings),
      mean_of(rest));
  write_file_atomically(folder / "explained.md", table);
  return {{"found_mm", mean_of(found)},
          {"explained_mm", mean_of(from_all)},
          {"ranges_mm", mean_of(from_ranges)},
          {"bearings_mm", mean_of(from_bearings)},
          {"rest_mm", mean_of(rest)}};
}

// Frames locked to the swing against frames on the camera's own clock, both at 25 a second, paired
// by pose, seed and phase of the first frame.
nlohmann::json main_comparison(const SwingRuns& runs, const StudySize& size,
                               const std::filesystem::path& folder) {
  nlohmann::json json = {{"format", "seam-head-swing-bias/1"},
                         {"seeds", size.seeds},
                         {"poses", size.poses.size()},
                         {"duration_s", size.duration_s}};
  std::vector<double> bias_mm[2];
  std::string csv = "mode,seed,pose,dx_mm,dy_mm,bias_mm,spread_mm\n",
              table = "| | Bias, mm (95 %) | Spread, mm |\n|---|---|---|\n";
  for (const bool locked : {true, false}) {
    const char* name = locked ? "locked" : "scheduled";
    std::vector<double> spread_mm;
    auto& of_mode = bias_mm[locked ? 0 : 1];
    size_t i = 0;
    for (const SwingRun& run : runs.read_all(camera_rate(size, locked), size.poses, size.seeds)) {
      of_mode.push_back(run.bias_mm);
      spread_mm.push_back(run.spread_mm);
      csv += fmt::format("{},{},{},{:.3f},{:.3f},{:.3f},{:.3f}\n", name, 1 + i / size.poses.size(),
                         i % size.poses.size(), run.dx_mm, run.dy_mm, run.bias_mm, run.spread_mm);
      ++i;
    }
    const Interval bias = seed_interval(of_mode, size.poses.size());
    json["modes"][name] = {
        {"bias_mm", bias.mean}, {"ci95", bounds(bias)}, {"spread_mm", mean_of(spread_mm)}};
    table += fmt::format("| {} | {:.2f} ± {:.2f} | {:.1f} |\n", name, bias.mean, bias.half_width,
                         mean_of(spread_mm));
  }
  const Interval paired = seed_interval(differences(bias_mm[0], bias_mm[1]), size.poses.size());
  json["paired"] = {{"difference_mm", paired.mean}, {"ci95", bounds(paired)}};
  table +=
      fmt::format("| paired difference | {:+.2f} ± {:.2f} | |\n", paired.mean, paired.half_width);
  table += fmt::format("\n{} frames a swing, {} seeds, {} poses, {:.0f} s each; {} runs.\n",
                       nearest_frames_per_swing(), size.seeds, size.poses.size(), size.duration_s,
                       2 * bias_mm[0].size());
  std::printf(
      "position bias: locked %.2f mm, scheduled %.2f mm; paired difference %.2f +- %.2f mm (95 "
      "%%), %d seeds\n",
      mean_of(bias_mm[0]), mean_of(bias_mm[1]), paired.mean, paired.half_width, size.seeds);
  write_file_atomically(folder / "runs.csv", csv);
  write_file_atomically(folder / "main.md", table);
  return json;
}

}  // namespace

SwingMode camera_rate(const StudySize& size, bool locked) {
  return {locked ? "locked" : "scheduled", {.locked = locked, .duration_s = size.duration_s}};
}

void head_swing_bias_experiment(const ExperimentOptions& options, OutputFile& output) {
  // Three swings are enough to see that everything works.
  const StudySize size{
      .poses = paper_poses(options.quick || options.poses == 0 ? 4 : options.poses),
      .seeds = options.quick ? 1 : options.seeds,
      .duration_s = options.quick ? 12.0 : options.duration_s,
      .quick = options.quick};
  // The rest needs no more seeds than show its curves: its effects are larger.
  StudySize rest = size;
  rest.poses = paper_poses(4);
  rest.seeds = std::min(size.seeds, 3);

  SwingRuns runs(options);
  for (const bool locked : {true, false})
    runs.plan(camera_rate(size, locked), size.poses, size.seeds);
  const std::pair<const char*, std::unique_ptr<SwingStudy>> studies[] = {
      {"ratio", ratio_study(rest)},
      {"phase", phase_and_drift_study(rest)},
      {"shutter", shutter_study(rest)},
      {"remainder", remainder_study(rest)}};
  for (const auto& [name, study] : studies) study->plan(runs);
  runs.make();

  nlohmann::json json = main_comparison(runs, size, options.folder);
  json["explained"] = explain(runs, size, options.folder);
  for (const auto& [name, study] : studies) json[name] = study->report(runs, options.folder);
  write_swing_protocol(options.folder / "measure");
  output.fill(json.dump(1) + "\n");
}

}  // namespace seam::tools
