// `seam sweep submit`: a plan for a cluster's own engine, as files that people read before they use
// them.
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "app/data_file.h"
#include "app/sweep/plan/plan.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "tools/sweep/sweep.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;

struct SweepSubmitOptions {
  std::string plan, out, folder;
  bool slurm = false, snakemake = false, only_write = false;
  int shards = 0, jobs = 2, minutes = 0;
};

// Everything absolute: a job starts where its scheduler likes.
struct Job {
  fs::path seam, plan, out, folder;
  int shards, jobs, minutes;
};

// A word as a POSIX shell takes it.
std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

// A word as Python takes it.
std::string python_text(const std::string& word) {
  std::string text = "\"";
  for (const char c : word) {
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text + '"';
}

std::string array_script(const Job& job) {
  const std::string time =
      job.minutes > 0 ? fmt::format("#SBATCH --time={}\n", job.minutes) : std::string();
  return fmt::format(
      "#!/bin/bash\n"
      "# A part of the plan in each task; one that is begun again goes on where it was.\n"
      "#SBATCH --job-name=seam-sweep\n"
      "#SBATCH --array=1-{0}\n"
      "#SBATCH --cpus-per-task={1}\n"
      "#SBATCH --requeue\n"
      "{2}"
      "set -euo pipefail\n"
      "cd {3}\n"
      "exec {4} sweep {5} --shard \"$SLURM_ARRAY_TASK_ID/{0}\" --jobs {1} \\\n"
      "  --out \"shard_$SLURM_ARRAY_TASK_ID.sqlite\"\n",
      job.shards, job.jobs, time, quoted(job.folder.string()), quoted(job.seam.string()),
      quoted(job.plan.string()));
}

std::string merge_script(const Job& job) {
  return fmt::format(
      "#!/bin/bash\n"
      "# When all parts are there: one file of them.\n"
      "#SBATCH --job-name=seam-merge\n"
      "#SBATCH --cpus-per-task=1\n"
      "set -euo pipefail\n"
      "cd {}\n"
      "shards=()\n"
      "for i in $(seq 1 {}); do shards+=(\"shard_$i.sqlite\"); done\n"
      "exec {} sweep merge \"${{shards[@]}}\" --out {}\n",
      quoted(job.folder.string()), job.shards, quoted(job.seam.string()), quoted(job.out.string()));
}

// A part's results are no output of its rule: Snakemake removes the outputs of what was
// interrupted, and with them the runs that are finished.
std::string snakefile(const Job& job) {
  return fmt::format(
      "# A part of the plan in each job; one that is begun again goes on where it was.\n"
      "#   snakemake --cores all        on this machine\n"
      "#   snakemake --profile NAME     on a cluster or in a cloud\n"
      "SEAM = {0}\n"
      "PLAN = {1}\n"
      "FOLDER = {2}\n"
      "RESULTS = {3}\n"
      "SHARDS = {4}\n"
      "\n"
      "rule all:\n"
      "    input: RESULTS\n"
      "\n"
      "rule shard:\n"
      "    input: PLAN\n"
      "    output: touch(FOLDER + \"/shard_{{k}}.done\")\n"
      "    params: seam=SEAM, part=lambda wildcards: f\"{{wildcards.k}}/{{SHARDS}}\",\n"
      "        results=lambda wildcards: f\"{{FOLDER}}/shard_{{wildcards.k}}.sqlite\"\n"
      "    threads: {5}\n"
      "    shell: \"{{params.seam:q}} sweep {{input:q}} --shard {{params.part}} --jobs {{threads}} "
      "--out {{params.results:q}}\"\n"
      "\n"
      "rule merge:\n"
      "    input: expand(FOLDER + \"/shard_{{k}}.done\", k=range(1, SHARDS + 1))\n"
      "    output: RESULTS\n"
      "    params: seam=SEAM,\n"
      "        parts=[f\"{{FOLDER}}/shard_{{k}}.sqlite\" for k in range(1, SHARDS + 1)]\n"
      "    shell: \"{{params.seam:q}} sweep merge {{params.parts:q}} --out {{output:q}}\"\n",
      python_text(job.seam.string()), python_text(job.plan.string()),
      python_text(job.folder.string()), python_text(job.out.string()), job.shards, job.jobs);
}

bool is_installed(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');)
    if (!folder.empty() && access((fs::path(folder) / program).c_str(), X_OK) == 0) return true;
  return false;
}

// `sbatch --parsable ...`: the number of the job that it made.
std::string sbatch(const std::string& arguments) {
  FILE* pipe = ::popen(("sbatch --parsable " + arguments).c_str(), "r");
  if (pipe == nullptr) throw InputError("sbatch cannot be started");
  std::string answer;
  char buffer[256];
  while (std::fgets(buffer, sizeof buffer, pipe) != nullptr) answer += buffer;
  const int status = ::pclose(pipe);
  // "NUMBER" or "NUMBER;CLUSTER".
  const std::string number = answer.substr(0, answer.find_first_not_of("0123456789"));
  if (status != 0 || number.empty())
    throw InputError(fmt::format("sbatch {} failed; its own message stands above", arguments));
  return number;
}

void submit_to_slurm(const Job& job, bool only_write) {
  const fs::path array = job.folder / "shards.sbatch", merge = job.folder / "merge.sbatch";
  write_file_atomically(array, array_script(job));
  write_file_atomically(merge, merge_script(job));
  std::printf("written: %s, %s\n", array.c_str(), merge.c_str());
  if (only_write || !is_installed("sbatch")) {
    std::printf("%s: to submit them\n  sbatch %s\n  sbatch --dependency=afterok:JOB %s\n",
                only_write ? "not submitted" : "not submitted, there is no sbatch here",
                quoted(array.string()).c_str(), quoted(merge.string()).c_str());
    return;
  }
  const std::string where = "--chdir " + quoted(job.folder.string()) + " ";
  const std::string shards = sbatch(where + quoted(array.string()));
  const std::string last =
      sbatch(where + "--dependency=afterok:" + shards + " " + quoted(merge.string()));
  std::printf("submitted: job array %s of %d tasks, then job %s, which writes %s\n", shards.c_str(),
              job.shards, last.c_str(), job.out.c_str());
}

void submit(const SweepSubmitOptions& options) {
  if (options.slurm == options.snakemake) throw UsageError("submit: give --slurm or --snakemake");
  refuse_same_file(options.out, {options.plan});
  const auto plan = app::SweepPlan::from_file(app::given_or_ours(options.plan));
  if (static_cast<uint64_t>(options.shards) > plan.runs())
    throw InputError(fmt::format("--shards {}: the plan has {} runs", options.shards, plan.runs()));
  const fs::path out = fs::absolute(options.out);
  const fs::path folder =
      options.folder.empty() ? fs::path(out.string() + ".shards") : fs::absolute(options.folder);
  make_output_folder(folder);
  const Job job{fs::read_symlink("/proc/self/exe"),
                fs::absolute(options.plan),
                out,
                folder,
                options.shards,
                options.jobs,
                options.minutes};
  if (options.slurm) return submit_to_slurm(job, options.only_write);
  const fs::path file = folder / "Snakefile";
  write_file_atomically(file, snakefile(job));
  std::printf("written: %s\n  snakemake --snakefile %s --cores all\n", file.c_str(),
              quoted(file.string()).c_str());
}

}  // namespace

