// `seam sweep merge`: the shards of a plan as one file.
#include <fmt/ranges.h>

#include <cstdio>
#include <deque>
#include <filesystem>

#include "app/sweep/results.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "sim_core/signals/half_made.h"
#include "tools/sweep/sweep.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;

constexpr size_t kShownGaps = 10;

void require_like(const app::ResultsFile& first, const app::ResultsFile& other) {
  const auto refuse = [&](const char* what) {
    throw InputError(fmt::format("{} and {} do not go together: {}", first.path().string(),
                                 other.path().string(), what));
  };
  if (first.plan().fingerprint() != other.plan().fingerprint())
    refuse("they hold results of different plans");
  if (first.makers() != other.makers())
    refuse("different programs made them (`seam sweep status` shows which)");
}

// Made beside its place and renamed when it is whole.
struct Unfinished {
  explicit Unfinished(const fs::path& place) : path(place) {
    remove();
    for (const char* suffix : kSuffixes) half_made.emplace_back(path.string() + suffix);
  }
  ~Unfinished() { remove(); }
  void remove() const {
    std::error_code ignored;
    for (const char* suffix : kSuffixes) fs::remove(path.string() + suffix, ignored);
  }
  static constexpr const char* kSuffixes[] = {"", "-wal", "-shm", "-journal"};
  fs::path path;
  std::deque<HalfMade> half_made;
};

void merge(const std::vector<std::string>& files, const std::string& out) {
  if (files.empty()) throw UsageError("merge: give the results to put together");
  refuse_same_file(out, {files.begin(), files.end()});
  if (fs::exists(out))
    throw InputError(fmt::format("{}: is there already; give another --out or remove it", out));
  const auto first = app::ResultsFile::for_reading(files.front());
  const Unfinished unfinished(out + ".part");
  auto merged =
      app::ResultsFile::for_writing(unfinished.path, first.plan(), first.makers(), app::Shard{});
  for (const std::string& file : files) {
    const auto part = app::ResultsFile::for_reading(file);
    require_like(first, part);
    merged.take_over(part);
  }
  const std::vector<uint64_t> gaps = merged.missing(kShownGaps + 1);
  if (!gaps.empty())
    throw InputError(fmt::format(
        "the files lack runs of the plan: {}{}; make them first (`seam sweep PLAN --shard k/n`)",
        fmt::join(gaps.begin(), gaps.begin() + static_cast<long>(std::min(kShownGaps, gaps.size())),
                  ", "),
        gaps.size() > kShownGaps ? ", ..." : ""));
  const app::SweepCounts counts = merged.counts();
  merged.close();
  fs::rename(unfinished.path, out);
  std::printf("%s: %llu runs, %llu of them failed\n", out.c_str(),
              static_cast<unsigned long long>(counts.finished + counts.failed),
              static_cast<unsigned long long>(counts.failed));
}

}  // namespace

void add_sweep_merge(app::Command sweep) {
  app::Command command =
      sweep.add_subcommand("merge", "Puts the shards of a plan together into one file");
  auto files = std::make_shared<std::vector<std::string>>();
  auto out = std::make_shared<std::string>();
  command.add_option("RESULTS", *files, "Files of one plan, in any order").required();
  command.add_option("--out", *out, "The whole; must not be there yet").required();
  command.footer(
      "Refuses gaps, and runs that two files hold and that are not equal to the bit. Logs and\n"
      "frames of runs stay where they are.\n"
      "Example: seam sweep merge part1.sqlite part2.sqlite part3.sqlite --out whole.sqlite");
  command.callback([files, out] { merge(*files, *out); });
}

}  // namespace seam::tools
