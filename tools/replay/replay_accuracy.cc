// `seam replay accuracy F`: the clients' own estimates against the truth.
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/logs/estimate_errors.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "tools/command.h"
#include "tools/replay/replay.h"

namespace seam::tools {
namespace {

using Kind = app::EstimateError::Kind;

constexpr std::array kKinds = {Kind::position_m, Kind::heading_rad, Kind::ball_distance_m,
                               Kind::ball_bearing_rad};
constexpr double kBands_m[] = {0, 0.3, 0.6, 1.0, 1.5, 2.0, 3.0, 6.0};

struct AccuracySettings {
  std::string file;
  std::string json;
  double from_s = 0;
};

template <class Chosen>
app::ErrorSummary summary_of(const std::vector<app::EstimateError>& errors, Chosen chosen) {
  std::vector<double> values;
  for (const app::EstimateError& error : errors)
    if (chosen(error)) values.push_back(error.error);
  return app::summarise(std::move(values));
}

nlohmann::ordered_json to_json(const app::ErrorSummary& summary) {
  return {{"n", summary.count},         {"mean", summary.mean},
          {"rms", summary.rms},         {"median_abs", summary.median_abs},
          {"p90_abs", summary.p90_abs}, {"max_abs", summary.max_abs}};
}

void print_header(const char* title, const char* rows) {
  std::printf("\n%s\n%-10s %6s %8s %8s %8s %8s %8s\n", title, rows, "n", "median", "90 %",
              "largest", "rms", "mean");
}

void print_row(const std::string& name, const app::ErrorSummary& s, double unit) {
  if (s.count == 0) return;
  std::printf("%-10s %6zu %8.3f %8.3f %8.3f %8.3f %+8.3f\n", name.c_str(), s.count,
              s.median_abs / unit, s.p90_abs / unit, s.max_abs / unit, s.rms / unit, s.mean / unit);
}

void print_kind(const std::vector<app::EstimateError>& errors,
                const std::vector<std::string>& robots, Kind kind) {
  constexpr const char* kTitles[] = {"own position, m", "own heading, deg",
                                     "distance of the ball, m", "bearing of the ball, deg"};
  const auto of_kind = [kind](const app::EstimateError& error) { return error.kind == kind; };
  const app::ErrorSummary all = summary_of(errors, of_kind);
  if (all.count == 0) return;
  const double unit = kind == Kind::heading_rad || kind == Kind::ball_bearing_rad ? M_PI / 180 : 1;
  print_header(kTitles[static_cast<size_t>(kind)], "robot");
  for (size_t i = 0; i < robots.size(); ++i)
    print_row(robots[i],
              summary_of(errors,
                         [&](const app::EstimateError& error) {
                           return of_kind(error) && error.robot == static_cast<int>(i);
                         }),
              unit);
  print_row("all", all, unit);
}

bool in_band(const app::EstimateError& error, size_t band) {
  return error.kind == Kind::ball_distance_m && error.truth_m >= kBands_m[band] &&
         error.truth_m < kBands_m[band + 1];
}

void tell_accuracy(const AccuracySettings& settings) {
  OutputFile out(settings.json, {.inputs = {settings.file}});
  const scheduler::Log log = scheduler::Log::open(settings.file);
  const std::vector<std::string>& robots = log.header().robots;
  const std::vector<app::EstimateError> errors =
      app::estimate_errors(log, SimTime::from_s(settings.from_s));
  nlohmann::ordered_json json = {
      {"format", "seam-accuracy/1"}, {"from_s", settings.from_s}, {"end_s", log.end_time().s()}};
  for (const Kind kind : kKinds) {
    const char* name = app::kEstimateNames[static_cast<size_t>(kind)];
    json["all"][name] = to_json(
        summary_of(errors, [&](const app::EstimateError& error) { return error.kind == kind; }));
    for (size_t i = 0; i < robots.size(); ++i)
      json["robots"][robots[i]][name] =
          to_json(summary_of(errors, [&](const app::EstimateError& error) {
            return error.kind == kind && error.robot == static_cast<int>(i);
          }));
  }
  json["ball_distance_by_truth"] = nlohmann::ordered_json::array();
  for (size_t band = 0; band + 1 < std::size(kBands_m); ++band) {
    nlohmann::ordered_json entry = {{"from_m", kBands_m[band]}, {"to_m", kBands_m[band + 1]}};
    entry.update(to_json(
        summary_of(errors, [&](const app::EstimateError& error) { return in_band(error, band); })));
    json["ball_distance_by_truth"].push_back(std::move(entry));
  }
  out.fill(json.dump(2) + "\n");
  if (errors.empty()) {
    std::printf("%s: no client logged an estimate\n", settings.file.c_str());
    return;
  }
  std::printf(
      "%s: estimate minus truth, from %g s to %g s; median, 90 %% and largest without sign\n",
      settings.file.c_str(), settings.from_s, log.end_time().s());
  for (const Kind kind : kKinds) print_kind(errors, robots, kind);
  print_header("distance of the ball by its true distance, m", "metres");
  for (size_t band = 0; band + 1 < std::size(kBands_m); ++band)
    print_row(
        fmt::format("{} to {}", kBands_m[band], kBands_m[band + 1]),
        summary_of(errors, [&](const app::EstimateError& error) { return in_band(error, band); }),
        1);
}

}  // namespace

void add_replay_accuracy(app::Command replay) {
  app::Command command = replay.add_subcommand(
      "accuracy",
      "The clients' own estimates of their pose and of the ball, which they log as values,\n"
      "against the truth");
  auto settings = std::make_shared<AccuracySettings>();
  command.add_option("F", settings->file, "The log").required();
  command
      .add_option("--from", settings->from_s, "Leaves out what comes before this simulated second")
      .range(0.0, 9e9);
  command.add_option("--json", settings->json, "Write the result as seam-accuracy/1 to this file");
  command.footer(
      "Values that count: x_m, y_m, theta_rad (on the field), ball_distance_m, ball_bearing_rad "
      "(from\n"
      "the body). Example: seam replay accuracy match.mcap --from 5");
  command.callback([settings] { tell_accuracy(*settings); });
}

}  // namespace seam::tools
