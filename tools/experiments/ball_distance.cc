// Section 5.1 of the founding paper: a resting robot measures the distance to the ball 100 times at
// each distance, with the algorithm of the SDK's `ball_ranger`, the same in both cases.
#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/data_file.h"
#include "app/predictors/range_detector.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"
#include "tools/experiments/ball_pictures.h"
#include "tools/experiments/experiments.h"
#include "tools/experiments/plot.h"
#include "tools/experiments/runs.h"
#include "tools/experiments/statistics.h"

namespace seam::tools {
namespace {

constexpr int kMeasurements = 100;
constexpr double kSettled_s = 1.5;  // By then the head has come to rest.

struct Point {
  std::string camera;  // "ideal" or "real".
  double true_m = 0;
  std::vector<double> measured_m;
};

std::string run_name(const std::string& camera, int distance_mm, int seed) {
  return fmt::format("ball_{}_{}mm_s{}", camera, distance_mm, seed);
}

PlannedRun planned(const Scenario& base, const std::string& camera, const std::string& model_yaml,
                   int distance_mm, int seed) {
  PlannedRun run{run_name(camera, distance_mm, seed), base};
  RobotSpec& robot = run.scenario.robots.front();
  run.scenario.seed = seed;
  robot.camera.model_yaml = model_yaml;
  run.scenario.ball.x_m = robot.pose.x_m + 1e-3 * distance_mm;
  run.scenario.ball.y_m = robot.pose.y_m;
  robot.behaviour.command = {"ball_ranger", "--tilt",
                             fmt::format("{:.4f}", app::tilt_to_ball_rad(1e-3 * distance_mm))};
  return run;
}

// 95 % interval of a standard deviation of n normal values: about +- 1.96 s / sqrt(2 (n - 1)).
double deviation_half_width(const Point& point) {
  const double n = static_cast<double>(point.measured_m.size());
  return n > 1 ? 1.96 * deviation_of(point.measured_m) / std::sqrt(2 * (n - 1)) : 0;
}

std::string table_row(const Point& point) {
  const double deviation = deviation_of(point.measured_m);
  const Interval mean = interval_of(point.measured_m);
  return fmt::format("{},{:.0f},{},{:.3f},{:.3f},{:.4f},{:.4f}\n", point.camera, 1e3 * point.true_m,
                     point.measured_m.size(), 1e3 * mean.mean, 1e3 * mean.half_width,
                     1e3 * deviation, 1e3 * deviation_half_width(point));
}

// The points of the ideal camera first, then those of the real one, both by distance.
std::string table_of(const std::vector<Point>& points) {
  std::string table =
      "| True, mm | Without: mean, mm | deviation, mm | With: mean, mm | deviation, mm "
      "|\n|---|---|---|---|---|\n";
  const auto cells = [](const Point& point) {
    const Interval mean = interval_of(point.measured_m);
    return fmt::format(" {:.1f} ± {:.1f} | {:.2f} ± {:.2f} |", 1e3 * mean.mean,
                       1e3 * mean.half_width, 1e3 * deviation_of(point.measured_m),
                       1e3 * deviation_half_width(point));
  };
  for (size_t i = 0; 2 * i < points.size(); ++i)
    table += fmt::format("| {:.0f} |", 1e3 * points[i].true_m) + cells(points[i]) +
             cells(points[i + points.size() / 2]) + "\n";
  return table;
}

void draw_pictures(const Scenario& base, const ExperimentOptions& options) {
  std::vector<std::vector<BallPicture>> pictures;
  for (const char* camera : {"ideal", "real"}) {
    pictures.emplace_back();
    for (const int distance_mm : {200, 800, 1400, 2000}) {
      pictures.back().push_back(
          {options.folder / "runs" / (run_name(camera, distance_mm, 1) + ".yaml"),
           base.robots.front().id,
           fmt::format("{} mm, {} camera effects", distance_mm,
                       std::string(camera) == "ideal" ? "without" : "with")});
    }
  }
  draw_ball_pictures(pictures, options.folder / "ball_pictures.png");
}

void draw(const std::filesystem::path& folder) {
  plot(folder, "ball_distance_mean",
       "set key left top\nset xlabel 'true distance [mm]'\nset ylabel 'mean of the measured "
       "distance [mm]'\n"
       "plot x with lines ls 4 title 'true', \\\n"
       "  '< grep ^ideal ball_distance.csv' using 2:4:5 with yerrorlines ls 1 title 'without "
       "camera effects', \\\n"
       "  '< grep ^real ball_distance.csv' using 2:4:5 with yerrorlines ls 2 title 'with camera "
       "effects'\n");
  plot(folder, "ball_distance_deviation",
       "set key left top\nset xlabel 'true distance [mm]'\nset ylabel 'standard deviation [mm]'\n"
       "plot '< grep ^ideal ball_distance.csv' using 2:6:7 with yerrorlines ls 1 title 'without "
       "camera effects', \\\n"
       "  '< grep ^real ball_distance.csv' using 2:6:7 with yerrorlines ls 2 title 'with camera "
       "effects'\n");
}

}  // namespace

void ball_distance_experiment(const ExperimentOptions& options, OutputFile& output) {
  const Scenario base = Scenario::from_file(app::data_file("scenarios/ball_distance.yaml"));
  const std::string ideal = read_file(app::data_file("models/ideal_camera.yaml"));
  const std::string& real = base.robots.front().camera.model_yaml;
  std::vector<int> distances_mm;
  for (int d = 200; d <= 2000; d += options.quick ? 600 : 100) distances_mm.push_back(d);

  std::vector<PlannedRun> runs;
  for (int d : distances_mm) {
    runs.push_back(planned(base, "ideal", ideal, d, 1));
    runs.push_back(planned(base, "real", real, d, 1));
  }
  make_runs(runs, options.folder / "runs", options.parallel);

  std::string csv = "camera,true_mm,n,mean_mm,mean_ci95_mm,deviation_mm,deviation_ci95_mm\n";
  std::vector<Point> points;
  nlohmann::json json = {{"format", "seam-ball-distance/1"}, {"points", nlohmann::json::array()}};
  std::printf("%-8s %8s %5s %12s %14s\n", "camera", "true/mm", "n", "mean/mm", "deviation/mm");
  for (const char* camera : {"ideal", "real"}) {
    for (int d : distances_mm) {
      Point point{camera, 1e-3 * d, {}};
      const LoggedValues values =
          logged_values(options.folder / "runs" / (run_name(camera, d, 1) + ".mcap"));
      if (const auto found = values.find("distance_m"); found != values.end()) {
        for (const LoggedValue& value : found->second) {
          if (point.measured_m.size() < kMeasurements && value.time.s() > kSettled_s)
            point.measured_m.push_back(value.value);
        }
      }
      csv += table_row(point);
      points.push_back(point);
      const double mean = mean_of(point.measured_m), deviation = deviation_of(point.measured_m);
      std::printf("%-8s %8d %5zu %12.1f %14.2f\n", camera, d, point.measured_m.size(), 1e3 * mean,
                  1e3 * deviation);
      json["points"].push_back({{"camera", camera},
                                {"true_mm", d},
                                {"n", point.measured_m.size()},
                                {"mean_mm", 1e3 * mean},
                                {"mean_ci95_mm", 1e3 * interval_of(point.measured_m).half_width},
                                {"deviation_mm", 1e3 * deviation}});
    }
  }
  write_file_atomically(options.folder / "ball_distance.csv", csv);
  write_file_atomically(options.folder / "ball_distance.md", table_of(points));
  draw(options.folder);
  draw_pictures(base, options);
  output.fill(json.dump(1) + "\n");
}

}  // namespace seam::tools
