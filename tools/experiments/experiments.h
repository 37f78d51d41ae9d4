// The founding paper's experiments, each a command of `seam experiment`. Where `json` is a file, it
// is filled with the results.
#pragma once

#include <filesystem>

#include "sim_core/base/output.h"

namespace seam::tools {

struct ExperimentOptions {
  std::filesystem::path folder;  // Runs, tables and plots go here.
  int seeds = 3;
  int poses = 0;           // 0: as many as the experiment takes by itself.
  double duration_s = 30;  // Of each run of a turning head; the paper's.
  int parallel = 2;
  bool quick = false;  // A small form that shows that everything works.
};

// Section 5.1: mean and standard deviation of the measured distance, with and without camera
// effects.
void ball_distance_experiment(const ExperimentOptions& options, OutputFile& json);

// Section 5.2 and Table 1: Monte Carlo localisation at 36 poses.
void localization_experiment(const ExperimentOptions& options, OutputFile& json);

// What locking frames to the head's swing does to bearings and positions, and why.
void head_swing_bias_experiment(const ExperimentOptions& options, OutputFile& json);

}  // namespace seam::tools
