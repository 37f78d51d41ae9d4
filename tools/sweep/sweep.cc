// `seam sweep PLAN --out RESULTS`: all runs of a plan into one file.
#include "tools/sweep/sweep.h"

#include <cstdio>

#include "app/data_file.h"
#include "app/session/runs_made_here.h"
#include "app/sweep/makers.h"
#include "app/sweep/sweep.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "tools/command.h"

namespace seam::tools {
namespace {

struct SweepOptions {
  std::string plan, out;
  std::string shard = "1/1";
  int jobs = 0;
};

void sweep(const SweepOptions& options) {
  if (options.plan.empty() || options.out.empty())
    throw UsageError("sweep: give a plan and --out RESULTS, or a subcommand (seam sweep --help)");
  const app::Shard shard = app::shard_from_text(options.shard);
  refuse_same_file(options.out, {options.plan});
  const auto plan = app::SweepPlan::from_file(app::given_or_ours(options.plan));
  app::ProgramPrints prints;
  const app::Makers makers = app::makers_of(plan, prints);
  app::RunsMadeHere().note(app::made_by(plan, makers));
  auto results = app::ResultsFile::for_writing(options.out, plan, makers, shard);
  const app::SweepOutcome outcome = app::make_missing_runs(results, options.jobs);
  const app::SweepCounts counts = results.counts();
  results.close();
  std::printf("%s: %llu of %llu runs are finished, %llu of them now; %llu failed\n",
              options.out.c_str(), static_cast<unsigned long long>(counts.finished),
              static_cast<unsigned long long>(counts.planned),
              static_cast<unsigned long long>(outcome.made - outcome.failed),
              static_cast<unsigned long long>(counts.failed));
  if (outcome.interrupted) std::printf("stopped: the same command goes on\n");
  if (counts.failed > 0)
    std::printf("`seam sweep status %s` shows why runs failed; the same command tries them again\n",
                options.out.c_str());
  if (counts.finished < counts.planned) throw ExitCode{1};
}

}  // namespace

void add_sweep(app::Command app) {
  app::Command command = app.add_subcommand(
      "sweep", "Runs a plan: a scenario over seeds, parameters and models, into one SQLite file");
  auto options = std::make_shared<SweepOptions>();
  command.add_option("PLAN", options->plan, "A seam-sweep/1 file (docs/sweeps.md)");
  command.add_option("--out", options->out,
                     "The results: made, or gone on with where an earlier run was interrupted");
  command.add_option(
      "--shard", options->shard,
      "k/n: each n-th run only, beginning with the k-th; `merge` puts them together");
  command.add_option("--jobs", options->jobs, "Runs at once; 0 is one for each core")
      .range(0, 1024);
  command.footer(
      "Examples:\n  seam sweep scenarios/sweep.yaml --out results.sqlite\n"
      "  seam sweep scenarios/sweep.yaml --shard 2/3 --out part2.sqlite\n"
      "Exit code 0 when all runs are finished, 1 when it was stopped, runs failed or an input is\n"
      "bad, 2 for wrong use. kill -9 loses no run that is finished; the same command goes on.");
#define SEAM_ADD(name) add_sweep_##name(command);
  SEAM_SWEEP_COMMANDS(SEAM_ADD)
#undef SEAM_ADD
  command.callback([options, command] {
    if (!command.has_chosen_subcommand()) sweep(*options);
  });
}

}  // namespace seam::tools
