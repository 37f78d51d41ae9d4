// The bias as a function of the lock's phase, and of the drift that breaks the lock. At one pose
// and few frames a swing a beacon's mean bearing error is a function of the phase: that function is
// the bias of a locked camera. A camera whose clock drifts sees each beacon shifted in the image
// from swing to swing: once by more than a pixel of the colour layer, its edges fall elsewhere and
// the view counts as a new one. With the spread of single sightings that predicts the spread of
// their means.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

#include "sim_core/base/maths.h"
#include "sim_core/base/output.h"
#include "tools/experiments/head_swing/swing_studies.h"
#include "tools/experiments/plot.h"
#include "tools/experiments/statistics.h"

namespace seam::tools {
namespace {

constexpr int kFrames = 8;  // A swing: few enough for a plain effect.
constexpr double kNotSeen = std::numeric_limits<double>::quiet_NaN();

// Means over a mode's runs: a beacon's bearing error, NaN where it is not seen, and the position's.
struct Found {
  std::array<double, kBeacons> bearing_mrad{};
  Interval x_mm, y_mm;
};

Found found_in(const std::vector<SwingRun>& runs) {
  std::array<std::vector<double>, kBeacons> bearings;
  std::vector<double> x, y;
  for (const SwingRun& run : runs) {
    x.push_back(run.dx_mm), y.push_back(run.dy_mm);
    for (const Sighting& s : run.sightings)
      bearings[s.landmark].push_back(1e3 * s.bearing_error_rad);
  }
  Found found{.x_mm = interval_of(x), .y_mm = interval_of(y)};
  for (int b = 0; b < kBeacons; ++b)
    found.bearing_mrad[b] = bearings[b].empty() ? kNotSeen : mean_of(bearings[b]);
  return found;
}

constexpr double kColourPixel_rad = 2 / 161.9;

// How many different views of one passage a run has: a new one each time the slip has moved the
// image by a pixel, at most one a swing.
double different_views(double slip, double swings) {
  const double rate = 4 * kSwingAmplitude_rad / kSwingPeriod_s;  // Mean of its amount.
  const double shift_rad = rate * slip * kSwingPeriod_s / kFrames;
  return std::min(swings, 1 + (swings - 1) * shift_rad / kColourPixel_rad);
}

class PhaseStudy final : public SwingStudy {
 public:
  explicit PhaseStudy(const StudySize& size) : size_(size), pose_{paper_poses(4)[2]} {
    phases_ = size.quick ? 3 : 12;
    starts_ = size.quick ? 1 : 4;
    slips_ = size.quick ? std::vector<double>{0.1} : std::vector<double>{0.01, 0.03, 0.1, 0.3};
  }

  void plan(SwingRuns& runs) const override {
    for (int i = 0; i < phases_; ++i) {
      for (const bool locked : {true, false}) runs.plan(at_phase(i, locked), {pose_}, size_.seeds);
    }
    for (const double slip : slips_) {
      for (int i = 0; i < starts_; ++i) runs.plan(drifting(slip, i), {pose_}, size_.seeds);
    }
  }

