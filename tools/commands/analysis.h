// What the analysis commands (compare, diagnose, add, fit, discover) share.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "app/command_line.h"
#include "app/predictors/outcome_runs.h"
#include "app/terminal_progress.h"
#include "measurement/problem/problem.h"
#include "measurement/report/report_data.h"
#include "measurement/report/results.h"
#include "sim_core/base/output.h"

namespace seam::tools {

struct AnalysisFlags {
  std::string model;
  std::string data;
  std::string leave_out;  // Rows of the set that take no part.
  std::string json;
  std::string report;
  std::string target;         // Where the points of the target are, of an earlier fit.
  std::string target_out;     // Where to write where this one finds them.
  std::string attitudes_out;  // Where to write how the camera was turned in each view.
  double material = measurement::kMaterial;
  app::OutcomeRunsOptions runs;  // Of sets of outcomes.
};

// --model, --data, --target and --json; --report where wanted.
void add_analysis_flags(app::Command command, AnalysisFlags& flags, bool with_report);

// --material, for commands that say what matters.
void add_material_flag(app::Command command, AnalysisFlags& flags);

// --runs and --run-programs, of commands that make runs for sets of outcomes.
void add_run_flags(app::Command command, app::OutcomeRunsOptions& options);

// The same without --model.
void add_data_flags(app::Command command, AnalysisFlags& flags, bool with_report);

// --target-out, for commands that fit a model.
void add_target_out_flag(app::Command command, AnalysisFlags& flags);

std::unique_ptr<measurement::Problem> open_problem(const AnalysisFlags& flags);
// The set that the flags name, without the rows that --leave-out names.
measurement::MeasurementSet open_set(const AnalysisFlags& flags);

effects::Model read_model(const std::string& path);

// Doubts about the data under this model: what stands before a command's results.
measurement::Doubts doubts_about(const AnalysisFlags& flags, const effects::Model& model,
                                 double error);
// Of a search: the error that speaks for such doubts, none of size where what was found explains
// the set.
double unexplained_error(const measurement::SearchResult& result);

// How a formula that reaches the noise becomes an effect of the model: the commands, with a name to
// fill in. `suggested` is the file that has it; empty: none. `model` is what it is added to.
std::string how_to_add(const AnalysisFlags& flags, const std::string& model,
                       const std::string& suggested, const measurement::SearchResult& result);

// What a set names, its pictures too, and no output may replace. A set that cannot be
// opened has none: its command says why.
std::vector<std::filesystem::path> files_of_set(const std::string& folder);

// What a command writes, claimed before it reads and computes: a path that cannot be written is
// an error at once. `out` is a model or effect that the command makes.
struct AnalysisOutputs {
  // `further`: more files that are read; one without a name is none.
  explicit AnalysisOutputs(const AnalysisFlags& flags, const std::string& out = "",
                           const std::vector<std::string>& further = {});
  // Prints the text; writes the JSON, which may be long to make, where the user asked for it.
  void print(const std::string& text, const std::function<std::string()>& make_json);

  OutputFile json;
  OutputFile report;
  OutputFile out;
  OutputFile target;
  OutputFile attitudes;

 private:
  app::TerminalProgress progress_;
};

// What a report says of where it comes from: `seam <command> --model M --data D`.
measurement::ReportHeader report_header(const std::string& command, const AnalysisFlags& flags,
                                        const measurement::Doubts& doubts);

// What goes on, for the line that AnalysisOutputs keeps on the terminal of who waits.
measurement::Progress progress_to_terminal();

// Effects by a catalogue name, or of a file (`effects:` with expression effects).
measurement::EffectList effects_named(const std::string& name_or_file);

}  // namespace seam::tools
