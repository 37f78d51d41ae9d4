// The bias as a function of the ratio of frame period to swing period. Theory: a camera with n
// frames locked to a swing gathers few views of a landmark. An error that belongs to a view (where
// the beacon's edges fall between pixels) returns in each swing and averages over the views alone;
// on a clock of its own the camera finds new views in each swing. The theory has no fitted number:
// its parts are measured at 25 frames/s without a lock, and from repeated views.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "sim_core/base/maths.h"
#include "sim_core/base/output.h"
#include "tools/experiments/head_swing/swing_studies.h"
#include "tools/experiments/plot.h"
#include "tools/experiments/statistics.h"

namespace seam::tools {
namespace {

// Bearing errors apart by landmark; each run adds its own groups.
using Groups = std::vector<std::vector<double>>;

void add_by_landmark(const SwingRun& run, Groups& groups) {
  std::vector<double> of[kBeacons];
  for (const Sighting& s : run.sightings) of[s.landmark].push_back(s.bearing_error_rad);
  for (auto& errors : of) {
    if (!errors.empty()) groups.push_back(std::move(errors));
  }
}

// Sightings of one landmark from the same view in each swing of a locked run.
void add_by_view(const SwingRun& run, Groups& groups) {
  constexpr double kSame_rad = 0.02;
  std::map<std::tuple<int, bool, long>, std::vector<double>> views;
  for (const Sighting& s : run.sightings)
    views[{s.landmark, s.pan_rate_radps > 0, std::lround(s.pan_rad / kSame_rad)}].push_back(
        s.bearing_error_rad);
  for (auto& [view, errors] : views) groups.push_back(std::move(errors));
}

double within_variance(const Groups& groups) {
  double sum = 0, freedom = 0;
  for (const auto& errors : groups) {
    const double mean = mean_of(errors);
    for (const double error : errors) sum += (error - mean) * (error - mean);
    freedom += static_cast<double>(errors.size()) - 1;
  }
  return freedom > 0 ? sum / freedom : 0;
}

double root_mean_square_of_means(const Groups& groups) {
  std::vector<double> means;
  for (const auto& errors : groups) means.push_back(mean_of(errors));
  return root_mean_square(means);
}

class RatioStudy final : public SwingStudy {
 public:
  explicit RatioStudy(const StudySize& size) : size_(size) {
    frames_ = size.quick ? std::vector<int>{6} : std::vector<int>{4, 6, 8, 12, 25, 36, 50};
  }

  void plan(SwingRuns& runs) const override {
    for (const int n : frames_) {
      for (const bool locked : {true, false}) runs.plan(mode(n, locked), size_.poses, size_.seeds);
    }
    for (const bool locked : {true, false})
      runs.plan(camera_rate(size_, locked), size_.poses, size_.seeds);
  }

  nlohmann::json report(const SwingRuns& runs, const std::filesystem::path& folder) const override {
    std::map<int, Side> locked, scheduled;
    for (const int n : with_camera_rate()) {
      locked[n] = side(runs, n, true);
      scheduled[n] = side(runs, n, false);
    }
    const ErrorParts parts = error_parts(locked, scheduled);
    std::string csv =
        "frames_per_swing,locked_mm,locked_ci95_mm,scheduled_mm,scheduled_ci95_mm,difference_mm,"
        "difference_ci95_mm,"
        "locked_bearing_mrad,scheduled_bearing_mrad,theory_bearing_mrad,views\n";
    std::string table =
        "| Frames a swing | Locked, mm | Scheduled, mm | Paired difference, mm (95 %) | Bearing "
        "bias locked / theory / scheduled,"
        " mrad |\n|---|---|---|---|---|\n";
    nlohmann::json json = {{"parts_mrad",
                            {{"common", 1e3 * parts.common},
                             {"view", 1e3 * parts.view},
                             {"frame", 1e3 * parts.frame}}},
                           {"points", nlohmann::json::array()}};
    for (const int n : with_camera_rate()) {
      const Interval a = seed_interval(locked[n].bias_mm, size_.poses.size());
      const Interval b = seed_interval(scheduled[n].bias_mm, size_.poses.size());
      const Interval d =
          seed_interval(differences(locked[n].bias_mm, scheduled[n].bias_mm), size_.poses.size());
      const double of_locked = 1e3 * root_mean_square_of_means(locked[n].by_landmark);
      const double of_scheduled = 1e3 * root_mean_square_of_means(scheduled[n].by_landmark);
      const double views = mean_views(n), theory = 1e3 * theory_rad(n, parts);
      csv +=
          fmt::format("{},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.4f},{:.4f},{:.4f},{:.2f}\n",
                      n, a.mean, a.half_width, b.mean, b.half_width, d.mean, d.half_width,
                      of_locked, of_scheduled, theory, views);
      table +=
          fmt::format("| {} | {:.1f} | {:.1f} | {:+.1f} ± {:.1f} | {:.2f} / {:.2f} / {:.2f} |\n", n,
                      a.mean, b.mean, d.mean, d.half_width, of_locked, theory, of_scheduled);
      json["points"].push_back({{"frames_per_swing", n},
                                {"locked_mm", a.mean},
                                {"scheduled_mm", b.mean},
                                {"difference_mm", d.mean},
                                {"difference_ci95", {d.mean - d.half_width, d.mean + d.half_width}},
                                {"bearing_locked_mrad", of_locked},
                                {"bearing_scheduled_mrad", of_scheduled},
                                {"bearing_theory_mrad", theory},
                                {"views", views}});
    }
    write_file_atomically(folder / "ratio.csv", csv);
    write_file_atomically(
        folder / "ratio.md",
        table + fmt::format("\nParts of a bearing's error, measured: common to a landmark {:.2f} "
                            "mrad, of a view "
                            "{:.2f} mrad, new in each frame {:.2f} mrad.\n",
                            1e3 * parts.common, 1e3 * parts.view, 1e3 * parts.frame));
    draw(folder);
    return json;
  }

