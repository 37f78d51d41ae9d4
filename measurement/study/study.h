// Studies of the search itself: many small sets with a known answer, made by the simulator's own
// definitions and diagnosed (`seam study`). What a set gives depends on the plan and its number
// alone.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "measurement/imaging/instruments.h"
#include "measurement/judge/rate.h"
#include "measurement/search/search.h"
#include "measurement/study/conditions.h"

namespace seam::measurement {

struct StudyPlan {
  std::string kind;       // points, board, video, joints, odometry, landmarks, photometry, frames.
  std::string effect;     // Hidden in each set; empty: none, so that all findings are false alarms.
  std::string parameter;  // The one that is not neutral; empty: the effect's first.
  // Effects with values, as in a model ("{frame_latency: {latency_s: 0.02}}"): hidden together in
  // place of `effect`, and those that truth and model both have.
  std::string hidden, beside;
  double material = 0;         // The least that counts; 0: how significance alone does.
  Conditions conditions;       // What recordings are like.
  std::vector<double> sizes;   // In standard errors of that parameter, as these sets tell it.
  std::vector<double> values;  // The same in its own unit.
  int seeds = 2;
  uint64_t first_seed = 1;
  std::filesystem::path folder;  // Sets are made here and removed again.
  Instruments instruments;       // For kinds that need them.

  // All that the sets depend on, for files that keep them; how many there are does not count.
  std::string text() const;
};

// Does the jobs from `first` to `last`, without it, in any order, here or in other processes:
// `work` gives a job's result as a text, `done` takes it here. False where somebody stopped it
// before all were done.
using Jobs = std::function<bool(uint64_t first, uint64_t last,
                                const std::function<std::string(uint64_t)>& work,
                                const std::function<void(uint64_t, const std::string&)>& done)>;

// A set whose search does not end as the set was made.
struct OddSet {
  uint64_t seed = 0;
  std::string verdict;
  std::vector<std::string> steps;  // Effects that the search ends with.
  double error = 0;
};

// What came out at one size of the effect.
struct StudyRow {
  double size = 0;   // In standard errors; NaN where the value was given.
  double value = 0;  // Of the parameter.
  int sets = 0;      // Finished: as many as the plan's seeds, unless the study was stopped.
  Rate alarms;   // Verdict other than adequate; where errors wander, other than by a noise's name.
  Rate noises;   // Where errors wander: noises are named, nothing else, and explain all.
  Rate first;    // The effect (one of several) ranks first or is declared tied with the first.
  Rate exact;    // The search ends with the effects (or declared ties) and no others.
  Rate adds;     // The search ends with an effect of the mean that is not there.
  Rate covered;  // True value within two standard errors, where the search ends with the effect.
  double error = 0;         // Mean of the final error.
  double error_sigma = 0;   // Standard error of this mean.
  std::vector<OddSet> odd;  // To be looked at: `--first-seed` makes them again.
};

struct StudyResult {
  size_t residuals = 0;        // In one set.
  bool stopped = false;        // Before all sets were finished.
  std::vector<StudyRow> rows;  // Of sizes with a finished set.
};

// Throws InputError for a kind without a protocol, or an effect that does not act on it. A study of
// more seeds has the jobs of one of fewer, with the same numbers.
StudyResult study(const StudyPlan& plan, const Jobs& jobs);

std::string study_json(const StudyPlan& plan, const StudyResult& result);
std::string study_text(const StudyPlan& plan, const StudyResult& result);

// Writes the kind's protocol of about 1,000 residuals (images: of a few thousand samples) into a
// folder; returns its nominal model.
Model write_study_protocol(const std::string& kind, const std::filesystem::path& folder);

// Parts of them, for other protocols. The ERS-210's head on its neck as the `rig:` of a set: tilt
// about the axis given ("[0, -1, 0]" is up), then pan.
std::string head_rig(const std::string& tilt_axis);
// The protocol of landmarks: a robot that walks in circles of changing width among six landmarks
// and looks around; a run every 10 s.
void write_landmark_walks(const std::filesystem::path& folder, int runs, double first_time_s);

}  // namespace seam::measurement
