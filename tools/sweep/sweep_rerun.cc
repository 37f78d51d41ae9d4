// `seam sweep rerun`: makes runs again and compares them, on this machine with this program.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "app/bundle/bundle.h"
#include "app/bundle/unpacked.h"
#include "app/logs/log_difference.h"
#include "app/scratch_folder.h"
#include "app/session/run_session.h"
#include "app/session/runs_made_here.h"
#include "app/session/session_outputs.h"
#include "app/sweep/makers.h"
#include "app/sweep/results.h"
#include "app/sweep/sweep.h"
#include "app/sweep/table.h"
#include "app/trust/program_consent.h"
#include "sim_core/base/error.h"
#include "sim_core/base/hash.h"
#include "sim_core/base/random.h"
#include "sim_core/input/shown_text.h"
#include "tools/command.h"
#include "tools/sweep/sweep.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;

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

// What there is to make again, and where.
struct Reruns {
  const app::ResultsFile& results;
  fs::path logs;     // Recorded when the results were made; there where the plan keeps them.
  fs::path scratch;  // What is made now.
  std::function<void(Scenario&)> move = {};  // To a bundle's files.

  Scenario scenario(uint64_t run) const {
    Scenario scenario = results.plan().scenario(run);
    if (move) move(scenario);
    return scenario;
  }
};

