// The results of a sweep: one SQLite file that holds the plan with all that it names, what made the
// runs, and a row a run. A run is in it whole or not at all, and once.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/sweep/database.h"
#include "app/sweep/plan/plan.h"

namespace seam::app {

// Which runs of a plan one file holds: those whose number leaves the remainder `part - 1` when
// divided by `parts`.
struct Shard {
  uint64_t part = 1, parts = 1;

  bool has(uint64_t run) const { return run % parts == part - 1; }
  uint64_t runs_of(uint64_t all) const { return (all + parts - part) / parts; }
  bool operator==(const Shard&) const = default;
};
std::string to_string(const Shard& shard);
// "k/n"; throws UsageError for anything else.
Shard shard_from_text(const std::string& text);

// What the bits of runs depend on beside the plan.
struct Makers {
  std::string version;     // Of SEAM.
  std::string program;     // Fingerprint of this program with its plugins.
  std::string behaviours;  // Of the behaviours' programs and of files among their arguments.
  bool operator==(const Makers&) const = default;
};

struct RunRecord {
  uint64_t run = 0;
  std::string key;  // Fingerprint of all that the run depends on.
  // Empty: it went as it should. Else why not, and in further lines what its behaviours printed
  // last.
  std::string error;
  int64_t seed = 0;
  std::string end;  // finished, aborted; empty where it did not begin.
  double sim_s = 0;
  double wall_s = 0;  // From its scenario on: making the world and its pictures ready counts.
  uint64_t frames = 0, decisions = 0;
  std::string fingerprint;
  std::optional<int> red_score, blue_score;
  std::vector<std::optional<double>> kept;  // Values and formulas; nothing: not a number.

  // Not kept in results: values of the plan that nobody logged, each with its place in the plan;
  // decisions that were refused and targets that were clamped. For people.
  std::vector<std::string> unlogged, notes;

  bool failed() const { return !error.empty(); }
};
// Whether two records say the same to the bit; time on the wall does not count.
bool same_result(const RunRecord& a, const RunRecord& b);

struct SweepCounts {
  uint64_t planned = 0;  // Of the file's shard.
  uint64_t finished = 0;
  uint64_t failed = 0;
  double wall_s = 0;  // Of all runs in it together.
};

class ResultsFile {
 public:
  // Makes the file, or opens one of the same plan, makers and shard; any other is refused in
  // words. Nobody else writes it meanwhile.
  static ResultsFile for_writing(const std::filesystem::path& file, const SweepPlan& plan,
                                 const Makers& makers, const Shard& shard);
  static ResultsFile for_reading(const std::filesystem::path& file);
  ResultsFile(ResultsFile&&) noexcept;
  ~ResultsFile();

  const SweepPlan& plan() const { return *plan_; }
  const Makers& makers() const { return makers_; }
  const Shard& shard() const { return shard_; }
  const std::filesystem::path& path() const { return path_; }

  void add(const RunRecord& record);  // Replaces an earlier failure of the run.
  std::vector<bool> finished() const;
  SweepCounts counts() const;
  std::optional<RunRecord> record(uint64_t run) const;
  // In the order of the plan.
  void each(const std::function<void(const RunRecord&)>& take) const;
  // All records of `other` that this file lacks; throws InputError where a run of both differs.
  // Where one of them failed, the other counts.
  void take_over(const ResultsFile& other);
  // Runs of the plan that are not in it, at most `most` of them.
  std::vector<uint64_t> missing(size_t most) const;
  // The last write is done: a single file, which may be copied.
  void close();

 private:
  ResultsFile(std::filesystem::path path, std::unique_ptr<Database> database);
  void create(const SweepPlan& plan, const Makers& makers, const Shard& shard);
  // A plan that is known need not be worked out again.
  void read_head(const SweepPlan* known);
  std::vector<std::string> columns() const;

  // Held as long as the file is written; released after the database is closed.
  std::unique_ptr<WriterLock> lock_;
  std::filesystem::path path_;
  std::unique_ptr<Database> database_;
  std::optional<SweepPlan> plan_;
  Makers makers_;
  Shard shard_;
};

}  // namespace seam::app
