// Section 5.2 of the founding paper: 36 poses, 30 s of head rotation each, Monte Carlo localisation
// as a client that sees images alone; the columns of Table 1.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/data_file.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/maths.h"
#include "sim_core/base/output.h"
#include "tools/experiments/experiments.h"
#include "tools/experiments/pose_runs.h"
#include "tools/experiments/statistics.h"

namespace seam::tools {
namespace {

// One column group of Table 1: errors, interval widths, and how often the truth lies inside.
struct Row {
  std::string quantity, unit;
  std::vector<double> errors, widths;
  int inside = 0, count = 0;
};

struct TableOfMode {
  Row x{"x", "mm", {}, {}}, y{"y", "mm", {}, {}}, theta{"theta", "deg", {}, {}};
  Row xy{"xy", "mm", {}, {}}, xytheta{"xytheta", "", {}, {}};

  void add(const PoseResult& result) {
    const double degrees = 180 / maths::kPi;
    const auto take = [](Row& row, double error, double width, bool inside) {
      row.errors.push_back(std::abs(error));
      if (width >= 0) row.widths.push_back(width);
      row.inside += inside ? 1 : 0;
      ++row.count;
    };
    const double dx = 1e3 * (result.mean.x_m - result.truth.x_m),
                 dy = 1e3 * (result.mean.y_m - result.truth.y_m);
    const double dtheta =
        degrees * maths::wrap_angle(result.mean.theta_rad - result.truth.theta_rad);
    const bool in_x = result.truth.x_m >= result.low.x_m && result.truth.x_m <= result.high.x_m;
    const bool in_y = result.truth.y_m >= result.low.y_m && result.truth.y_m <= result.high.y_m;
    const double above_low = maths::wrap_angle(result.truth.theta_rad - result.low.theta_rad);
    const double below_high = maths::wrap_angle(result.high.theta_rad - result.truth.theta_rad);
    const bool in_theta = above_low >= 0 && below_high >= 0;
    take(x, dx, 1e3 * (result.high.x_m - result.low.x_m), in_x);
    take(y, dy, 1e3 * (result.high.y_m - result.low.y_m), in_y);
    take(theta, dtheta, degrees * (result.high.theta_rad - result.low.theta_rad), in_theta);
    take(xy, std::sqrt(dx * dx + dy * dy), -1, in_x && in_y);
    take(xytheta, 0, -1, in_x && in_y && in_theta);
  }

  std::vector<const Row*> rows() const { return {&x, &y, &theta, &xy, &xytheta}; }
};

// Table 1(a) of the paper, the real robot. Its "mean squared error" is the root.
struct PaperRow {
  const char* quantity;
  double error, largest, width, inside_percent;  // Negative: not given.
};
constexpr PaperRow kRealRobot[] = {{"x", 186, 393, 580, 61},
                                   {"y", 141, 375, 395, 58},
                                   {"theta", 6.5, 16, 19, 67},
                                   {"xy", 233, 393, -1, 47},
                                   {"xytheta", -1, -1, -1, 47}};

constexpr char kHeader[] =
    "| | Error (root mean square) | Largest | Mean width | Truth inside |\n|---|---|---|---|---|\n";

std::string cell(double value, const char* format = "{:.0f}") {
  return value < 0 ? "/" : fmt::format(fmt::runtime(format), value);
}

std::string markdown(const std::string& title, const TableOfMode& table) {
  std::string out = fmt::format("**{}**\n\n", title) + kHeader;
  for (const Row* row : table.rows()) {
    const bool has_error = row->quantity != "xytheta";
    const char* format = row->unit == "deg" ? "{:.1f} deg" : "{:.0f} mm";
    out += fmt::format("| {} | {} | {} | {} | {:.0f} % |\n", row->quantity,
                       has_error ? cell(root_mean_square(row->errors), format) : "/",
                       has_error ? cell(largest(row->errors), format) : "/",
                       row->widths.empty() ? "/" : cell(mean_of(row->widths), format),
                       100.0 * row->inside / row->count);
  }
  return out + "\n";
}

std::string markdown_of_paper() {
  std::string out = std::string("**Real robot, the paper's Table 1(a)**\n\n") + kHeader;
  for (const PaperRow& row : kRealRobot) {
    const char* format = std::string(row.quantity) == "theta" ? "{:.1f} deg" : "{:.0f} mm";
    out += fmt::format("| {} | {} | {} | {} | {:.0f} % |\n", row.quantity, cell(row.error, format),
                       cell(row.largest, format), cell(row.width, format), row.inside_percent);
  }
  return out + "\n";
}

nlohmann::json json_of(const TableOfMode& table) {
  nlohmann::json json;
  for (const Row* row : table.rows()) {
    nlohmann::json cells = {{"truth_inside", static_cast<double>(row->inside) / row->count}};
    if (row->quantity != "xytheta")
      cells["error"] = root_mean_square(row->errors), cells["largest"] = largest(row->errors);
    if (!row->widths.empty()) cells["mean_width"] = mean_of(row->widths);
    cells["unit"] = row->unit;
    json[row->quantity] = cells;
  }
  return json;
}

}  // namespace

void localization_experiment(const ExperimentOptions& options, OutputFile& output) {
  struct Mode {
    const char* name;
    const char* title;
    PoseMode mode;
  };
  const std::string ideal = read_file(app::data_file("models/ideal_camera.yaml"));
  const double duration_s = options.quick ? 12 : options.duration_s;
  std::vector<Mode> modes = {
      {"ideal",
       "Without camera characteristics, frames locked to the swing",
       {.model_yaml = ideal, .locked = true}},
      {"locked", "With camera characteristics, frames locked to the swing", {.locked = true}},
      {"scheduled",
       "With camera characteristics, rows at event times on the camera's own clock",
       {.locked = false}}};
  for (Mode& mode : modes) mode.mode.duration_s = duration_s;
  const std::vector<Pose2> poses = paper_poses(options.quick       ? 4
                                               : options.poses > 0 ? options.poses
                                                                   : 36);
  const int seeds = options.quick ? 1 : options.seeds;

  std::vector<PlannedRun> runs;
  for (const Mode& mode : modes) {
    for (int seed = 1; seed <= seeds; ++seed) {
      for (const Pose2& pose : poses) runs.push_back(pose_run(mode.name, mode.mode, pose, seed));
    }
  }
  make_runs(runs, options.folder / "runs", options.parallel);

  std::string page = markdown_of_paper();
  nlohmann::json json = {
      {"format", "seam-localization/1"}, {"seeds", seeds}, {"poses", poses.size()}};
  std::string csv = "mode,seed,x_m,y_m,theta_rad,estimate_x_m,estimate_y_m,estimate_theta_rad\n";
  for (const Mode& mode : modes) {
    TableOfMode table;
    for (int seed = 1; seed <= seeds; ++seed) {
      for (const Pose2& pose : poses) {
        const PoseResult result = read_pose_run(options.folder / "runs", mode.name, pose, seed);
        table.add(result);
        csv += fmt::format("{},{},{},{},{:.6f},{:.5f},{:.5f},{:.5f}\n", mode.name, seed, pose.x_m,
                           pose.y_m, pose.theta_rad, result.mean.x_m, result.mean.y_m,
                           result.mean.theta_rad);
      }
    }
    page += markdown(mode.title, table);
    json["modes"][mode.name] = json_of(table);
  }
  std::fputs(page.c_str(), stdout);
  write_file_atomically(options.folder / "localization.md", page);
  write_file_atomically(options.folder / "localization.csv", csv);
  output.fill(json.dump(1) + "\n");
}

}  // namespace seam::tools