void add_sweep_submit(app::Command sweep) {
  app::Command command =
      sweep.add_subcommand("submit", "Runs a plan on a cluster: a Slurm job array, or a Snakefile");
  auto options = std::make_shared<SweepSubmitOptions>();
  command.add_option("PLAN", options->plan, "A seam-sweep/1 file").required();
  command.add_option("--out", options->out, "The results of the whole").required();
  command.add_option("--shards", options->shards, "Parts, each a task").required().range(1, 100000);
  command.add_option("--jobs", options->jobs, "Runs at once in a task, and cores that it asks for")
      .range(1, 1024)
      .show_default();
  command.add_flag("--slurm", options->slurm,
                   "Writes a job array and a job that merges, and submits both where sbatch is");
  command.add_flag("--snakemake", options->snakemake, "Writes a Snakefile");
  command.add_flag("--only-write", options->only_write, "Submits nothing");
  command.add_option("--minutes", options->minutes, "Limit of a task's time; 0: the cluster's own")
      .range(0, 1000000);
  command.add_option("--folder", options->folder,
                     "For scripts and parts; left out: RESULTS.shards beside the results");
  command.footer(
      "Examples:\n  seam sweep submit scenarios/sweep.yaml --slurm --only-write --shards 4 --out "
      "whole.sqlite\n"
      "  seam sweep submit scenarios/sweep.yaml --snakemake --shards 4 --out whole.sqlite");
  command.callback([options] { submit(*options); });
}

}  // namespace seam::tools
