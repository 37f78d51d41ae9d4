// What is left of the position bias without any lock, and where it comes from; and how much the
// choices of the localisation matter: the same runs with one thing changed at a time.
#include <fmt/format.h>

#include <cmath>

#include "app/data_file.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"
#include "tools/experiments/head_swing/swing_studies.h"
#include "tools/experiments/statistics.h"

namespace seam::tools {
namespace {

class RemainderStudy final : public SwingStudy {
 public:
  explicit RemainderStudy(const StudySize& size) : size_(size) {
    const PoseMode as_it_is{.frames_per_swing = kFramesASwing, .duration_s = size.duration_s};
    modes_ = {{{fmt::format("ratio_scheduled_{}", kFramesASwing), as_it_is},
               "as it is: own clock, 25 frames a swing, 1,000 particles"}};
    const auto add = [&](const char* name, const char* title, const auto& change) {
      PoseMode changed = as_it_is;
      change(changed);
      modes_.push_back({{name, changed}, title});
    };
    if (size.quick) return;
    const std::string ideal = read_file(app::data_file("models/ideal_camera.yaml"));
    add("rest_bearings", "bearings alone, ranges not used",
        [](PoseMode& m) { m.use_ranges = false; });
    add("rest_ideal", "ideal camera", [&](PoseMode& m) { m.model_yaml = ideal; });
    add("rest_ideal_bearings", "ideal camera, bearings alone",
        [&](PoseMode& m) { m.model_yaml = ideal, m.use_ranges = false; });
    add("particles_250", "250 particles", [](PoseMode& m) { m.particles = 250; });
    add("particles_4000", "4,000 particles", [](PoseMode& m) { m.particles = 4000; });
    add("width_half", "sensor model half as wide", [](PoseMode& m) { m.sensor_width = 0.5; });
    add("width_twice", "sensor model twice as wide", [](PoseMode& m) { m.sensor_width = 2; });
  }

  void plan(SwingRuns& runs) const override {
    for (const Changed& changed : modes_) runs.plan(changed.mode, size_.poses, size_.seeds);
  }

  nlohmann::json report(const SwingRuns& runs, const std::filesystem::path& folder) const override {
    std::string table =
        "| Changed | Position bias, mm | Less than as it is by, mm (95 %) | Bearings' bias, mrad | "
        "Ranges' bias, % | Division, mm | "
        "Truth inside |\n|---|---|---|---|---|---|---|\n";
    nlohmann::json json = nlohmann::json::array();
    std::vector<double> base;
    for (const Changed& changed : modes_) {
      std::vector<double> bias_mm, bearing_mrad, range_percent, width_mm, inside;
      for (const SwingRun& run : runs.read_all(changed.mode, size_.poses, size_.seeds)) {
        bias_mm.push_back(run.bias_mm);
        width_mm.push_back(run.width_mm);
        inside.push_back(run.truth_inside ? 100 : 0);
        add_means(run, bearing_mrad, range_percent);
      }
      if (base.empty()) base = bias_mm;
      const Interval less = seed_interval(differences(base, bias_mm), size_.poses.size());
      table += fmt::format("| {} | {:.1f} | {} | {:.1f} | {:.1f} | {:.0f} | {:.0f} % |\n",
                           changed.title, mean_of(bias_mm),
                           &changed == &modes_.front()
                               ? "/"
                               : fmt::format("{:+.1f} ± {:.1f}", less.mean, less.half_width),
                           root_mean_square(bearing_mrad), root_mean_square(range_percent),
                           mean_of(width_mm), mean_of(inside));
      json.push_back({{"mode", changed.mode.name},
                      {"bias_mm", mean_of(bias_mm)},
                      {"less_mm", less.mean},
                      {"less_ci95", {less.mean - less.half_width, less.mean + less.half_width}},
                      {"bearing_mrad", root_mean_square(bearing_mrad)},
                      {"range_percent", root_mean_square(range_percent)},
                      {"division_mm", mean_of(width_mm)},
                      {"inside_percent", mean_of(inside)}});
    }
    write_file_atomically(folder / "remainder.md", table);
    return json;
  }

 private:
  struct Changed {
    SwingMode mode;
    std::string title;
  };

  // Of each beacon in a run: the mean errors of its bearing and of its range.
  static void add_means(const SwingRun& run, std::vector<double>& bearing_mrad,
                        std::vector<double>& range_percent) {
    for (int landmark = 0; landmark < kBeacons; ++landmark) {
      std::vector<double> bearings, ranges;
      for (const Sighting& s : run.sightings) {
        if (s.landmark != landmark) continue;
        bearings.push_back(1e3 * s.bearing_error_rad);
        if (std::isfinite(s.range_error)) ranges.push_back(1e2 * s.range_error);
      }
      if (!bearings.empty()) bearing_mrad.push_back(mean_of(bearings));
      if (!ranges.empty()) range_percent.push_back(mean_of(ranges));
    }
  }

  StudySize size_;
  std::vector<Changed> modes_;
};

}  // namespace

std::unique_ptr<SwingStudy> remainder_study(const StudySize& size) {
  return std::make_unique<RemainderStudy>(size);
}

}  // namespace seam::tools