 private:
  // The runs of one clock at one ratio.
  struct Side {
    std::vector<double> bias_mm;
    Groups by_landmark, by_view;
  };

  SwingMode mode(int frames, bool locked) const {
    if (frames == nearest_frames_per_swing()) return camera_rate(size_, locked);
    return {fmt::format("ratio_{}_{}", locked ? "locked" : "scheduled", frames),
            {.locked = locked, .frames_per_swing = frames, .duration_s = size_.duration_s}};
  }

  std::vector<int> with_camera_rate() const {
    std::vector<int> all = frames_;
    all.push_back(nearest_frames_per_swing());
    return all;
  }

  Side side(const SwingRuns& runs, int frames, bool locked) const {
    Side side;
    for (const SwingRun& run : runs.read_all(mode(frames, locked), size_.poses, size_.seeds)) {
      side.bias_mm.push_back(run.bias_mm);
      add_by_landmark(run, side.by_landmark);
      if (locked) add_by_view(run, side.by_view);
    }
    return side;
  }

  ErrorParts error_parts(const std::map<int, Side>& locked,
                         const std::map<int, Side>& scheduled) const {
    // Views repeat exactly where frames are few: what differs between them is new in each frame.
    const double frame = within_variance(locked.at(frames_.front()).by_view);
    const Groups& free = scheduled.at(nearest_frames_per_swing()).by_landmark;
    const double all = within_variance(free);
    return {.common = root_mean_square_of_means(free),
            .view = std::sqrt(std::max(0.0, all - frame)),
            .frame = std::sqrt(frame)};
  }

  // Mean over poses, beacons in sight and phases.
  template <typename Function>
  double over_views(int frames, const Function& function) const {
    std::vector<double> values;
    for (const Pose2& pose : size_.poses) {
      for (const Landmark& place : kBeaconPlaces) {
        const double bearing =
            maths::atan2(place.y_m - pose.y_m, place.x_m - pose.x_m) - pose.theta_rad;
        for (int i = 0; i < 16; ++i) {
          const int views = locked_views(kSwing, frames, (i + 0.5) / 16, bearing, kHalfView_rad);
          if (views > 0) values.push_back(function(views));
        }
      }
    }
    return mean_of(values);
  }

  double mean_views(int frames) const {
    return over_views(frames, [](int views) { return views; });
  }

  double theory_rad(int frames, const ErrorParts& parts) const {
    return std::sqrt(over_views(frames, [&](int views) {
      const double bias = locked_bias(parts, views, size_.duration_s / kSwingPeriod_s);
      return bias * bias;
    }));
  }

  static void draw(const std::filesystem::path& folder) {
    const std::string axis =
        "set logscale x 2\nset xrange [3.5:115]\nset xtics (4,6,8,12,25,36,50,101)\n"
        "set xlabel 'frames in one swing of the head'\nset key top right\nset yrange [0:*]\n";
    plot(folder, "head_swing_position",
         axis +
             "set ylabel 'position bias [mm], mean and 95 % interval'\n"
             "plot 'ratio.csv' using ($1*0.99):2:3 with yerrorlines ls 2 title 'frames locked to "
             "the "
             "swing', \\\n"
             "  '' using ($1*1.01):4:5 with yerrorlines ls 3 title 'the camera''s own clock'\n");
    plot(folder, "head_swing_bearing",
         axis +
             "set ylabel 'bearing bias of a beacon [mrad], root mean square'\n"
             "plot 'ratio.csv' using 1:8 with points ls 2 ps 1.4 title 'locked, measured', \\\n"
             "  '' using 1:10 with lines ls 2 title 'locked, theory', \\\n"
             "  '' using 1:9 with linespoints ls 3 title 'own clock, measured'\n");
  }

  StudySize size_;
  std::vector<int> frames_;
};

}  // namespace

std::unique_ptr<SwingStudy> ratio_study(const StudySize& size) {
  return std::make_unique<RatioStudy>(size);
}

}  // namespace seam::tools
