// `seam sweep rerun`: makes runs again and compares them, on this machine with this program.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "app/scratch_folder.h"
#include "app/session/behaviours.h"
#include "app/session/runs_made_here.h"
#include "app/sweep/makers.h"
#include "app/sweep/results.h"
#include "app/sweep/sweep.h"
#include "app/sweep/table.h"
#include "app/trust/program_consent.h"
#include "sim_core/base/error.h"
#include "sim_core/base/random.h"
#include "sim_core/input/shown_text.h"
#include "tools/command.h"
#include "tools/sweep/sweep.h"

namespace seam::tools {
namespace {

struct SweepRerunOptions {
  std::string file;
  std::string sample;
  std::vector<std::string> runs;
  uint64_t seed = 1;
  int jobs = 0;
  bool run_programs = false;
};

double number_from(const std::string& text, const char* option, const char* expected) {
  double number = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || rest != text.data() + text.size() || !(number >= 0))
    throw UsageError(fmt::format("{} {}: expected {}", option, text, expected));
  return number;
}

// As many of these as the sample asks for ("1%" or a number), chosen by their numbers alone.
std::vector<uint64_t> sample_of(std::vector<uint64_t> runs, const std::string& sample,
                                uint64_t seed) {
  if (sample.empty()) return runs;
  const bool percent = sample.back() == '%';
  const double number = number_from(percent ? sample.substr(0, sample.size() - 1) : sample,
                                    "--sample", "a percentage such as 1%, or a number of runs");
  const double wanted =
      percent ? std::ceil(number / 100 * static_cast<double>(runs.size())) : std::floor(number);
  const auto count = static_cast<size_t>(std::min(wanted, static_cast<double>(runs.size())));
  const RandomStream stream = RandomStream{seed}.child("rerun");
  std::sort(runs.begin(), runs.end(), [&](uint64_t a, uint64_t b) {
    return random_bits(stream, a) < random_bits(stream, b);
  });
  runs.resize(count);
  std::sort(runs.begin(), runs.end());
  return runs;
}

std::vector<uint64_t> chosen_runs(const app::ResultsFile& results,
                                  const SweepRerunOptions& options) {
  std::vector<uint64_t> finished, failed;
  results.each([&](const app::RunRecord& record) {
    (record.failed() ? failed : finished).push_back(record.run);
  });
  if (options.runs.empty()) return sample_of(std::move(finished), options.sample, options.seed);
  std::vector<uint64_t> chosen;
  for (const std::string& text : options.runs) {
    const auto run = static_cast<uint64_t>(number_from(text, "--run", "the number of a run"));
    if (!std::binary_search(finished.begin(), finished.end(), run) &&
        !std::binary_search(failed.begin(), failed.end(), run))
      throw InputError(fmt::format("{}: run {} is not there", options.file, text));
    chosen.push_back(run);
  }
  return chosen;
}

// Columns in which two records of a run differ, with both values.
std::string differences(const app::SweepPlan& plan, const app::RunRecord& before,
                        const app::RunRecord& now) {
  const auto columns = app::table_columns(plan);
  const auto a = app::table_cells(plan, before), b = app::table_cells(plan, now);
  std::string text;
  for (size_t i = 0; i < columns.size(); ++i) {
    if (a[i] == b[i]) continue;
    text += fmt::format("{}{} was '{}', is '{}'", text.empty() ? "" : "; ", columns[i], a[i], b[i]);
  }
  return text.empty() ? "what the table does not show differs" : text;
}

// The commands that these runs start, each once.
std::vector<std::string> programs_of(const app::SweepPlan& plan,
                                     const std::vector<uint64_t>& runs) {
  std::vector<std::string> all;
  for (const uint64_t run : runs) {
    const std::vector<std::string> of_run = app::programs_of(plan.scenario(run));
    all.insert(all.end(), of_run.begin(), of_run.end());
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

void rerun(const SweepRerunOptions& options) {
  if (!options.sample.empty() && !options.runs.empty())
    throw UsageError("rerun: give --sample or --run, not both");
  const auto results = app::ResultsFile::for_reading(options.file);
  const app::SweepPlan& plan = results.plan();
  const std::vector<uint64_t> runs = chosen_runs(results, options);
  app::ProgramPrints prints;
  const app::Makers makers = app::makers_of(plan, prints);
  if (makers != results.makers())
    std::printf("other programs made these results: SEAM %s (%s), behaviours %s\n",
                results.makers().version.c_str(), results.makers().program.c_str(),
                results.makers().behaviours.c_str());
  app::require_consent(
      programs_of(plan, runs),
      options.run_programs || app::RunsMadeHere().holds(app::made_by(plan, makers)));
  const app::ScratchFolder scratch("rerun");
  uint64_t different = 0;
  const app::SweepOutcome outcome = app::make_runs(
      plan, runs, makers, options.jobs, scratch.path(), [&](const app::RunRecord& now) {
        const auto before = results.record(now.run);
        if (before && !before->failed() && !now.failed() && app::same_result(*before, now)) return;
        const bool failed_before = before && before->failed();
        if (!failed_before || !now.failed()) ++different;
        const std::string what =
            now.failed()    ? (failed_before ? "failed again: " : "failed now: ") + now.error
            : failed_before ? "finished now, and failed before"
                            : differences(plan, *before, now);
        std::printf("run %llu: %s\n", static_cast<unsigned long long>(now.run),
                    shown_lines(what).c_str());
      });
  std::printf("%llu of %zu runs made again, %llu of them differ\n",
              static_cast<unsigned long long>(outcome.made), runs.size(),
              static_cast<unsigned long long>(different));
  if (different > 0 || outcome.interrupted) throw ExitCode{1};
}

}  // namespace

void add_sweep_rerun(app::Command sweep) {
  app::Command command = sweep.add_subcommand(
      "rerun", "Makes runs again from the results alone, and compares them to the bit");
  auto options = std::make_shared<SweepRerunOptions>();
  command.add_option("RESULTS", options->file, "A file that `seam sweep` made").required();
  command.add_option("--sample", options->sample,
                     "So many of them: a percentage such as 1%, or a number; left out: all");
  command.add_option("--run", options->runs,
                     "These runs, by their numbers; also failed ones, which\n"
                     "then show what their behaviours print");
  command.add_option("--seed", options->seed, "Of the choice of a sample").show_default();
  command.add_option("--jobs", options->jobs, "Runs at once; 0 is one for each core")
      .range(0, 1024);
  command.add_flag("--run-programs", options->run_programs,
                   "Start the programs that results of others name, without asking");
  command.footer(
      "Exit code 0 when all of them agree, 1 when one does not; each that differs is named.\n"
      "Example: seam sweep rerun results.sqlite --sample 1% --run-programs");
  command.callback([options] { rerun(*options); });
}

}  // namespace seam::tools
