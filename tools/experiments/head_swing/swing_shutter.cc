// What the rolling shutter adds in each direction of swing, for a program that takes the head's
// angle at the frame's stamp, and which head angles a locked camera sees.
#include <fmt/format.h>

#include <cmath>

#include "app/data_file.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"
#include "tools/experiments/head_swing/swing_studies.h"
#include "tools/experiments/plot.h"
#include "tools/experiments/statistics.h"

namespace seam::tools {
namespace {

constexpr int kFewFrames = 8;

struct Shutter {
  const char* name;
  const char* title;
  bool locked, rolling, row_times;
};
constexpr Shutter kShutters[] = {
    {"locked_stamp", "locked, rolling shutter, head angle at the stamp", true, true, false},
    {"scheduled_stamp", "own clock, rolling shutter, head angle at the stamp", false, true, false},
    {"locked_rows", "locked, rolling shutter, head angle at each row's time", true, true, true},
    {"scheduled_rows", "own clock, rolling shutter, head angle at each row's time", false, true,
     true},
    {"locked_instant", "locked, all rows at one instant", true, false, true},
    {"scheduled_instant", "own clock, all rows at one instant", false, false, true},
};

class ShutterStudy final : public SwingStudy {
 public:
  explicit ShutterStudy(const StudySize& size) : size_(size) {
    instantaneous_ = read_file(app::data_file("models/ers210_instantaneous.yaml"));
  }

  void plan(SwingRuns& runs) const override {
    for (const Shutter& shutter : kShutters) {
      if (!size_.quick || !shutter.row_times) runs.plan(mode(shutter), size_.poses, size_.seeds);
    }
    for (const bool locked : {true, false}) runs.plan(few(locked), {size_.poses.front()}, 1);
  }

  nlohmann::json report(const SwingRuns& runs, const std::filesystem::path& folder) const override {
    std::string table =
        "| 25 frames a swing | Position bias, mm (95 %) | Bearing error turning left, measured / "
        "theory, mrad | Turning right, "
        "measured / theory, mrad |\n|---|---|---|---|\n";
    std::string bins = "mode,rate_radps,measured_mrad,ci95_mrad,theory_mrad\n";
    nlohmann::json json = nlohmann::json::array();
    for (const Shutter& shutter : kShutters) {
      if (size_.quick && shutter.row_times) continue;
      Directions directions;
      std::vector<double> bias_mm;
      for (const SwingRun& run : runs.read_all(mode(shutter), size_.poses, size_.seeds)) {
        bias_mm.push_back(run.bias_mm);
        directions.add(run, !shutter.row_times);
      }
      const Interval bias = seed_interval(bias_mm, size_.poses.size());
      table += fmt::format("| {} | {:.1f} ± {:.1f} | {:+.1f} / {:+.1f} | {:+.1f} / {:+.1f} |\n",
                           shutter.title, bias.mean, bias.half_width, directions.left.measured(),
                           directions.left.theory(), directions.right.measured(),
                           directions.right.theory());
      bins += directions.bins(shutter.name);
      json.push_back({{"mode", shutter.name},
                      {"bias_mm", bias.mean},
                      {"ci95", {bias.mean - bias.half_width, bias.mean + bias.half_width}},
                      {"left_mrad", directions.left.measured()},
                      {"left_theory_mrad", directions.left.theory()},
                      {"right_mrad", directions.right.measured()},
                      {"right_theory_mrad", directions.right.theory()}});
    }
    write_file_atomically(folder / "shutter.md", table);
    write_file_atomically(folder / "shutter.csv", bins);
    write_angles(runs, folder);
    draw(folder);
    return json;
  }

 private:
  // Bearing errors, mrad, of many sightings beside what theory says of each of them.
  struct Errors {
    std::vector<double> seen, expected;
    double measured() const { return mean_of(seen); }
    double theory() const { return mean_of(expected); }
  };

  struct Directions {
    Errors left, right;
    std::map<long, Errors> by_rate;  // In steps of 0.25 rad/s.

    void add(const SwingRun& run, bool at_stamp) {
      for (const Sighting& s : run.sightings) {
        const double seen = 1e3 * s.bearing_error_rad;
        const double theory =
            at_stamp ? 1e3 * stamp_bearing_error_rad(s.pan_rate_radps, s.row_middle_s) : 0;
        for (Errors* errors :
             {s.pan_rate_radps > 0 ? &left : &right, &by_rate[std::lround(4 * s.pan_rate_radps)]}) {
          errors->seen.push_back(seen);
          errors->expected.push_back(theory);
        }
      }
    }