  nlohmann::json report(const SwingRuns& runs, const std::filesystem::path& folder) const override {
    std::vector<Found> locked, own_clock;
    for (int i = 0; i < phases_; ++i) {
      locked.push_back(found_in(runs.read_all(at_phase(i, true), {pose_}, size_.seeds)));
      own_clock.push_back(found_in(runs.read_all(at_phase(i, false), {pose_}, size_.seeds)));
    }
    write_phases(locked, own_clock, folder);
    nlohmann::json json = {{"frames_per_swing", kFrames}, {"drift", nlohmann::json::array()}};

    std::string csv = "slip,swept,measured_mrad,theory_mrad,drift_ppm\n", table = kHead;
    const double swings = size_.duration_s / kSwingPeriod_s;
    const std::vector<Beacon> of_beacons = beacons(runs);
    const auto add = [&](double slip, const std::vector<Found>& found) {
      const double measured = deviation(found, of_beacons), theory = predicted(slip, of_beacons);
      csv += fmt::format("{},{:.3f},{:.3f},{:.3f},{:.0f}\n", slip, slip * swings, measured, theory,
                         1e6 * slip / kFrames);
      table += fmt::format("| {} | {:.0f} | {:.2f} | {:.2f} | {:.2f} |\n", slip,
                           1e6 * slip / kFrames, slip * swings, measured, theory);
      json["drift"].push_back({{"slip", slip},
                               {"ppm", 1e6 * slip / kFrames},
                               {"measured_mrad", measured},
                               {"theory_mrad", theory}});
    };
    add(0, locked);
    for (const double slip : slips_) {
      std::vector<Found> found;
      for (int i = 0; i < starts_; ++i)
        found.push_back(found_in(runs.read_all(drifting(slip, i), {pose_}, size_.seeds)));
      add(slip, found);
    }
    add(PoseMode{}.slip, own_clock);
    write_file_atomically(folder / "drift.csv", csv);
    write_file_atomically(folder / "drift.md", table);
    draw(folder);
    return json;
  }

 private:
  static constexpr char kHead[] =
      "| Frames slipped a swing | Clock off by, ppm | Frame periods swept in a run | Bearing bias "
      "that depends on phase, mrad | "
      "Theory, mrad |\n|---|---|---|---|---|\n";

  double phase(int i) const { return static_cast<double>(i) / phases_; }

  SwingMode at_phase(int i, bool locked) const {
    return {fmt::format("phase_{}_{:02}", locked ? "locked" : "scheduled", i),
            {.locked = locked,
             .frames_per_swing = kFrames,
             .phase = phase(i),
             .duration_s = size_.duration_s}};
  }

  SwingMode drifting(double slip, int start) const {
    return {fmt::format("drift_{}_{}", slip, start),
            {.locked = false,
             .frames_per_swing = kFrames,
             .slip = slip,
             .phase = (start + 0.5) / starts_,
             .duration_s = size_.duration_s}};
  }

  // Of each beacon over all runs on the own clock: mean and spread of single sightings' errors,
  // mrad.
  struct Beacon {
    double centre = kNotSeen, spread = 0, bearing_rad = 0;
  };

  std::vector<Beacon> beacons(const SwingRuns& runs) const {
    std::array<std::vector<double>, kBeacons> errors;
    for (int i = 0; i < phases_; ++i) {
      for (const SwingRun& run : runs.read_all(at_phase(i, false), {pose_}, size_.seeds)) {
        for (const Sighting& s : run.sightings)
          errors[s.landmark].push_back(1e3 * s.bearing_error_rad);
      }
    }
    std::vector<Beacon> all;
    for (int b = 0; b < kBeacons; ++b) {
      const double bearing =
          maths::atan2(kBeaconPlaces[b].y_m - pose_.y_m, kBeaconPlaces[b].x_m - pose_.x_m) -
          pose_.theta_rad;
      all.push_back(
          {errors[b].empty() ? kNotSeen : mean_of(errors[b]), deviation_of(errors[b]), bearing});
    }
    return all;
  }

  // Root mean square, over beacons and runs, of a run's mean bearing error minus the beacon's own.
  static double deviation(const std::vector<Found>& found, const std::vector<Beacon>& beacons) {
    std::vector<double> offsets;
    for (const Found& run : found) {
      for (int b = 0; b < kBeacons; ++b) {
        const double offset = run.bearing_mrad[b] - beacons[b].centre;
        if (!std::isnan(offset)) offsets.push_back(offset);
      }
    }
    return root_mean_square(offsets);
  }

