// A plan of runs, format seam-sweep/1 (docs/sweeps.md): a scenario, what is changed in it, and what
// is kept. Run number k is a pure function of the plan.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "app/scenario_tree.h"
#include "app/sweep/plan/axis.h"
#include "app/sweep/plan/keep.h"
#include "sim_core/base/config.h"

namespace seam::app {

// All that a plan is made of, as results keep it: the runs can be made again from this alone.
struct PlanTexts {
  std::string name;           // The plan's file name, for messages.
  std::string plan;           // Its YAML.
  std::string scenario_name;  // As the plan names it.
  std::string scenario;       // One document, with the files that it names and without tokens.
  std::map<std::string, std::string> files;  // Tables and models that the plan names.
  bool operator==(const PlanTexts&) const = default;
};

// The settings of one run, as they stand in tables.
struct RunSettings {
  std::vector<WrittenValue> values;  // Of the plan's parameters.
  uint64_t repetition = 0;
};

class SweepPlan {
 public:
  // A plan of more runs is an error.
  static constexpr uint64_t kMostRuns = 10'000'000;

  // Throws InputError naming file, line and key; a few runs at the ends of what varies are worked
  // out, so that a slip in a path or a value is an error at once.
  static SweepPlan from_file(const std::filesystem::path& file);
  static SweepPlan from_texts(const PlanTexts& texts);

  const PlanTexts& texts() const { return texts_; }
  // Of everything that the plan is made of; comments and layout do not count.
  uint64_t fingerprint() const;

  uint64_t runs() const { return runs_; }
  // Names of what varies, in the order of the plan.
  const std::vector<std::string>& parameters() const { return parameters_; }
  // How many seeds `seeds:` names; 0: the plan has no such line.
  uint64_t seeds() const { return seeds_; }
  uint64_t repetitions() const { return repetitions_; }
  const Keep& keep() const { return keep_; }
  // `limits: {wall_s}`: a run that takes longer is aborted.
  std::optional<double> wall_limit_s() const { return wall_limit_s_; }

  // Settings vary like nested loops in the order of the plan, the last one fastest, repetitions
  // faster still.
  RunSettings settings(uint64_t run) const;
  // Throws InputError naming the run.
  Scenario scenario(uint64_t run) const;
  // Programs that the behaviours of the runs that were worked out name, with a robot that does.
  const std::map<std::vector<std::string>, std::string>& commands() const { return commands_; }
  // Runs in which each setting of whatever varies by words, files and maps is there at least once:
  // all names in the plan are in one of their scenarios.
  std::vector<uint64_t> runs_of_words() const;

 private:
  using Known = std::map<uint64_t, Scenario>;  // By run.

  SweepPlan(PlanTexts texts, PlanFiles files);
  void read(const ConfigNode& root);
  std::set<std::string> parameters_without_number() const;
  void read_changes(const ConfigNode& root);
  void read_axes(const ConfigNode& root);
  void count_runs(const ConfigNode& root);
  void name_columns(const ConfigNode& root);
  void try_some_runs();
  Scenario worked_out(uint64_t run, const RunSettings& settings, const Known& known) const;
  uint64_t with_first_seed(uint64_t run) const;
  // A plain value that names a file as the file's text.
  WrittenValue content(const WrittenValue& value, bool takes_file) const;

  PlanTexts texts_;
  PlanFiles files_;
  std::optional<ScenarioTree> base_;  // With the changes of `set`.
  std::vector<Axis> axes_;
  uint64_t seeds_ = 0;
  uint64_t repetitions_ = 1;
  uint64_t runs_ = 1;
  std::vector<std::string> parameters_;
  Keep keep_;
  std::optional<double> wall_limit_s_;
  std::map<std::vector<std::string>, std::string> commands_;
  // Runs that were worked out, shared by copies.
  std::shared_ptr<const Known> known_ = std::make_shared<const Known>();
};

}  // namespace seam::app
