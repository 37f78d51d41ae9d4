// `seam study`: how often diagnose is right, on many small sets with a known answer.
#include "measurement/study/study.h"

#include <fmt/format.h>

#include <memory>

#include "app/predictors/instruments.h"
#include "app/scratch_folder.h"
#include "app/sweep/kept_jobs.h"
#include "app/sweep/makers.h"
#include "measurement/numerics/parallel_for.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "tools/command.h"
#include "tools/commands/analysis.h"

namespace seam::tools {
namespace {

std::vector<double> numbers(const std::vector<std::string>& words, const char* option) {
  std::vector<double> all;
  for (const std::string& word : words) {
    try {
      all.push_back(ConfigNode::from_text(word, option).number());
    } catch (const InputError&) {
      throw UsageError(fmt::format("{} {}: expected a number", option, word));
    }
  }
  return all;
}

// What the sets are like, and what is hidden in all of them.
void add_conditions(app::Command command, measurement::StudyPlan& plan) {
  command.add_option("--hide", plan.hidden,
                     "Several effects hidden together, as in a model: "
                     "'{frame_latency: {latency_s: 0.02}, ...}'");
  command.add_option("--beside", plan.beside,
                     "Effects that the sets and the model both have, written like --hide");
  command
      .add_option("--material", plan.material,
                  "Noise units that matter, as diagnose has it (0.1 there); 0: how significance "
                  "alone does")
      .range(0.0, 1000.0)
      .show_default();
  measurement::Conditions& conditions = plan.conditions;
  command.add_option("--groups", conditions.groups, "As many groups of the protocol; 0: all")
      .range(0, 1000)
      .show_default();
  command.add_flag("--uneven", conditions.uneven, "Uneven time steps");
  command
      .add_option("--misfit", conditions.misfit,
                  "A smooth misfit of this size everywhere, in noise units")
      .range(0.0, 1000.0);
  command
      .add_option("--wander", conditions.wander,
                  "Errors that wander along each series, of this size in noise units")
      .range(0.0, 1000.0);
  command.add_flag("--bursts", conditions.bursts, "Outliers, three in a row, 1 % of the rows");
}

}  // namespace

void add_study(app::Command app) {
  app::Command command = app.add_subcommand(
      "study", "How often an effect is found, and false alarms: many small made sets, diagnosed");
  struct Flags {
    measurement::StudyPlan plan;
    std::vector<std::string> sizes, values;
    std::string json, results;
    int jobs = 0;
  };
  auto flags = std::make_shared<Flags>();
  command
      .add_option("KIND", flags->plan.kind,
                  "points, board, video, joints, odometry, landmarks, photometry or frames")
      .required();
  command.add_option("--seeds", flags->plan.seeds, "How many sets at each size")
      .range(1, 100000)
      .show_default();
  command
      .add_option("--first-seed", flags->plan.first_seed,
                  "Seed of the first set; the others follow")
      .show_default();
  command.add_option("--effect", flags->plan.effect,
                     "What is hidden in each set; left out: nothing, to count false alarms");
  command.add_option("--parameter", flags->plan.parameter,
                     "The parameter that is not neutral; left out: the effect's first");
  command.add_option("--size", flags->sizes,
                     "Its size in standard errors of such a set (once or more; left out: 5)");
  command.add_option("--value", flags->values, "Its value in its own unit, instead of a size");
  add_conditions(command, flags->plan);
  command.add_option("--json", flags->json, "Writes the result as JSON");
  command.add_option(
      "--results", flags->results,
      "Keeps each set's result in this SQLite file: the same command, or one of more "
      "--seeds, goes on where another ended");
  command.add_option("--jobs", flags->jobs, "Sets made at once; 0: one for each core")
      .range(0, 1024)
      .show_default();
  command.footer("Example: seam study points --effect frame_latency --size 2 --size 5 --seeds 3");
  command.callback([flags] {
    measurement::StudyPlan& plan = flags->plan;
    plan.sizes = numbers(flags->sizes, "--size"), plan.values = numbers(flags->values, "--value");
    if (plan.effect.empty() &&
        (!plan.sizes.empty() || !plan.values.empty() || !plan.parameter.empty()))
      throw UsageError("--size, --value and --parameter need --effect");
    if (!plan.effect.empty() && !plan.hidden.empty())
      throw UsageError("--hide stands in place of --effect");
    if (!plan.effect.empty() && plan.sizes.empty() && plan.values.empty()) plan.sizes = {5};
    OutputFile json(flags->json);
    const app::ScratchFolder scratch("study");
    plan.folder = scratch.path();
    plan.instruments = app::instruments();
    app::ProgramPrints prints;
    app::KeptJobs jobs({.file = flags->results,
                        .format = "seam-study-results/1",
                        .made_of = plan.text() + " by " + app::program_print(prints),
                        .what = "sets",
                        .workers = flags->jobs});
    const auto result = measurement::study(
        plan, [&](uint64_t first, uint64_t last, const auto& work, const auto& done) {
          const auto alone = [&](uint64_t job) {
            measurement::use_threads(jobs.cores_each());
            return work(job);
          };
          return jobs.run(first, last, alone, done);
        });
    std::fputs(measurement::study_text(plan, result).c_str(), stdout);
    if (json) json.fill(measurement::study_json(plan, result));
  });
}

}  // namespace seam::tools