  // The same by theory: a locked camera gathers a few views of a beacon, a drifting one more.
  double predicted(double slip, const std::vector<Beacon>& beacons) const {
    std::vector<double> spreads;
    for (int i = 0; i < phases_; ++i) {
      for (const Beacon& beacon : beacons) {
        const int views =
            locked_views(kSwing, kFrames, phase(i), beacon.bearing_rad, kHalfView_rad);
        if (views == 0 || std::isnan(beacon.centre)) continue;
        spreads.push_back(
            beacon.spread /
            std::sqrt(views * different_views(slip, size_.duration_s / kSwingPeriod_s)));
      }
    }
    return root_mean_square(spreads);
  }

  void write_phases(const std::vector<Found>& locked, const std::vector<Found>& own_clock,
                    const std::filesystem::path& folder) const {
    std::string bearings = "beacon,phase,locked_mrad,scheduled_mrad\n";
    for (int b = 0; b < kBeacons; ++b) {
      for (int i = 0; i < phases_; ++i) {
        bearings += fmt::format("{},{:.4f},{:.4f},{:.4f}\n", b, phase(i), locked[i].bearing_mrad[b],
                                own_clock[i].bearing_mrad[b]);
      }
    }
    std::string positions =
        "phase,locked_x_mm,locked_x_ci95_mm,locked_y_mm,locked_y_ci95_mm,scheduled_x_mm,scheduled_"
        "x_ci95_mm,scheduled_y_mm,"
        "scheduled_y_ci95_mm\n";
    for (int i = 0; i < phases_; ++i) {
      positions += fmt::format("{:.4f}", phase(i));
      for (const Found* found : {&locked[i], &own_clock[i]}) {
        positions += fmt::format(",{:.2f},{:.2f},{:.2f},{:.2f}", found->x_mm.mean,
                                 found->x_mm.half_width, found->y_mm.mean, found->y_mm.half_width);
      }
      positions += "\n";
    }
    write_file_atomically(folder / "phase_bearing.csv", bearings);
    write_file_atomically(folder / "phase_position.csv", positions);
  }

  static void draw(const std::filesystem::path& folder) {
    plot(folder, "head_swing_phase",
         "set xrange [-0.04:1]\nset xlabel 'phase of the lock, frame periods (8 frames a "
         "swing)'\nset multiplot layout 2,1\n"
         "set key outside right top\nset ylabel 'bearing bias [mrad]'\nset datafile missing 'nan'\n"
         "plot for [b=0:5] '< grep ^'.b.', phase_bearing.csv' using 2:3 with linespoints lc b+1 pt "
         "7 "
         "lw 2 title 'beacon '.b.', locked', \\\n"
         "  for [b=0:5] '< grep ^'.b.', phase_bearing.csv' using 2:4 with lines lc b+1 dt 3 title "
         "''\n"
         "set ylabel 'position bias [mm]'\n"
         "plot 'phase_position.csv' using 1:2 with linespoints ls 2 title 'x, locked', "
         "'' using 1:6 with linespoints ls 2 dt 3 title 'x, own clock', \\\n"
         "  '' using 1:4 with linespoints ls 1 title 'y, locked', "
         "'' using 1:8 with linespoints ls 1 dt 3 title 'y, own clock'\nunset multiplot\n");
    plot(folder, "head_swing_drift",
         "set key top right\nset xlabel 'frame periods that the clock slips in a run (16 s)'\nset "
         "yrange "
         "[0:*]\n"
         "set ylabel 'bearing bias that depends on phase [mrad], root mean square'\n"
         "plot 'drift.csv' using 2:3 with points ls 2 ps 1.5 title 'measured', '' using 2:4 with "
         "linespoints ls 1 title 'theory'\n");
  }

  StudySize size_;
  Pose2 pose_;
  int phases_, starts_;
  std::vector<double> slips_;
};

}  // namespace

std::unique_ptr<SwingStudy> phase_and_drift_study(const StudySize& size) {
  return std::make_unique<PhaseStudy>(size);
}

}  // namespace seam::tools
