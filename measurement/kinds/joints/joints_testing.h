// For tests of servos with torque: a model from lines of effects, and logs that it would give.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "measurement/fitting/assess.h"
#include "measurement/kinds/joints/joints.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::measurement {

inline Model model_of(const std::string& effects) {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects:\n" + effects, "test.yaml"));
}

// To all logs, of all that the model marks as free.
inline Fit fitted_to_all(const JointsProblem& problem, const Model& start) {
  return problem.fit(start, refitted_unknowns(start), problem.all_groups());
}

enum class Commands { steps, slow_sines };

// Steps of a loaded joint at two gains, with releases or without, as `truth` has them, with noise.
class MadeSet {
 public:
  explicit MadeSet(const std::string& name, bool releases = true,
                   Commands commands = Commands::steps)
      : folder_(std::filesystem::path(testing::TempDir()) / name) {
    std::filesystem::create_directories(folder_);
    const RandomStream random{5, 1};
    std::string rows = "run,time_s,joint,command_rad,measured_rad,kp,torque_enable\n";
    for (int run = 0; run < 6; ++run) {
      for (int k = 0; k < 300; ++k) {
        const int block = k / 50;
        const double command = commands == Commands::steps
                                   ? (uniform(random, 100 * run + block) - 0.5) * 2.4
                                   : std::sin(0.01 * k * (1.5 + 0.5 * run));
        rows += fmt::format("{},{:.3f},arm,{:.4f},0,{},{}\n", run, 0.01 * k, command,
                            run % 2 == 0 ? 3 : 8, releases && block == 3 ? 0 : 1);
      }
    }
    write_file_atomically(folder_ / "joints.csv", rows);
    write_file_atomically(folder_ / "measurement.yaml", yaml_of("noise: {measured_rad: 0.0005}\n"));
  }
  JointsProblem made_by(const Model& truth, uint64_t seed) const {
    const auto out = folder_ / "made";
    std::filesystem::remove_all(out);
    measure_joints(truth, MeasurementSet::open(folder_), {.seed = seed, .out = out});
    return JointsProblem(MeasurementSet::open(out));
  }
  // The same, its noise not stated.
  JointsProblem made_unstated(const Model& truth, uint64_t seed) const {
    made_by(truth, seed);
    write_file_atomically(folder_ / "made" / "measurement.yaml", yaml_of(""));
    return JointsProblem(MeasurementSet::open(folder_ / "made"));
  }

 private:
  static std::string yaml_of(const std::string& noise) {
    return "format: seam-measurement/1\nkind: joints\ntitle: made\n" + noise +
           "group: run\nfiles: {joints: joints.csv}\n";
  }
  std::filesystem::path folder_;
};

}  // namespace seam::measurement
