#include "app/sweep/kept_jobs.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "app/sweep/sweep_progress.h"
#include "app/sweep/workers.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

// What a worker says of a job: the first letter separates a result from an exception's message.
constexpr char kResult = '+', kThrown = '-';

std::string answer_of(const std::function<std::string(uint64_t)>& work, uint64_t job) {
  try {
    return kResult + work(job);
  } catch (const std::exception& error) {
    return kThrown + std::string(error.what());
  }
}

}  // namespace

KeptJobs::KeptJobs(JobsOptions options) : options_(std::move(options)) {}
KeptJobs::~KeptJobs() = default;

void KeptJobs::open() {
  kept_ = own_database(options_.file);
  Database& database = *kept_.database;
  const auto get = [&](const char* key) {
    return text_of(database.value("SELECT value FROM meta WHERE key = ?", {std::string(key)}));
  };
  const std::string tables = "SELECT count(*) FROM sqlite_master WHERE name IN ('meta', 'jobs')";
  if (kept_.has_tables &&
      (whole_of(database.value(tables)) != 2 || get("format") != options_.format))
    throw InputError(fmt::format("{}: holds something else than expected ({}): give another file",
                                 options_.file.string(), options_.format));
  write_ahead(database);
  if (!kept_.has_tables) {
    Transaction transaction(database);
    database.execute("CREATE TABLE meta(key TEXT PRIMARY KEY, value TEXT) WITHOUT ROWID");
    database.execute("CREATE TABLE jobs(job INTEGER PRIMARY KEY, result TEXT)");
    database.execute("INSERT INTO meta VALUES('format', ?)", {options_.format});
    database.execute("INSERT INTO meta VALUES('made_of', ?)", {options_.made_of});
    transaction.commit();
  }
  if (get("made_of") != options_.made_of)
    throw InputError(
        fmt::format("{}: holds results of other settings or of another program: give another file\n"
                    "  there: {}\n  now:   {}",
                    options_.file.string(), get("made_of"), options_.made_of));
}

bool KeptJobs::run(uint64_t first, uint64_t last, const std::function<std::string(uint64_t)>& work,
                   const std::function<void(uint64_t, const std::string&)>& done) {
  if (!options_.file.empty() && !kept_.database) open();
  std::vector<bool> finished(last - first, false);
  if (kept_.database) {
    kept_.database->query(
        "SELECT job, result FROM jobs WHERE typeof(job) = "
        "'integer' AND job >= ? AND job < ? ORDER BY job",
        {static_cast<int64_t>(first), static_cast<int64_t>(last)}, [&](const SqlRow& row) {
          const auto job = static_cast<uint64_t>(whole_of(row[0]));
          finished[job - first] = true;
          done(job, text_of(row[1]));
        });
  }
  const auto left = static_cast<uint64_t>(std::count(finished.begin(), finished.end(), false));
  SweepProgress progress(left, options_.what);
  uint64_t next = first;
  const auto fail = [&](uint64_t job, const std::string& how) {
    throw InputError(fmt::format("number {} of the {}: {}", job, options_.what, how));
  };
  const WorkerCalls calls{
      .next = [&]() -> std::optional<uint64_t> {
        while (next < last && finished[next - first]) ++next;
        return next < last ? std::optional(next++) : std::nullopt;
      },
      .work = [&](uint64_t job) { return answer_of(work, job); },
      .done =
          [&](uint64_t job, const std::string& result) {
            if (result.front() == kThrown) throw InputError(result.substr(1));
            const std::string text = result.substr(1);
            if (kept_.database)
              kept_.database->execute("INSERT INTO jobs VALUES(?, ?)",
                                      {static_cast<int64_t>(job), text});
            progress.count(false);
            done(job, text);
          },
      .died = [&](uint64_t job, const std::string& how) { fail(job, "its process " + how); },
      .tick = [&] { progress.show(); }};
  const int asked = options_.workers > 0 ? options_.workers : machine_cores();
  const int workers = static_cast<int>(std::min<uint64_t>(static_cast<uint64_t>(asked), left));
  cores_each_ = static_cast<size_t>(cores_for_each(workers));
  return run_in_workers(workers, calls);
}

}  // namespace seam::app