// The commands that these runs start, each once.
std::vector<std::string> programs_of(const Reruns& reruns, const std::vector<uint64_t>& runs) {
  std::vector<std::string> all;
  for (const uint64_t run : runs) {
    const std::vector<std::string> of_run = app::programs_of(reruns.scenario(run));
    all.insert(all.end(), of_run.begin(), of_run.end());
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

// Where the logs of a run first differ: the step, what differs in it, the decision before.
std::string first_step(const fs::path& before, const fs::path& now) {
  std::error_code unknown;
  if (!fs::exists(before, unknown) || !fs::exists(now, unknown)) return "";
  scheduler::LogDifference difference =
      app::difference_of(scheduler::Log::open(before), scheduler::Log::open(now));
  difference.header.clear();  // The folders of a bundle are other ones here.
  return "\n" + app::to_text(difference);
}

// How a run differs from what it was; empty where it does not.
std::string how_different(const Reruns& reruns, const app::RunRecord& now) {
  const auto before = reruns.results.record(now.run);
  const bool failed_before = before && before->failed();
  if (now.failed()) return (failed_before ? "failed again: " : "failed now: ") + now.error;
  if (failed_before) return "finished now, and failed before";
  if (before && app::same_result(*before, now)) return "";
  const std::string log = fmt::format("run_{:06}.mcap", now.run);
  return differences(reruns.results.plan(), *before, now) +
         first_step(reruns.logs / log, reruns.scratch / log);
}

int rerun_runs(const Reruns& reruns, const SweepRerunOptions& options, const app::Makers& makers,
               bool agreed) {
  const std::vector<uint64_t> runs = chosen_runs(reruns.results, options);
  app::require_consent(programs_of(reruns, runs), agreed);
  uint64_t different = 0;
  const app::SweepOutcome outcome = app::make_runs(
      reruns.results.plan(), runs, makers, options.jobs, reruns.scratch,
      [&](const app::RunRecord& now) {
        const std::string what = how_different(reruns, now);
        std::error_code unknown;
        fs::remove(reruns.scratch / fmt::format("run_{:06}.mcap", now.run), unknown);
        if (what.empty()) return;
        if (!what.starts_with("failed again")) ++different;
        std::printf("run %llu: %s\n", static_cast<unsigned long long>(now.run),
                    shown_lines(what).c_str());
      },
      {}, reruns.move);
  const bool equal = different == 0 && !outcome.interrupted;
  std::printf("%s%llu of %zu runs made again, %llu of them differ\n", equal ? "equal: " : "",
              static_cast<unsigned long long>(outcome.made), runs.size(),
              static_cast<unsigned long long>(different));
  return equal ? 0 : 1;
}

int rerun_results(const SweepRerunOptions& options) {
  const auto results = app::ResultsFile::for_reading(options.file);
  app::ProgramPrints prints;
  const app::Makers makers = app::makers_of(results.plan(), prints);
  if (makers != results.makers())
    std::printf("other programs made these results: SEAM %s (%s), behaviours %s\n",
                shown(results.makers().version).c_str(), shown(results.makers().program).c_str(),
                shown(results.makers().behaviours).c_str());
  const app::ScratchFolder scratch("rerun");
  return rerun_runs(
      {.results = results, .logs = app::run_files(options.file), .scratch = scratch.path()},
      options, makers,
      options.run_programs || app::RunsMadeHere().holds(app::made_by(results.plan(), makers)));
}

// A log's run again, with its behaviours.
int rerun_log(const app::UnpackedBundle& bundle, const SweepRerunOptions& options) {
  if (!options.sample.empty() || !options.runs.empty())
    throw UsageError("rerun: this bundle is of one run, expected neither --sample nor --run");
  const fs::path recorded = bundle.place(bundle.manifest().of);
  const auto before = scheduler::Log::open(recorded).end();
  scheduler::RunHeader header = scheduler::Log::open(recorded).header();
  Scenario scenario = Scenario::from_made_text(header.scenario_text, header.scenario_name);
  scenario.seed = static_cast<int64_t>(header.seed);
  bundle.move_here(scenario);
  if (app::programs_of(scenario).empty())
    throw InputError(
        fmt::format("{}: its scenario starts no behaviours, expected some: tar xzf "
                    "unpacks it, and seam replay verify compares the log",
                    options.file));
  app::require_consent(app::programs_of(scenario), options.run_programs);
  header.scenario_text = scenario.to_yaml();
  app::Simulator simulator = app::make_simulator(header);
  app::SessionOptions session{
      .log = (bundle.scratch() / "run.mcap").string(), .progress = false, .show_printed = false};
  app::SessionSummary now;
  {
    app::SessionOutputs outputs(session);
    now = app::run_session(simulator, session, outputs);
  }
  if (before && before->fingerprint == now.fingerprint) {
    std::printf("equal: the run has the fingerprint %s again\n", to_hex(now.fingerprint).c_str());
    return 0;
  }
  std::printf("the run differs: fingerprint was %s, is %s%s\n",
              before ? to_hex(before->fingerprint).c_str() : "missing",
              to_hex(now.fingerprint).c_str(),
              shown_lines(first_step(recorded, session.log)).c_str());
  return 1;
}

int rerun_bundle(const SweepRerunOptions& options) {
  const app::UnpackedBundle bundle(options.file);
  const app::BundleManifest& manifest = bundle.manifest();
  const app::WorkingFolder work(bundle.work());
  app::ProgramPrints prints;
  const std::string program = app::program_print(prints);
  if (program != manifest.program)
    std::printf("another program made this bundle: SEAM %s (%s)\n", shown(manifest.version).c_str(),
                shown(manifest.program).c_str());
  for (const std::string& need : manifest.needs) std::printf("it needs: %s\n", shown(need).c_str());
  std::fflush(stdout);
  if (app::is_log(bundle.place(manifest.of))) return rerun_log(bundle, options);
  const auto results = app::ResultsFile::for_reading(bundle.place(manifest.of));
  return rerun_runs({.results = results,
                     .logs = bundle.place("logs"),
                     .scratch = bundle.scratch(),
                     .move = [&](Scenario& scenario) { bundle.move_here(scenario); }},
                    options, {SEAM_VERSION, program, results.makers().behaviours},
                    options.run_programs);
}

void rerun(const SweepRerunOptions& options) {
  if (!options.sample.empty() && !options.runs.empty())
    throw UsageError("rerun: give --sample or --run, not both");
  const int code = app::is_bundle(options.file) ? rerun_bundle(options) : rerun_results(options);
  if (code != 0) throw ExitCode{code};
}

}  // namespace

void add_sweep_rerun(app::Command sweep) {
  app::Command command = sweep.add_subcommand(
      "rerun", "Makes runs again from results or a bundle alone, and compares them to the bit");
  auto options = std::make_shared<SweepRerunOptions>();
  command
      .add_option("FILE", options->file,
                  "Results that `seam sweep` made, or a bundle (seam sweep bundle)")
      .required();
  command.add_option("--sample", options->sample,
                     "So many of them: a percentage such as 1%, or a number; left out: all");
  command.add_option("--run", options->runs,
                     "These runs, by their numbers; also failed ones, which\n"
                     "then show what their behaviours print");
  command.add_option("--seed", options->seed, "Of the choice of a sample").show_default();
  command.add_option("--jobs", options->jobs, "Runs at once; 0 is one for each core")
      .range(0, 1024);
  command.add_flag("--run-programs", options->run_programs,
                   "Start the programs that files of others name, without asking");
  command.footer(
      "Exit code 0 when all of them agree, 1 when one does not: each that differs is named with\n"
      "its values, and, where logs were kept, with the first step that differs.\n"
      "Example: seam sweep rerun results.sqlite --sample 1% --run-programs");
  command.callback([options] { rerun(*options); });
}

}  // namespace seam::tools