    std::string bins(const char* mode) const {
      std::string rows;
      for (const auto& [bin, errors] : by_rate) {
        if (errors.seen.size() < 5) continue;
        rows +=
            fmt::format("{},{:.2f},{:.4f},{:.4f},{:.4f}\n", mode, 0.25 * static_cast<double>(bin),
                        errors.measured(), interval_of(errors.seen).half_width, errors.theory());
      }
      return rows;
    }
  };

  SwingMode mode(const Shutter& shutter) const {
    if (shutter.rolling && shutter.row_times) {  // The same runs as the study of the ratio.
      return {fmt::format("ratio_{}_{}", shutter.locked ? "locked" : "scheduled", kFramesASwing),
              {.locked = shutter.locked,
               .frames_per_swing = kFramesASwing,
               .duration_s = size_.duration_s}};
    }
    return {fmt::format("shutter_{}", shutter.name),
            {.model_yaml = shutter.rolling ? "" : instantaneous_,
             .locked = shutter.locked,
             .frames_per_swing = kFramesASwing,
             .row_times = shutter.row_times,
             .duration_s = size_.duration_s}};
  }

  SwingMode few(bool locked) const {
    return {fmt::format("angles_{}", locked ? "locked" : "scheduled"),
            {.model_yaml = instantaneous_,
             .locked = locked,
             .frames_per_swing = kFewFrames,
             .phase = 0.3,
             .duration_s = size_.duration_s}};
  }

  void write_angles(const SwingRuns& runs, const std::filesystem::path& folder) const {
    std::string seen = "mode,time_s,pan_deg\n", theory = "pan_deg\n";
    constexpr double kDegrees = 57.29577951308232;
    for (const bool locked : {true, false}) {
      for (const Sighting& s : runs.read(few(locked), size_.poses.front(), 1).sightings)
        seen += fmt::format("{},{:.3f},{:.3f}\n", locked ? "locked" : "scheduled", s.time_s,
                            kDegrees * s.pan_rad);
    }
    for (const double angle : locked_angles(kSwing, kFewFrames, 0.3))
      theory += fmt::format("{:.3f}\n", kDegrees * angle);
    write_file_atomically(folder / "angles.csv", seen);
    write_file_atomically(folder / "angles_theory.csv", theory);
  }

  static void draw(const std::filesystem::path& folder) {
    plot(folder, "head_swing_shutter",
         "set key top right\nset xlabel 'rate of pan [rad/s], positive: the head turns left'\n"
         "set ylabel 'mean bearing error of beacons [mrad]'\n"
         "plot '< grep ^scheduled_stamp shutter.csv' using 2:3:4 with yerrorbars ls 2 title 'angle "
         "at the stamp, measured', \\\n"
         "  '< grep ^scheduled_stamp shutter.csv' using 2:5 with lines ls 2 title 'angle at the "
         "stamp, theory', \\\n"
         "  '< grep ^scheduled_rows shutter.csv' using 2:3:4 with yerrorbars ls 1 title 'angle at "
         "each row''s time', \\\n"
         "  '< grep ^scheduled_instant shutter.csv' using 2:3:4 with yerrorbars ls 3 title 'all "
         "rows at one instant'\n");
    plot(
        folder, "head_swing_angles",
        "set key outside top center horizontal\nset xlabel 'time [s]'\nset ylabel 'pan of the head "
        "where a beacon was seen [deg]'\n"
        "set yrange [-90:90]\nset ytics 30\nset xrange [0:16]\n"
        "plot for [i=1:8] '< sed -n '.(i+1).'p angles_theory.csv' using (0):1:(16):(0) with "
        "vectors nohead ls 4 "
        "title i==1 ? 'theory: the 8 angles of the lock' : '', \\\n"
        "  '< grep ^scheduled angles.csv' using 2:3 with points ls 3 ps 0.8 title 'own clock', \\\n"
        "  '< grep ^locked angles.csv' using 2:3 with points ls 2 ps 0.8 title 'locked, 8 frames a "
        "swing'\n");
  }

  StudySize size_;
  std::string instantaneous_;
};

}  // namespace

std::unique_ptr<SwingStudy> shutter_study(const StudySize& size) {
  return std::make_unique<ShutterStudy>(size);
}

}  // namespace seam::tools
